// SPDX-License-Identifier: MIT
// What the passes of denoise.h share.
#ifndef DENOISE_GLSL
#define DENOISE_GLSL

#include "common.glsl"
#include "view.glsl"

layout(buffer_reference) buffer denoise_count_block;
#include "passes/shadow/denoise_shared.h"
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer denoise_count_block { gpu_denoise_counts counts; };

// A direction in 24 bits, which a float holds exactly.
float pack_direction(vec3 n) {
    vec2 e = round(octahedral_encode(n) * 2047.0 + 2048.0);
    return e.x * 4096.0 + e.y;
}
vec3 unpack_direction(float packed) {
    float x = floor(packed / 4096.0);
    return octahedral_decode((vec2(x, packed - x * 4096.0) - 2048.0) / 2047.0);
}

// The part of the light that is seen.
float part_seen(vec3 seen, vec3 drawn) {
    float all = luminance(drawn);
    return all > 0.0 ? min(luminance(seen) / all, 1.0) : 1.0;
}

// A pixel's surface, in view space but for the normal.
struct denoise_place {
    bool is;
    vec3 position;
    vec3 normal;
};

denoise_place place_of(view_block v, vec4 stored, ivec2 p) {
    denoise_place a;
    a.is = stored.x > 0.0;
    a.position = view_position_of(v, ndc_of_pixel(v, vec2(p) + 0.5), stored.x);
    a.normal = unpack_direction(stored.y);
    return a;
}

// How much two places are one surface, 0 .. 1: b lies in the plane through a across `flat_normal` (view space), as far as pixels of that width
// can tell, and faces where a does. Schied et al. 2017, with a plane in place of the slope of depth.
float alike(denoise_place a, vec3 flat_normal, denoise_place b, float pixel) {
    if (!b.is) return 0.0;
    vec3 way = b.position - a.position;
    float off = abs(dot(flat_normal, way)) / (pixel + 0.1 * length(way));
    return exp(-off) * pow(max(dot(a.normal, b.normal), 0.0), DENOISE_POWER);
}

#endif
