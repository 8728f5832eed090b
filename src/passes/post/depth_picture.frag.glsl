#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Depth of a pixel's first sample, for images that others read.
#include "common.glsl"

layout(buffer_reference) buffer float_array;
#include "passes/post/post_shared.h"

layout(constant_id = 0) const uint SAMPLES = 1u;
layout(push_constant, scalar) uniform push_block { gpu_depth_picture_push push; };

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float depth = SAMPLES > 1u ? texelFetch(textures_multisampled[push.depth], pixel, 0).r : texelFetch(textures[push.depth], pixel, 0).r;
    gl_FragDepth = push.forward != 0u ? 1.0 - depth : depth;
}
