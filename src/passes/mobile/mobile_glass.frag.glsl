#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The slot between lights and tone mapping: blended surfaces, shaded as they are drawn, over the light.
#include "passes/shade/forward.glsl"
#include "passes/mobile/mobile.glsl"

layout(push_constant, scalar) uniform push_block { gpu_geometry_push push; };

layout(location = 0) out vec4 out_0;
#ifdef MOBILE_WIDE
layout(location = 1) out vec4 out_1;
#endif

void main() {
    float view_depth;
    vec4 color = forward_shade(push, view_depth);
    // By its share of the limit, within which the light stays so.
    color.rgb = min(color.rgb * push.view.view.frame.frame.light_scale, vec3(push.view.view.frame.frame.light_max * color.a));
#ifdef MOBILE_WIDE
    out_0 = vec4(color.rg, 0.0, color.a);
    out_1 = vec4(color.b, 0.0, 0.0, color.a); // what shares the target is needed no more
#else
    out_0 = color;
#endif
}
