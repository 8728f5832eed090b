#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The weighted mean of the blended surfaces at one sample, over what is opaque.
#include "common.glsl"
#include "passes/transparency/linked.glsl"

layout(push_constant, scalar) uniform push_block { gpu_weighted_composite_push push; };
layout(location = 0) out vec4 out_color;

vec4 fetch(uint image, ivec2 pixel) {
    return push.samples > 1u ? texelFetch(textures_multisampled[image], pixel, int(push.sample_index))
                             : texelFetch(textures[image], pixel, 0);
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 sum = fetch(push.sum, pixel);
    if (!(sum.a > 0.0)) discard;
    float coverage = 1.0 - exp(-fetch(push.density, pixel).r);
    out_color = vec4(min(sum.rgb, vec3(1e36)) * (coverage / sum.a), coverage);
    gl_SampleMask[0] = int(1u << push.sample_index);
}
