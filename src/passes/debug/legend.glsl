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

// Counts on a logarithmic scale: 1, 2, 4 … 256 and more.
float count_level(uint count) { return count == 0u ? 0.0 : (log2(float(count)) + 1.0) / float(DEBUG_COUNT_PARTS); }

// Their legend in the lower left corner of a picture: ten boxes, 0 and powers of two.
bool count_legend(ivec2 pixel, ivec2 size, out vec3 color) {
    int scale = max(1, size.y / 360);
    ivec2 p = ivec2(pixel.x, pixel.y - (size.y - 14 * scale)) / scale;
    if (pixel.y < size.y - 14 * scale || p.x >= 160) return false;
    int box_index = p.x / 16;
    uint value = box_index == 0 ? 0u : 1u << uint(box_index - 1);
    color = value == 0u ? vec3(0.0) : heat(count_level(value));
    ivec2 q = ivec2(p.x - box_index * 16 - 2, p.y - 5);
    uint hundreds = value / 100u, tens = value / 10u % 10u, ones = value % 10u;
    bool ink = digit_pixel(ones, q - ivec2(8, 0)) || (value >= 10u && digit_pixel(tens, q - ivec2(4, 0))) ||
               (value >= 100u && digit_pixel(hundreds, q));
    if (ink) color = dot(color, vec3(0.2126, 0.7152, 0.0722)) > 0.4 ? vec3(0.0) : vec3(1.0);
    return true;
}

#endif
