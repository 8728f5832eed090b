#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Adds the sum that volumes left to the light, which so is rounded once, as by lists.
#include "common.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#define MOBILE_READS 1
#include "passes/mobile/mobile.glsl"

layout(push_constant, scalar) uniform push_block { gpu_mobile_push push; };

#ifdef MOBILE_WIDE
#define MOBILE_SUM 0 // an input that light does not take
#else
#define MOBILE_SUM 1
#endif
#ifdef MOBILE_LOCAL
layout(input_attachment_index = MOBILE_SUM, set = 1, binding = MOBILE_SUM) uniform subpassInput target_sum;
#endif

layout(location = 0) out vec4 out_0;
#ifdef MOBILE_WIDE
layout(location = 1) out vec4 out_1;
#endif

void main() {
    mobile_texel g;
    MOBILE_LOAD_LIGHT(g)
#ifdef MOBILE_LOCAL
    vec3 sum = subpassLoad(target_sum).rgb;
#else
    vec3 sum = texelFetch(textures[push.images[MOBILE_SUM]], ivec2(gl_FragCoord.xy), 0).rgb;
#endif
    vec3 light = min(mobile_light(g) + sum, vec3(push.view.view.frame.frame.light_max));
#ifdef MOBILE_WIDE
    out_0 = vec4(light.rg, 0.0, 0.0);
    out_1 = vec4(light.b, g.t[4].y, 0.0, 0.0);
#else
    out_0 = vec4(light, 0.0);
#endif
}
