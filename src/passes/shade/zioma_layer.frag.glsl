#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// One layer of lights: of those that reach the pixel, the one that comes next after the layer before.
#include "common.glsl"
#include "gbuffer.glsl"
#include "shade.glsl"
#include "scene.glsl"
#include "passes/shade/sample_bounds.glsl"
#include "passes/shade/volumes.glsl"
#include "passes/shade/zioma_shared.h"

layout(constant_id = SAMPLES_ID) const uint SAMPLES = 1u;
layout(constant_id = ZIOMA_LAYER_ID) const uint LAYER = 0u;

layout(push_constant, scalar) uniform push_block { gpu_zioma_push push; };

layout(location = 0) flat in uint in_light;
layout(location = 0) out vec4 out_ray;
layout(location = 1) out vec4 out_color;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    view_block v = push.head.view;
    vec4 seen = texelFetch(textures[push.depth], pixel, 0);
    float depth = seen.r;
    float place = 1.0 - float(in_light + 1u) / 16777216.0;
    if (depth <= 0.0 && (SAMPLES <= 1u || sample_bounds_empty(seen))) discard; // sky
    if (LAYER > 0u && place >= texelFetch(textures[push.previous], pixel, 0).r) discard;
    if (COUNT_LIGHTS == 1u) atomicAdd(push.head.counters.at[(uint(pixel.y) * v.view.size.x + uint(pixel.x)) * 2u], 1u);
    uint light = push.head.lighting.scope.lights.directional_count + in_light;
    if (SAMPLES > 1u) { // reaches some sample, as far as its sphere tells
        gpu_entity_bounds bounds = push.head.lighting.scope.lights.entities.at[in_light];
        if (!sample_bounds_reached(v, pixel, seen, bounds.center, bounds.radius)) discard;
        out_ray = out_color = vec4(0.0);
        gl_FragDepth = place;
        return;
    }
    if (!light_meets(lights_of(push.head.lighting), light, LIGHT_MASK_ALL)) discard; // surfaces with masks are drawn forward
    vec3 to_light;
    vec3 position = gbuffer_position(v, pixel, view_depth_of(v, depth));
    float strength = light_strength(lights_of(push.head.lighting), light, position, to_light);
    vec3 color = push.head.lighting.scope.lights.lights.at[light].color;
    if (strength <= 0.0 || color * strength == vec3(0.0)) discard;
    if (LIGHTING_SHADOWED) color *= light_visibility(push.head.lighting, light, shadowed_point_of(push.head.lighting, position, to_light), to_light, false);
    count_shadows(v, push.head.counters);
    out_ray = vec4(to_light, strength);
    out_color = vec4(color, LIGHTING_AREA_LIGHTS && shape_is_area(push.head.lighting.scope.lights.lights.at[light].shape.kind) ? float(in_light + 1u) : 0.0);
    gl_FragDepth = place;
}
