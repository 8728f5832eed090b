#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Morphological antialiasing: blends each pixel by the lines of edges on its four sides (morphological.h).
#include "passes/aa/morphological.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

// First and last edge of the line that holds the edge `at`.
ivec2 ends_of(int axis, int line, int at) {
    int word = at >> 5;
    uint gaps = ~along_word(axis, line, word) & (1u << uint(at & 31)) - 1u;
    while (gaps == 0u && word > 0) gaps = ~along_word(axis, line, --word);
    int first = gaps == 0u ? 0 : word * 32 + findMSB(gaps) + 1;
    word = at >> 5;
    gaps = ~along_word(axis, line, word) & ~((2u << uint(at & 31)) - 1u);
    // Beyond the picture there are no edges, so the last word ends in gaps, unless it is full.
    while (gaps == 0u && word + 1 < int(line_words(axis))) gaps = ~along_word(axis, line, ++word);
    int last = gaps == 0u ? line_length(axis) - 1 : word * 32 + findLSB(gaps) - 1;
    return ivec2(first, last);
}

// On which side an end is crossed: 0 neither or both, -1 before the line, 1 behind it.
int crossing(int axis, int line, int at) {
    return int(across(axis, line, at)) - int(across(axis, line - 1, at));
}

// Weight of the pixel at `at` on one side (-1 before the line, 1 behind it).
float weight_of(int axis, int line, int at, int side) {
    if (!along(axis, line, at)) return 0.0;
    ivec2 ends = ends_of(axis, line, at);
    float half_length = 0.5 * float(ends.y - ends.x + 1), weight = 0.0;
    if (crossing(axis, line, ends.x) == side) weight += area_under(half_length, float(at - ends.x));
    if (crossing(axis, line, ends.y + 1) == side) weight += area_under(half_length, float(ends.y - at));
    return weight;
}

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, picture_size()))) return;
    vec4 weights = vec4(weight_of(0, p.y, p.x, 1), weight_of(0, p.y + 1, p.x, -1), weight_of(1, p.x, p.y, 1),
                        weight_of(1, p.x + 1, p.y, -1));
    imageStore(images[push.target], p, blended(p, picture_at(p), weights));
}
