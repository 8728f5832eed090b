#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The slot between lights and tone mapping, weighted: the mean of the blended surfaces at a pixel over its light.
#include "common.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#include "passes/mobile/mobile.glsl"

layout(push_constant, scalar) uniform push_block { gpu_mobile_push push; };

#ifdef MOBILE_LOCAL
layout(input_attachment_index = 0, set = 1, binding = 0) uniform subpassInput target_sum;
layout(input_attachment_index = 1, set = 1, binding = 1) uniform subpassInput target_density;
#define WEIGHTED_LOAD(name, i) subpassLoad(target_##name)
#else
#define WEIGHTED_LOAD(name, i) texelFetch(textures[push.images[i]], ivec2(gl_FragCoord.xy), 0)
#endif

layout(location = 0) out vec4 out_0;
#ifdef MOBILE_WIDE
layout(location = 1) out vec4 out_1;
#endif

void main() {
    vec4 sum = WEIGHTED_LOAD(sum, 0);
    if (!(sum.a > 0.0)) discard;
    float coverage = 1.0 - exp(-WEIGHTED_LOAD(density, 1).r);
    vec3 color = min(sum.rgb, vec3(1e36)) * (coverage / sum.a);
    color = min(color * push.view.view.frame.frame.light_scale, vec3(push.view.view.frame.frame.light_max * coverage)); // as a single surface
#ifdef MOBILE_WIDE
    out_0 = vec4(color.rg, 0.0, coverage);
    out_1 = vec4(color.b, 0.0, 0.0, coverage); // what shares the target is needed no more
#else
    out_0 = vec4(color, coverage);
#endif
}
