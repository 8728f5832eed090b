#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// What one light adds to the two sums of light of a pixel.
#include "common.glsl"
#include "gbuffer.glsl"
#include "passes/shade/light_prepass.glsl"
#include "passes/shade/light_samples.glsl"
#include "passes/shade/volumes.glsl"
#include "passes/shade/pre_lighting_shared.h"

layout(early_fragment_tests) in;
layout(push_constant, scalar) uniform push_block { gpu_pre_lighting_push push; };

layout(location = 0) flat in uint in_light;
layout(location = 0) out vec4 out_diffuse;
layout(location = 1) out vec4 out_specular;

// Sums of millions of these are finite.
const vec4 MOST = vec4(1e30);

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    view_block v = push.head.view;
    vec3 position;
    int at = -1;
    if (SAMPLES > 1u) {
        uvec2 inside = min(uvec2(pixel), v.view.size - 1u); // helpers load too
        uint samples = surface_samples(push.words.at[inside.y * v.view.size.x + inside.x], push.layer);
        if (samples == 0u) discard;
        float view_depth;
        position = (v.view.view_to_world * vec4(surface_point(v, light_samples_depth(push.surfaces), pixel, samples, view_depth), 1.0)).xyz;
        at = findLSB(samples);
    } else {
        float depth = texelFetch(textures[push.surfaces.depth], pixel, 0).r;
        if (depth <= 0.0) discard; // sky
        position = gbuffer_position(v, pixel, view_depth_of(v, depth));
    }
    uint counter = (uint(pixel.y) * v.view.size.x + uint(pixel.x)) * 2u;
    if (COUNT_LIGHTS == 1u) atomicAdd(push.head.counters.at[counter], 1u);
    vec3 to_light;
    vec3 illuminance = light_reach(lights_of(push.head.lighting), push.head.lighting.scope.lights.directional_count + in_light, position, LIGHT_MASK_ALL, to_light);
    if (illuminance == vec3(0.0)) discard;
    if (COUNT_LIGHTS == 1u) atomicAdd(push.head.counters.at[counter + 1u], 1u);
    light_surface s = light_surface_of(push.surfaces, pixel, at, position);
    if (LIGHTING_SHADOWED)
        illuminance *= light_visibility(push.head.lighting, push.head.lighting.scope.lights.directional_count + in_light, shadowed_point_of(push.head.lighting, position, s.normal), to_light, false);
    count_shadows(v, push.head.counters);
    light_sums sums = light_sums_none();
    brdf_lobes lobes;
    if (light_brdf_lobes(lights_of(push.head.lighting), push.head.lighting.scope.lights.directional_count + in_light, position, s.normal, light_surface_view(s, v), to_light, lobes))
        light_sums_add(sums, s, lobes, illuminance);
    out_diffuse = min(sums.at[0], MOST);
    out_specular = min(sums.at[1], MOST);
}
