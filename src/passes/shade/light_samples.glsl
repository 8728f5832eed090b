// SPDX-License-Identifier: MIT
// The light passes' surfaces where pixels have several samples. A surface of a pixel (edges.glsl) is lit at the middle of its samples.
#ifndef LIGHT_SAMPLES_GLSL
#define LIGHT_SAMPLES_GLSL

#include "gbuffer.glsl"
#include "passes/shade/edges.glsl"
#include "passes/shade/light_prepass.glsl"

// What surface_point() reads of a G-buffer.
gpu_gbuffer light_samples_depth(gpu_light_surfaces from) {
    gpu_gbuffer depth;
    depth.depth = from.depth;
    return depth;
}

// The surface that `samples` show.
light_surface light_samples_surface(view_block v, gpu_light_surfaces from, ivec2 pixel, uint samples, out float view_depth) {
    vec3 point = surface_point(v, light_samples_depth(from), pixel, samples, view_depth);
    return light_surface_of(from, pixel, findLSB(samples), (v.view.view_to_world * vec4(point, 1.0)).xyz);
}

// Which of a pixel's surfaces a fragment is of, by what the first pass has left of it: among those at samples that its triangle covers the
// one most like it, in normal, roughness and, in pixels, by its distance from the plane. The first pass has drawn the same fragment, and
// found the same, wherever it is not hidden; so only what rounds decides nothing here, and light does not bleed over silhouettes.
uint light_samples_choose(view_block v, gpu_light_surfaces from, uint word, ivec2 pixel, uint covered, surface own) {
    if (!surface_is_edge(word)) return 0u;
    uint best = 0u, seen = 0u;
    float least = 3e38;
    for (uint i = 0u; i < SAMPLES; i++) {
        uint k = surface_of(word, i);
        if ((covered >> i & 1u) == 0u || k == SURFACE_NONE || (seen >> k & 1u) == 1u) continue;
        seen |= 1u << k;
        float view_depth;
        light_surface s = light_samples_surface(v, from, pixel, surface_samples(word, k), view_depth);
        float unlike = distance(s.normal, own.normal) + abs(s.roughness - own.roughness) +
                       abs(dot(own.normal, s.position - own.position)) / (8.0 * pixel_width(v, view_depth));
        if (!(unlike < least)) continue;
        least = unlike;
        best = k;
    }
    return best;
}

#endif
