#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Lights as volumes: what one light adds to one pixel, times light_scale of the frame, into a sum that is added to the light later.
#include "common.glsl"
#include "shade.glsl"
#include "passes/shade/volumes.glsl"
#define MOBILE_READS 2
#include "passes/mobile/mobile.glsl"
#include "passes/mobile/mobile_volume_shared.h"

layout(constant_id = VOLUME_BOUND_DEPTHS_ID) const uint BOUND_DEPTHS = 0u; // 1: nothing where the surface is before or behind the light's sphere

layout(early_fragment_tests) in;
layout(push_constant, scalar) uniform push_block { gpu_mobile_volume_push push; };

layout(location = 0) flat in uint in_light;
layout(location = 1) flat in vec2 in_depths;
layout(location = 0) out vec4 out_sum;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    mobile_texel g;
    MOBILE_LOAD_ALL(g)
    vec3 position = mobile_position(g, push.view, pixel), right = dFdx(position), down = dFdy(position);
    if (mobile_is_sky(g)) discard;
    float view_depth;
    surface s = mobile_surface(g, push.view, pixel, view_depth);
    s.geometric = mobile_geometric(g, right, down, s, push.view, pixel);
    if (BOUND_DEPTHS == 1u && (view_depth < in_depths.x || view_depth > in_depths.y)) discard;
    uint counter = (uint(pixel.y) * push.view.view.size.x + uint(pixel.x)) * 2u;
    if (COUNT_LIGHTS == 1u) atomicAdd(push.counters.at[counter], 1u);
    vec3 to_light;
    vec3 illuminance = light_reach(lights_of(push.lighting), push.lighting.scope.lights.directional_count + in_light, s.position, LIGHT_MASK_ALL, to_light);
    if (illuminance == vec3(0.0)) discard;
    if (COUNT_LIGHTS == 1u) atomicAdd(push.counters.at[counter + 1u], 1u);
    if (LIGHTING_SHADOWED)
        illuminance *= light_visibility(push.lighting, push.lighting.scope.lights.directional_count + in_light, shadowed_point_of(push.lighting, s.position, s.normal), to_light, false);
    count_shadows(push.view, push.counters);
    brdf_view b = energy_view(s, push.view, to_viewer(push.view, s.position));
    brdf_lobes lobes;
    vec3 sum = vec3(0.0);
    if (light_brdf_lobes(lights_of(push.lighting), push.lighting.scope.lights.directional_count + in_light, s.position, s.normal, b, to_light, lobes)) sum = illuminance * brdf_cos_of(s, b, lobes);
    out_sum = vec4(mobile_scaled(push.view, sum), 0.0);
}
