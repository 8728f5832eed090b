#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Forward shading of pixels with several samples by the lights that the layers of the pixel name, which the shaded point lies on. Where all
// layers are taken, or no sample is near the point, the others are looked for one by one.
layout(early_fragment_tests) in;
#include "common.glsl"
#include "lights/iterate.glsl"
#define MATERIAL_LAYERS LIGHTING_LAYERS
#include "material.glsl"
#include "decals_raster.glsl"
#include "shade.glsl"
#include "passes/shade/sample_bounds.glsl"
#include "passes/shade/volumes.glsl"
#include "passes/shade/zioma_shared.h"

layout(push_constant, scalar) uniform push_block { gpu_zioma_samples_push push; };

layout(location = 0) out vec4 out_radiance;

void main() {
    material_array materials = push.geometry.scene.scene.materials;
    surface s = material_surface(materials, in_ids.x);
    decals_on_surface(s, push.geometry.view, push.geometry.scene);
    if (material_culled(materials, in_ids.x)) discard; // holes are cut (forward.frag.glsl)
    view_block v = push.geometry.view;
    lighting_block l = push.geometry.lighting;
    vec3 view_position = (v.view.world_to_view * vec4(s.position, 1.0)).xyz;
    ivec2 pixel = ivec2(pixel_of(v, view_position));
    vec3 to_view = to_viewer(v, s.position);
    layers_view b = layers_prepare(s, v, to_view);
    shadowed_point shadowed = shadowed_point_of(l, s.position, facing_normal(s));
    precise vec3 sum = suns_at(l, s, b, shadowed);
    bool known = sample_bounds_hold(texelFetch(textures[push.ranges], pixel, 0), -view_position.z);
    uint next = 0u, end = l.scope.list.list.local_count, stored = 0u, visited = 0u, useful = 0u;
    for (;;) {
        if (known && stored < push.layers) {
            float place = texelFetch(textures[push.places[stored]], pixel, 0).r;
            if (place == 0.0) break;
            next = uint(round((1.0 - place) * 16777216.0)) - 1u;
            stored++;
        }
        if (next >= end) break;
        bool reaches;
        sum += light_at(l, l.scope.lights.directional_count + next, s, b, shadowed, reaches);
        next++;
        visited++;
        if (reaches) useful++;
    }
    atomicAdd(push.totals.at[1], useful);
    if (visited > stored) atomicAdd(push.totals.at[2], 1u);
    if (COUNT_LIGHTS == 1u) {
        uint at = (uint(pixel.y) * v.view.size.x + uint(pixel.x)) * 2u;
        atomicAdd(push.geometry.counters.at[at], visited);
        atomicAdd(push.geometry.counters.at[at + 1u], useful);
    }
    count_shadows(v, push.geometry.counters);
    vec3 radiance = shade_rest(s, v, to_view, sum);
    out_radiance = vec4(min(radiance, vec3(v.view.frame.frame.hdr_max)), 1.0);
}
