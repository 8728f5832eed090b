// SPDX-License-Identifier: MIT
// Pictures and their edges as bits, for the passes of morphological.h. Axis 0: lines along x, edges to the pixel above; axis 1: lines
// along y, edges to the pixel on the left. With the axes changing places everything else is the same.
#ifndef MORPHOLOGICAL_GLSL
#define MORPHOLOGICAL_GLSL

#include "common.glsl"
#include "passes/aa/morphological_shared.h"

layout(push_constant, scalar) uniform push_block { gpu_morphological_push push; };

ivec2 picture_size() { return ivec2(push.width, push.height); }
vec4 picture_at(ivec2 p) { return texelFetch(textures[push.picture], p, 0); }

vec3 srgb_decode(vec3 c) {
    return mix(c / 12.92, pow((max(c, vec3(0.04045)) + 0.055) / 1.055, vec3(2.4)), greaterThan(c, vec3(0.04045)));
}

// What the eye sees of a colour, 0..1.
vec3 perceived(vec4 c) {
    vec3 rgb = push.swap == 1u ? c.bgr : c.rgb;
    if (push.linear == 0u) return rgb;
    rgb = max(rgb, vec3(0.0));
    return srgb_encode(rgb / (1.0 + max_component(rgb)));
}

// What is blended: linear light.
vec4 to_light(vec4 c) { return push.linear == 1u ? c : vec4(srgb_decode(c.rgb), c.a); }
vec4 from_light(vec4 c) { return push.linear == 1u ? c : vec4(srgb_encode(clamp(c.rgb, 0.0, 1.0)), c.a); }

// ---- bits ----

uint row_words() { return (push.width + 31u) / 32u; }
uint column_words() { return (push.height + 31u) / 32u; }
// First word of the array with the edges along an axis, and of that with the edges that cross it, both packed along it.
uint along_start(int axis) { return axis == 0 ? 0u : push.height * row_words(); }
uint across_start(int axis) {
    uint both = push.height * row_words() + push.width * column_words();
    return axis == 0 ? both : both + push.height * row_words();
}
int line_length(int axis) { return axis == 0 ? int(push.width) : int(push.height); }
int line_count(int axis) { return axis == 0 ? int(push.height) : int(push.width); }
uint line_words(int axis) { return axis == 0 ? row_words() : column_words(); }

// 32 edges of the line between pixel rows (columns) `line` - 1 and `line`.
uint along_word(int axis, int line, int word) { return push.edges.at[along_start(axis) + uint(line) * line_words(axis) + uint(word)]; }
// 32 edges across row (column) `line`; bit i is before its pixel i.
uint across_word(int axis, int line, int word) {
    if (line < 0 || line >= line_count(axis)) return 0u;
    return push.edges.at[across_start(axis) + uint(line) * line_words(axis) + uint(word)];
}

bool along(int axis, int line, int at) {
    if (line < 0 || at < 0 || line >= line_count(axis) || at >= line_length(axis)) return false;
    return (along_word(axis, line, at >> 5) >> uint(at & 31) & 1u) == 1u;
}
bool across(int axis, int line, int at) {
    if (at < 0 || at >= line_length(axis)) return false;
    return (across_word(axis, line, at >> 5) >> uint(at & 31) & 1u) == 1u;
}

// ---- areas ----

// Area within [k, k + 1] under the line from height 0.5 at 0 to height 0 at `half_length`.
float area_under(float half_length, float k) {
    float from = min(k, half_length), to = min(k + 1.0, half_length);
    return (to - from) * (0.5 - 0.25 * (from + to) / half_length);
}

// ---- blending ----

// Weights of the pixels above, below, on the left and on the right. Opposite sides add up; of the axes the stronger one counts.
vec4 blended(ivec2 p, vec4 self, vec4 weights) {
    bool upright = weights.x + weights.y >= weights.z + weights.w - 1e-4; // a tie is one in all arithmetic
    vec2 w = upright ? weights.xy : weights.zw;
    if (w.x + w.y <= 0.0) return self;
    ivec2 step = upright ? ivec2(0, 1) : ivec2(1, 0), last = picture_size() - 1;
    vec4 before = to_light(picture_at(max(p - step, ivec2(0)))), after = to_light(picture_at(min(p + step, last)));
    return from_light(to_light(self) * (1.0 - w.x - w.y) + before * w.x + after * w.y);
}

#endif
