#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// A ray from one pixel of each 4x4 to one of its lights: what rays of this scene cost.
#include "lighting/visibility.glsl"
#include "passes/shadow/split.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_shadow_probe_push push; };

uint next(inout uint state) { // the generator of Numerical Recipes, its high bits
    state = state * 1664525u + 1013904223u;
    return state >> 16u;
}

void main() {
    view_block v = push.lighting.scope.view;
    uint state = push.seed ^ gl_GlobalInvocationID.y * 9781u ^ gl_GlobalInvocationID.x * 6271u;
    uvec2 pixel = gl_GlobalInvocationID.xy * 4u + uvec2(next(state) % 4u, next(state) % 4u);
    if (any(greaterThanEqual(pixel, v.view.size))) return;
    float depth = texelFetch(textures[push.depth], ivec2(pixel), 0).r;
    if (!(depth > 0.0)) return;
    vec3 seen = view_position_of(v, ndc_of_pixel(v, vec2(pixel) + 0.5), view_depth_of(v, depth));
    light_point point;
    point.pixel = pixel;
    point.view_depth = -seen.z;
    point.position = (v.view.view_to_world * vec4(seen, 1.0)).xyz;
    point.normal = vec3(0.0);
    point.item = LIGHT_NO_ITEM;
    uint count = 0u, chosen = 0u;
    light_cursor cursor = lights_begin(list_of(push.lighting), point);
    FOR_EACH_LIGHT(list_of(push.lighting), cursor, light) {
        if (!light_casts(lights_of(push.lighting), light) || !light_reaches(lights_of(push.lighting), light, point.position)) continue;
        count++;
        if (next(state) % count == 0u) chosen = light;
    }
    if (count == 0u) return;
    vec3 to_light;
    light_strength(lights_of(push.lighting), chosen, point.position, to_light);
    float open = rays_visibility(push.lighting, ray_everything(), chosen, point.position, to_light, to_light, light_distance(lights_of(push.lighting), chosen, point.position, to_light),
                                 1e-4, shadow_slack(push.lighting, point.position));
    atomicAdd(push.counts.counts.probed, 1u);
    if (open > 0.0) atomicAdd(push.counts.counts.open, 1u);
}
