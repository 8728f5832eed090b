#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Finds the edges of a picture. A group packs 32 x 32 pixels.
#include "passes/aa/morphological.glsl"

layout(constant_id = 0) const uint KIND = GPU_EDGES_COLOR;
layout(local_size_x = 32, local_size_y = 8) in;

shared uint bits[4][32]; // in the order of the arrays

vec3 seen(ivec2 p) { return perceived(picture_at(clamp(p, ivec2(0), picture_size() - 1))); }
float luma(ivec2 p) { return luminance(seen(p)); }

// x: to the left, y: to above. Beyond the border the picture goes on as it ends, so there is no edge at it.
bvec2 color_edges(ivec2 p) {
    vec3 self = seen(p);
    return bvec2(max_component(abs(self - seen(p - ivec2(1, 0)))) > MORPHOLOGICAL_THRESHOLD,
                 max_component(abs(self - seen(p - ivec2(0, 1)))) > MORPHOLOGICAL_THRESHOLD);
}

// Where one edge beside is more than twice as strong, that one is what is seen.
bvec2 luma_edges(ivec2 p) {
    float self = luma(p), left = luma(p - ivec2(1, 0)), top = luma(p - ivec2(0, 1));
    vec2 delta = abs(vec2(left, top) - self);
    if (max(delta.x, delta.y) <= MORPHOLOGICAL_THRESHOLD) return bvec2(false);
    vec2 others = abs(vec2(luma(p + ivec2(1, 0)), luma(p + ivec2(0, 1))) - self);
    vec2 further = abs(vec2(luma(p - ivec2(2, 0)), luma(p - ivec2(0, 2))) - vec2(left, top));
    vec2 strongest = max(max(delta, others), further);
    float limit = 0.5 * max(strongest.x, strongest.y) - 1e-4; // exactly twice is not more
    return bvec2(delta.x > MORPHOLOGICAL_THRESHOLD && delta.x >= limit, delta.y > MORPHOLOGICAL_THRESHOLD && delta.y >= limit);
}

void main() {
    if (gl_LocalInvocationIndex < 128u) bits[gl_LocalInvocationIndex >> 5u][gl_LocalInvocationIndex & 31u] = 0u;
    barrier();
    uint x = gl_LocalInvocationID.x;
    for (uint i = 0u; i < 4u; i++) {
        uint y = gl_LocalInvocationID.y + i * 8u;
        ivec2 p = ivec2(gl_WorkGroupID.xy * 32u + uvec2(x, y));
        if (any(greaterThanEqual(p, picture_size()))) continue;
        bvec2 edges = KIND == GPU_EDGES_LUMA ? luma_edges(p) : color_edges(p);
        if (edges.y) {
            atomicOr(bits[0][y], 1u << x);
            atomicOr(bits[3][x], 1u << y);
        }
        if (edges.x) {
            atomicOr(bits[1][x], 1u << y);
            atomicOr(bits[2][y], 1u << x);
        }
    }
    barrier();
    if (gl_LocalInvocationIndex >= 128u) return;
    uint kind = gl_LocalInvocationIndex >> 5u, place = gl_LocalInvocationIndex & 31u;
    bool by_rows = kind == 0u || kind == 2u;
    uint line = (by_rows ? gl_WorkGroupID.y : gl_WorkGroupID.x) * 32u + place;
    uint word = by_rows ? gl_WorkGroupID.x : gl_WorkGroupID.y;
    int axis = by_rows ? 0 : 1;
    if (int(line) >= line_count(axis)) return;
    uint start = kind < 2u ? along_start(axis) : across_start(axis);
    push.edges.at[start + line * line_words(axis) + word] = bits[kind][place];
}
