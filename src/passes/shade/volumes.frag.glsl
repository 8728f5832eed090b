#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// What one light adds to one pixel of the G-buffer; or several, where the screen is drawn for each BATCH of them.
#include "common.glsl"
#include "shade.glsl"
#include "gbuffer.glsl"
#include "passes/shade/edges.glsl"
#include "passes/shade/volumes.glsl"

layout(constant_id = VOLUME_BATCH_ID) const uint BATCH = 1u;
layout(constant_id = VOLUME_BOUND_DEPTHS_ID) const uint BOUND_DEPTHS = 0u; // 1: nothing where the surface is before or behind the light's sphere

layout(constant_id = VOLUME_MASKED_ID) const uint MASKED = 0u; // 1: a mask says how much of the light is left

layout(early_fragment_tests) in;
layout(push_constant, scalar) uniform push_block { gpu_volume_push push; };

layout(location = 0) flat in uint in_light;
layout(location = 1) flat in vec2 in_depths;
layout(location = 2) flat in uint in_rank;
layout(location = 0) out vec4 out_radiance;

// Sums of millions of these are finite.
const float MOST = 1e30;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float view_depth;
    vec3 position;
    int at = -1;
    if (SAMPLES > 1u) {
        uvec2 inside = min(uvec2(pixel), push.view.view.size - 1u); // helpers load too
        uint samples = surface_samples(push.words.at[inside.y * push.view.view.size.x + inside.x], push.layer);
        if (samples == 0u) discard;
        position = (push.view.view.view_to_world * vec4(surface_point(push.view, push.gbuffer, pixel, samples, view_depth), 1.0)).xyz;
        at = findLSB(samples);
    } else {
        float depth = gbuffer_depth(push.gbuffer, pixel);
        if (depth <= 0.0 || gbuffer_is_forward(push.gbuffer, pixel)) discard; // sky, and what is lit forward
        view_depth = view_depth_of(push.view, depth);
        position = gbuffer_position(push.view, pixel, view_depth);
    }
    if (BOUND_DEPTHS == 1u && (view_depth < in_depths.x || view_depth > in_depths.y)) discard;
    uint counter = (uint(pixel.y) * push.view.view.size.x + uint(pixel.x)) * 2u, visited = 0u, useful = 0u;
    surface s;
    layers_view b;
    vec3 radiance = vec3(0.0);
    for (uint i = 0u; i < BATCH; i++) {
        uint local = BATCH == 1u ? in_light : push.ids.at[in_rank * BATCH + i];
        if (local == VOLUME_NONE) break;
        visited++;
        uint light = push.lighting.scope.lights.directional_count + local;
        vec3 to_light;
        vec3 illuminance = light_reach(lights_of(push.lighting), light, position, LIGHT_MASK_ALL, to_light);
        if (MASKED == 1u) illuminance *= texelFetch(textures[push.mask], pixel, 0).r;
        if (illuminance == vec3(0.0)) continue;
        if (useful == 0u) {
            s = gbuffer_surface_at(push.gbuffer, pixel, at, position, vec3(0.0));
            b = layers_prepare(s, push.view, to_viewer(push.view, position));
        }
        useful++;
        if (LIGHTING_SHADOWED)
            illuminance *= light_visibility(push.lighting, light, shadowed_point_of(push.lighting, position, facing_normal(s)), to_light, false);
        radiance += illuminance * light_lobes(lights_of(push.lighting), light, s, b, to_light);
    }
    if (COUNT_LIGHTS == 1u) {
        atomicAdd(push.counters.at[counter], visited);
        if (useful > 0u) atomicAdd(push.counters.at[counter + 1u], useful);
    }
    if (useful == 0u) discard;
    count_shadows(push.view, push.counters);
    out_radiance = vec4(min(radiance, vec3(MOST)), 0.0);
}
