#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Deferred shading of several samples a pixel (deferred_msaa.h). Samples of one surface are lit at the surface's point, so that it does not
// matter which of them a method shades.
#include "shade.glsl"
#include "passes/shade/deferred_msaa.glsl"

layout(constant_id = MSAA_STEP_ID) const uint STEP = MSAA_STEP_FIRST;
layout(constant_id = MSAA_MERGED_ID) const uint MERGED = 0u; // 1: samples of a surface may store different things

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_deferred_msaa_push push; };

shared uint tile_is_edge;

vec3 stored_emission(ivec2 pixel, int at) { return texelFetch(textures_multisampled[push.radiance], pixel, at).rgb; }

// One surface for many: means of what its samples hold. Where their normals differ the highlight of an aggregate widens: the spread of
// normals of mean length r is that of a von Mises-Fisher lobe of kappa = r (3 - r^2) / (1 - r^2) (Banerjee et al. 2005), whose slopes
// vary by
// about 1 / kappa; twice that is added to the squared roughness of the microfacets (Hill and Baker 2012, "Rock-Solid Shading").
surface mean_surface(ivec2 pixel, uint samples, vec3 position) {
    surface mean = gbuffer_surface(push.gbuffer, pixel, findLSB(samples), position, vec3(0.0));
    vec3 first_normal = mean.normal, normal = vec3(0.0);
    vec4 color = vec4(0.0), f0 = vec4(0.0), others = vec4(0.0);
    vec3 emissive = vec3(0.0);
    vec2 strengths = vec2(0.0); // of the coat and of the anisotropy
    float part = 1.0 / float(bitCount(samples));
    for (uint i = 0u; i < SAMPLES; i++) {
        if ((samples >> i & 1u) == 0u) continue;
        surface s = gbuffer_surface(push.gbuffer, pixel, int(i), position, stored_emission(pixel, int(i)));
        normal += s.normal * part;
        color += vec4(s.base_color, s.metallic) * part;
        f0 += vec4(s.dielectric_f0, s.dielectric_f90) * part;
        float alpha = alpha_of(s.roughness);
        others += vec4(alpha * alpha, s.occlusion, 0.0, 0.0) * part;
        emissive += s.emissive * part;
        if (!s.layered) continue;
        if (!mean.layered) mean.layers = s.layers;
        mean.layered = true;
        strengths += vec2(s.layers.clearcoat, s.layers.anisotropy) * part;
    }
    if (mean.layered) {
        mean.layers.clearcoat = strengths.x;
        mean.layers.anisotropy = strengths.y;
    }
    float r2 = min(dot(normal, normal), 1.0), r = sqrt(r2);
    // Below that length only rounding differs.
    if (METHOD == MSAA_AGGREGATE && r2 < 0.99999) others.x += 2.0 * (1.0 - r2) / max(r * (3.0 - r2), 1e-4);
    mean.normal = r > 1e-3 ? normal / r : first_normal;
    if (r2 < 0.99999) mean.geometric = vec3(0.0);
    mean.base_color = color.rgb;
    mean.metallic = color.a;
    mean.dielectric_f0 = f0.rgb;
    mean.dielectric_f90 = f0.a;
    mean.roughness = r2 < 0.99999 ? min(sqrt(sqrt(others.x)), 1.0) : mean.roughness;
    mean.occlusion = others.y;
    mean.emissive = emissive;
    return mean;
}

void shade_samples(ivec2 pixel, uint samples, uint result) {
    float view_depth;
    vec3 point = surface_point(push.view, push.gbuffer, pixel, samples, view_depth);
    vec3 position = (push.view.view.view_to_world * vec4(point, 1.0)).xyz;
    int first = findLSB(samples);
    surface s = MERGED == 1u
                    ? mean_surface(pixel, samples, position)
                    : gbuffer_surface(push.gbuffer, pixel, first, position, stored_emission(pixel, first));
    vec3 radiance = shade_surface(s, push.view, push.lighting, push.counters, uvec2(pixel), view_depth, LIGHT_NO_ITEM);
    store_result(push.results, result, min(radiance, vec3(push.view.view.frame.frame.hdr_max)));
    if (COUNT_LIGHTS == 1u) atomicAdd(push.counts.at[EDGES_SHADED], 1u);
}

// The samples of a pixel that are shaded together with one of them; none where an earlier one does that.
uint samples_with(uint word, uint at) {
    uint surface_index = surface_of(word, at);
    return surface_index == SURFACE_NONE ? 0u : surface_samples(word, surface_index);
}

// Compilers put a copy of all that shade_samples() calls wherever it is called, before they see which method calls it: there are but two such places.
void main() {
    uvec2 size = push.view.view.size, pixel = gl_GlobalInvocationID.xy;
    uint pixels = size.x * size.y, slot = LINEAR_GROUP * 64u + gl_LocalInvocationIndex, entry = 0u;
    bool whole = METHOD == MSAA_COMPACT || METHOD == MSAA_AGGREGATE, listed = whole && STEP == MSAA_STEP_REST;
    if (listed) {
        if (slot >= push.sums.at[pixels]) return;
        entry = push.entries.at[slot];
        pixel = uvec2((entry & 0xfffffffu) % size.x, (entry & 0xfffffffu) / size.x);
    }
    bool inside = all(lessThan(pixel, size));
    uint index = pixel.y * size.x + pixel.x, word = inside ? push.surfaces.at[index] : 0xffffffffu;
    bool edge = inside && surface_is_edge(word);
    if (METHOD == MSAA_TILES) {
        if (gl_LocalInvocationIndex == 0u) tile_is_edge = 0u;
        barrier();
        if (edge) tile_is_edge = 1u;
        barrier();
        uint count = !inside ? 0u : tile_is_edge == 0u ? 1u : SAMPLES;
        for (uint i = 0u; i < count; i++) {
            uint with_it = samples_with(word, i);
            if (with_it != 0u) shade_samples(ivec2(pixel), with_it, i * pixels + index);
        }
        return;
    }
    uint samples = 0u, result = index;
    if (listed) {
        samples = surface_samples(word, entry >> 28);
        result = pixels + slot;
    } else if (whole || METHOD == MSAA_COVERAGE) {
        samples = surface_samples(word, METHOD == MSAA_COVERAGE ? widest_surface(word) : 0u);
    } else if (STEP == MSAA_STEP_FIRST || edge) {
        uint at = METHOD == MSAA_ALL ? gl_WorkGroupID.z : STEP == MSAA_STEP_REST ? gl_WorkGroupID.z + 1u : 0u;
        samples = samples_with(word, at);
        result += at * pixels;
    }
    if (inside && samples != 0u) shade_samples(ivec2(pixel), samples, result);
}
