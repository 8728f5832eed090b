#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Debug views of denoising: how noisy a pixel is before it is filtered in space, and how many frames it knows.
#include "passes/shadow/denoise.glsl"
#include "passes/debug/legend.glsl"

layout(local_size_x = DENOISE_GROUP, local_size_y = DENOISE_GROUP) in;
layout(push_constant, scalar) uniform push_block { gpu_denoise_view_push push; };

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, ivec2(push.view.view.size)))) return;
    float shown = texelFetch(textures[push.image], p, 0).a;
    vec3 color = heat(push.history == 1u ? shown / DENOISE_FRAMES : 2.0 * sqrt(shown));
    if (!(texelFetch(textures[push.places], p, 0).x > 0.0)) color = vec3(0.0);
    imageStore(images[push.target], p, vec4(push.swap == 1u ? color.bgr : color, 1.0));
}
