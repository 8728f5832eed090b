#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
#include "passes/ambient/environment_texels.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_environment_level_push push; };

void main() {
    uint face, index = LINEAR_INVOCATION, wide = 2u * push.side;
    uvec2 at;
    if (!texel_place(index, push.side, face, at)) return;
    uint from = push.from + (face * wide + 2u * at.y) * wide + 2u * at.x;
    vec3 sum = texel_unpack(push.texels.at[from]) + texel_unpack(push.texels.at[from + 1u]) + texel_unpack(push.texels.at[from + wide]) +
               texel_unpack(push.texels.at[from + wide + 1u]);
    push.texels.at[push.to + index] = texel_pack(sum * 0.25);
}
