#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The second step: all lights of the pixel's list are summed up and added to its light once, so that it is rounded once.
#include "common.glsl"
#include "shade.glsl"
#define MOBILE_READS 2
#include "passes/mobile/mobile.glsl"

layout(push_constant, scalar) uniform push_block { gpu_mobile_push push; };

layout(location = 0) out vec4 out_0;
#ifdef MOBILE_WIDE
layout(location = 1) out vec4 out_1;
#endif

void main() {
    mobile_texel g;
    MOBILE_LOAD_ALL(g)
    vec3 light = mobile_light(g);
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 position = mobile_position(g, push.view, pixel), right = dFdx(position), down = dFdy(position);
    if (!mobile_is_sky(g)) {
        float view_depth;
        surface s = mobile_surface(g, push.view, pixel, view_depth);
        s.geometric = mobile_geometric(g, right, down, s, push.view, pixel);
        vec3 sum = shade_surface(s, push.view, push.lighting, push.counters, uvec2(pixel), view_depth, LIGHT_NO_ITEM);
        light = min(light + mobile_scaled(push.view, sum), vec3(push.view.view.frame.frame.light_max));
    }
#ifdef MOBILE_WIDE
    out_0 = vec4(light.rg, 0.0, 0.0);
    out_1 = vec4(light.b, g.t[4].y, 0.0, 0.0);
#else
    out_0 = vec4(light, 0.0);
#endif
}
