#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Forward shading by the lights that the layers hold. Where all are taken, those that come after the last are looked for one by one.
#include "common.glsl"
#include "lights/iterate.glsl"
#define MATERIAL_LAYERS LIGHTING_LAYERS
#include "material.glsl"
#include "decals_raster.glsl"
#include "shade.glsl"
#include "passes/shade/volumes.glsl"
#include "passes/shade/zioma_shared.h"

layout(early_fragment_tests) in;
layout(push_constant, scalar) uniform push_block { gpu_zioma_material_push push; };

layout(location = 0) out vec4 out_radiance;

void main() {
    material_array materials = push.geometry.scene.scene.materials;
    bool hole;
    surface s = material_surface(materials, in_ids.x, hole);
    decals_on_surface(s, push.geometry.view, push.geometry.scene);
    if (material_culled(materials, in_ids.x) || hole) discard;
    view_block v = push.geometry.view;
    lighting_block l = push.geometry.lighting;
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 to_view = to_viewer(v, s.position);
    layers_view b = layers_prepare(s, v, to_view);
    shadowed_point shadowed = shadowed_point_of(l, s.position, facing_normal(s));
    precise vec3 sum = suns_at(l, s, b, shadowed);
    uint stored = 0u, visited = 0u, useful = 0u;
    for (; stored < push.layers; stored++) {
        vec4 ray = texelFetch(textures[push.rays[stored]], pixel, 0);
        if (ray.w == 0.0) break;
        vec4 color = texelFetch(textures[push.colors[stored]], pixel, 0);
        vec3 to_light = ray.xyz;
        // The layer of an area light has its index: the direction is not enough.
        if (LIGHTING_AREA_LIGHTS && color.a > 0.0) sum += color.rgb * ray.w * light_lobes(lights_of(l), l.scope.lights.directional_count + uint(color.a) - 1u, s, b, to_light);
        else sum += color.rgb * ray.w * layers_cos(s, b, to_light);
    }
    useful = stored;
    if (stored == push.layers) {
        uint last = uint(round((1.0 - texelFetch(textures[push.last], pixel, 0).r) * 16777216.0)); // index + 1
        for (uint i = last; i < l.scope.list.list.local_count; i++) {
            uint light = l.scope.lights.directional_count + i;
            bool reaches;
            sum += light_at(l, light, s, b, shadowed, reaches);
            visited++;
            if (reaches) useful++;
        }
    }
    atomicAdd(push.totals.at[1], useful);
    if (useful > stored) atomicAdd(push.totals.at[2], 1u);
    if (COUNT_LIGHTS == 1u) {
        uint at = (uint(pixel.y) * v.view.size.x + uint(pixel.x)) * 2u;
        atomicAdd(push.geometry.counters.at[at], visited);
        atomicAdd(push.geometry.counters.at[at + 1u], useful);
    }
    count_shadows(v, push.geometry.counters);
    vec3 radiance = shade_rest(s, v, to_view, sum);
    out_radiance = vec4(min(radiance, vec3(v.view.frame.frame.hdr_max)), 1.0);
}
