// SPDX-License-Identifier: MIT
// What scales of debug views are drawn with.
#ifndef DEBUG_LEGEND_GLSL
#define DEBUG_LEGEND_GLSL

#include "passes/debug/colors_shared.h"

// Over 0..1, by linear pieces between the colours of the ramp.
vec3 heat(float t) {
    const vec3 stops[DEBUG_RAMP_STOPS] = vec3[](DEBUG_RAMP(vec3));
    float x = clamp(t, 0.0, 1.0) * float(DEBUG_RAMP_STOPS - 1);
    int i = min(int(x), DEBUG_RAMP_STOPS - 2);
    return mix(stops[i], stops[i + 1], x - float(i)) / 255.0;
}

// 3x5 digits, three bits a row from the top.
const uint digits[10] = uint[](0x7b6fu, 0x2c97u, 0x73e7u, 0x73cfu, 0x5bc9u, 0x79cfu, 0x79efu, 0x7249u, 0x7befu, 0x7bcfu);

bool digit_pixel(uint digit, ivec2 p) {
    return all(greaterThanEqual(p, ivec2(0))) && p.x < 3 && p.y < 5 && (digits[digit] >> uint((4 - p.y) * 3 + 2 - p.x) & 1u) == 1u;
}

#endif
