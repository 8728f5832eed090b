// SPDX-License-Identifier: MIT
// Texels of a cube map in a buffer (environment_maps_shared.h), four halves each.
#ifndef ENVIRONMENT_TEXELS_GLSL
#define ENVIRONMENT_TEXELS_GLSL

#include "common.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 8) buffer texel_array { uvec2 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer radiance_array { vec3 at[]; };
layout(buffer_reference) buffer environment_block;
#include "environment_shared.h"
#include "passes/ambient/environment_maps_shared.h"
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer environment_block { gpu_environment light; };

uvec2 texel_pack(vec3 color) {
    vec3 held = min(color, vec3(HALF_MAX));
    return uvec2(packHalf2x16(held.xy), packHalf2x16(vec2(held.z, 1.0)));
}
vec3 texel_unpack(uvec2 texel) { return vec3(unpackHalf2x16(texel.x), unpackHalf2x16(texel.y).x); }

// What fractions are multiplied by where the largest component has these bits: then it is half of what a half holds, or a quarter. 1 for black.
float texel_unit(uint peak_bits) {
    int exponent = int(peak_bits >> 23u) - 127;
    return peak_bits == 0u ? 1.0 : exp2(float(clamp(exponent - 14, -126, 126)));
}

// A point of a face, out to the square that `u` and `v` (-1 .. 1, right and down) span; not unit.
vec3 face_point(uint face, float u, float v) {
    switch (face) {
    case 0u: return vec3(1.0, -v, -u);
    case 1u: return vec3(-1.0, -v, u);
    case 2u: return vec3(u, 1.0, v);
    case 3u: return vec3(u, -1.0, -v);
    case 4u: return vec3(u, -v, 1.0);
    default: return vec3(-u, -v, -1.0);
    }
}

// Where in its face a texel of a mip is; false beyond the last.
bool texel_place(uint index, uint side, out uint face, out uvec2 at) {
    face = index / (side * side);
    uint rest = index % (side * side);
    at = uvec2(rest % side, rest / side);
    return face < 6u;
}

// Points of a sequence that fills the square evenly (Hammersley).
vec2 even_point(uint index, uint count) { return vec2((float(index) + 0.5) / float(count), float(bitfieldReverse(index)) * 2.3283064365386963e-10); }

#endif
