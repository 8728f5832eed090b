#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The plain average of a pixel's samples, in linear light.
#include "common.glsl"

layout(buffer_reference) buffer float_array;
#include "passes/post/post_shared.h"
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer float_array { float at[]; };

layout(constant_id = 0) const uint SAMPLES = 1u;
layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_resolve_push push; };

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= int(push.width) || pixel.y >= int(push.height)) return;
    vec4 sum = vec4(0.0);
    for (uint i = 0u; i < SAMPLES; i++)
        sum += SAMPLES > 1u ? texelFetch(textures_multisampled[push.radiance], pixel, int(i)) : texelFetch(textures[push.radiance], pixel, 0);
    imageStore(images[push.target], pixel, sum / float(SAMPLES));
}
