#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// For the test: every pixel asks for its own pages. The word behind the last row counts the lights that reach pixels.
#include "passes/shadow/requests.glsl"
#include "passes/shadow/requests_shared.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_shadow_requests_push push; };

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    view_block v = push.lighting.scope.view;
    if (any(greaterThanEqual(pixel, v.view.size))) return;
    float depth = texelFetch(textures[push.depth], ivec2(pixel), 0).r;
    if (!(depth > 0.0)) return;
    light_point point;
    point.pixel = pixel;
    point.view_depth = view_depth_of(v, depth);
    vec3 seen = view_position_of(v, ndc_of_pixel(v, vec2(pixel) + 0.5), point.view_depth);
    point.position = (v.view.view_to_world * vec4(seen, 1.0)).xyz;
    point.normal = vec3(0.0);
    point.item = LIGHT_NO_ITEM;
    request_pages(push.lighting, push.wanted, point);
    for (uint i = 0u; i < push.lighting.scope.list.list.local_count; i++)
        if (light_reaches(lights_of(push.lighting), i, point.position)) atomicAdd(push.wanted.at[push.lighting.scope.list.list.local_count * SHADOW_ROW_WORDS], 1u);
}
