#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "passes/compress/bc6h_test_shared.h"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_bc6h_test_push push; };

void main() {
    uint i = LINEAR_INVOCATION;
    if (i < push.width * push.height) push.texels.at[push.first + i] = texelFetch(textures[push.image], ivec2(i % push.width, i / push.width), 0);
}
