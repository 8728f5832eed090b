#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The pages that opaque surfaces need, from their depth.
#include "passes/shadow/requests.glsl"
#include "passes/shadow/requests_shared.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_shadow_requests_push push; };

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    view_block v = push.list.list.view;
    if (any(greaterThanEqual(pixel, v.view.size))) return;
    float last = 0.0;
    for (uint s = 0u; s < push.samples; s++) {
        float depth = push.samples > 1u ? texelFetch(textures_multisampled[push.depth], ivec2(pixel), int(s)).r
                                        : texelFetch(textures[push.depth], ivec2(pixel), 0).r;
        if (!(depth > 0.0) || depth == last) continue;
        last = depth;
        light_point point;
        point.pixel = pixel;
        point.view_depth = view_depth_of(v, depth);
        vec3 seen = view_position_of(v, ndc_of_pixel(v, vec2(pixel) + 0.5), point.view_depth);
        point.position = (v.view.view_to_world * vec4(seen, 1.0)).xyz;
        point.normal = vec3(0.0);
        point.item = LIGHT_NO_ITEM;
        request_pages(push.list, push.wanted, point);
    }
}
