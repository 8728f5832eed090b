#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "passes/post/scale_shared.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_scale_push push; };

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy, size = uvec2(push.width, push.height);
    if (any(greaterThanEqual(pixel, size))) return;
    vec2 place = (vec2(pixel) + 0.5) / vec2(size);
    imageStore(images[push.target], ivec2(pixel), textureLod(sampler2D(textures[push.picture], samplers[push.sampler_index]), place, 0.0));
}
