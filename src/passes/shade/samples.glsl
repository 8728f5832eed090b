// SPDX-License-Identifier: MIT
// The words that tell which samples of a pixel show the same surface, where samples lie, and what surfaces are shaded to.
#ifndef SAMPLES_GLSL
#define SAMPLES_GLSL

#include "common.glsl"
#include "passes/shade/samples_shared.h"

#ifndef SAMPLES_AT
#define SAMPLES_AT SAMPLES_ID
#endif
layout(constant_id = SAMPLES_AT) const uint SAMPLES = 4u;

uint surface_of(uint word, uint at) { return word >> (SURFACE_BITS * at) & SURFACE_NONE; }

// The samples that show a surface, a bit each.
uint surface_samples(uint word, uint surface_index) {
    uint bits = 0u;
    for (uint i = 0u; i < SAMPLES; i++)
        if (surface_of(word, i) == surface_index) bits |= 1u << i;
    return bits;
}

const uint EVERY_SAMPLE = (1u << SAMPLES) - 1u;

bool surface_is_edge(uint word) { return surface_samples(word, surface_of(word, 0u)) != EVERY_SAMPLE; }

uint surface_count(uint word) {
    uint count = 0u;
    for (uint i = 0u; i < SAMPLES; i++)
        if (surface_of(word, i) != SURFACE_NONE) count = max(count, surface_of(word, i) + 1u);
    return count;
}

// Vulkan's standard sample locations, in sixteenths of a pixel from its corner.
vec2 sample_place(uint at) {
    const uint two[2] = uint[](0xccu, 0x44u), four[4] = uint[](0x26u, 0x6eu, 0xa2u, 0xeau);
    const uint eight[8] = uint[](0x59u, 0xb7u, 0x9du, 0x35u, 0xd3u, 0x71u, 0xfbu, 0x1fu);
    uint place = SAMPLES == 2u ? two[at & 1u] : SAMPLES == 4u ? four[at & 3u] : eight[at & 7u];
    return vec2(place & 15u, place >> 4) / 16.0;
}

#ifndef FLOATS_AT
#define FLOATS_AT FLOATS_ID
#endif
layout(constant_id = FLOATS_AT) const uint FLOATS = 0u; // 1: results are floats

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer half_results { uvec2 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer float_results { vec3 at[]; };

vec3 result_at(uint_array results, uint index) {
    if (FLOATS == 1u) return float_results(results).at[index];
    uvec2 words = half_results(results).at[index];
    return vec3(unpackHalf2x16(words.x), unpackHalf2x16(words.y).x);
}

void store_result(uint_array results, uint index, vec3 radiance) {
    if (FLOATS == 1u)
        float_results(results).at[index] = radiance;
    else
        half_results(results).at[index] = uvec2(packHalf2x16(radiance.rg), packHalf2x16(vec2(radiance.b, 0.0)));
}

#endif
