// SPDX-License-Identifier: MIT
// What scales of debug views are drawn with.
#ifndef DEBUG_LEGEND_GLSL
#define DEBUG_LEGEND_GLSL

// Viridis over 0..1, by linear pieces between nine of its colours: brighter is more, for all kinds of colour vision and in grey.
// S. van der Walt and N. Smith, matplotlib 1.5, 2015 (CC0).
vec3 heat(float t) {
    const vec3 stops[9] = vec3[](vec3(68, 1, 84), vec3(71, 45, 123), vec3(59, 82, 139), vec3(44, 114, 142), vec3(33, 144, 140),
                                 vec3(39, 173, 129), vec3(93, 200, 99), vec3(170, 220, 50), vec3(253, 231, 37));
    float x = clamp(t, 0.0, 1.0) * 8.0;
    int i = min(int(x), 7);
    return mix(stops[i], stops[i + 1], x - float(i)) / 255.0;
}

// 3x5 digits, three bits a row from the top.
const uint digits[10] = uint[](0x7b6fu, 0x2c97u, 0x73e7u, 0x73cfu, 0x5bc9u, 0x79cfu, 0x79efu, 0x7249u, 0x7befu, 0x7bcfu);

bool digit_pixel(uint digit, ivec2 p) {
    return all(greaterThanEqual(p, ivec2(0))) && p.x < 3 && p.y < 5 && (digits[digit] >> uint((4 - p.y) * 3 + 2 - p.x) & 1u) == 1u;
}

#endif
