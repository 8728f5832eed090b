#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Adds the summed block totals to the values of each block.
#include "common.glsl"
#include "passes/geometry/prefix_sum_shared.h"

layout(local_size_x = 128) in;
layout(push_constant, scalar) uniform push_block { gpu_prefix_sum_push push; };

void main() {
    if (LINEAR_GROUP * PREFIX_SUM_BLOCK >= push.count) return;
    uint before = push.blocks.at[LINEAR_GROUP];
    uint first = LINEAR_GROUP * PREFIX_SUM_BLOCK + gl_LocalInvocationIndex;
    for (uint i = 0u; i < 8u; i++) {
        uint index = first + i * 128u;
        if (index < push.count) push.values.at[index] = add_saturated(push.values.at[index], before);
    }
}
