#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// A level of a cube map in blocks of BC3; of faces with less than four texels to a side the last ones are repeated.
#include "common.glsl"
#include "bc3.glsl"

#include "shadows/rays.glsl"

layout(buffer_reference) buffer probe_array;
layout(buffer_reference) buffer probes_block;
#include "passes/shadow/cubemap_push_shared.h"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_cubemap_push push; };

void main() {
    uint block = LINEAR_INVOCATION, side = push.side, across = (side + 3u) / 4u;
    if (block >= 6u * across * across) return;
    uint face = block / (across * across);
    uvec2 first = 4u * uvec2(block % across, block / across % across);
    uint texels[16];
    for (uint i = 0u; i < 16u; i++) {
        uvec2 at = min(first + uvec2(i & 3u, i >> 2), uvec2(side - 1u));
        texels[i] = push.texels.at[push.from + (face * side + at.y) * side + at.x];
    }
    uvec4 words = bc3_encode(texels);
    for (uint i = 0u; i < 4u; i++) push.blocks.at[push.to + 4u * block + i] = words[i];
}
