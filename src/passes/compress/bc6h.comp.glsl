#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
// BC6H: one thread a block of 4 x 4 texels.
#include "passes/compress/bc6h.glsl"

layout(constant_id = 1) const bool STORES = false; // to an image, of which a texel is a block; else to a buffer
layout(local_size_x = 8, local_size_y = 8) in;

void main() {
    uvec2 at = gl_GlobalInvocationID.xy, blocks = (uvec2(push.width, push.height) + 3u) / 4u;
    if (any(greaterThanEqual(at, blocks))) return;
    uvec4 block = bc6h_encode(at);
    if (STORES)
        imageStore(images_uint[push.target], ivec2(at), block);
    else
        push.blocks.at[push.first_block + at.y * blocks.x + at.x] = block;
}
