#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
#include "passes/post/overlay.glsl"
#include "srgb.glsl"

layout(location = 0) in vec2 in_texel;
layout(location = 1) in vec4 in_color;
layout(location = 0) out vec4 out_color;

void main() {
    vec4 color = in_color;
    if (push.image != ~0u) color *= textureLod(sampler2D(textures[push.image], samplers[push.sampler_index]), in_texel, 0.0);
    if (push.linear == 1u) color.rgb = srgb_decode(color.rgb);
    if (push.swap == 1u) color.rgb = color.bgr;
    out_color = vec4(color.rgb * color.a, color.a);
}
