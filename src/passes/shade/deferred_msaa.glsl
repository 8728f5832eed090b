// SPDX-License-Identifier: MIT
// What shading and spreading share: where results are.
#include "common.glsl"
#include "gbuffer.glsl"
#include "lights/iterate.glsl"
#include "passes/shade/edges.glsl"
#include "passes/shade/deferred_msaa_shared.h"

layout(constant_id = 10) const uint METHOD = MSAA_ALL;
layout(constant_id = 11) const uint FLOATS = 0u; // 1: results are floats

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

// The surface that shows at most samples of a pixel, the first of several.
uint widest_surface(uint word) {
    uint widest = 0u, most = 0u;
    for (uint i = 0u; i < SAMPLES; i++) {
        uint count = uint(bitCount(surface_samples(word, i)));
        if (count <= most) continue;
        most = count;
        widest = i;
    }
    return widest;
}
