// SPDX-License-Identifier: MIT
// Points of what a multisampled G-buffer shows.
#ifndef EDGES_GLSL
#define EDGES_GLSL

#include "passes/shade/edges_shared.h"
#include "passes/shade/samples.glsl"

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

#endif
