// SPDX-License-Identifier: MIT
// The words that edges_find.comp.glsl writes, and where samples lie.
#ifndef EDGES_GLSL
#define EDGES_GLSL

#include "passes/shade/edges_shared.h"

layout(constant_id = 9) const uint SAMPLES = 4u;

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

// The point at which a pixel's surface is lit: at the middle of its samples, on the plane that they lie in if they lie in one, since stored
// depth is linear in the picture. Where all samples show it that is the pixel's centre, as in forward shading.
vec3 surface_point(view_block v, gpu_gbuffer from, ivec2 pixel, uint samples, out float view_depth) {
    vec2 at = vec2(0.0);
    float depth = 0.0, part = 1.0 / float(bitCount(samples));
    for (uint i = 0u; i < SAMPLES; i++) {
        if ((samples >> i & 1u) == 0u) continue;
        at += sample_place(i);
        depth += gbuffer_depth(from, pixel, int(i));
    }
    view_depth = view_depth_of(v, depth * part);
    return view_position_of(v, ndc_of_pixel(v, vec2(pixel) + at * part), view_depth);
}

// Metres that a pixel is wide at a view depth.
float pixel_width(view_block v, float view_depth) {
    vec2 size = 2.0 * abs(v.view.ndc_scale) * v.view.inverse_size * (v.view.orthographic > 0.5 ? 1.0 : view_depth);
    return max(size.x, size.y);
}

#endif
