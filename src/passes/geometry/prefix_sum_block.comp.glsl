#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Exclusive prefix sum of each block of 1024 values, in place; the block's total goes to `blocks`.
#include "common.glsl"
#include "passes/geometry/prefix_sum_shared.h"

layout(local_size_x = 128) in; // eight values a thread
layout(push_constant, scalar) uniform push_block { gpu_prefix_sum_push push; };

shared uint sums[128];

void main() {
    uint thread = gl_LocalInvocationIndex;
    if (LINEAR_GROUP * PREFIX_SUM_BLOCK >= push.count) return; // the whole group
    uint first = LINEAR_GROUP * PREFIX_SUM_BLOCK + thread * 8u;
    uint values[8];
    uint total = 0u;
    for (uint i = 0u; i < 8u; i++) {
        values[i] = first + i < push.count ? push.values.at[first + i] : 0u;
        total = add_saturated(total, values[i]);
    }
    sums[thread] = total;
    barrier();
    for (uint step = 1u; step < 128u; step *= 2u) {
        uint before = thread >= step ? sums[thread - step] : 0u;
        barrier();
        sums[thread] = add_saturated(sums[thread], before);
        barrier();
    }
    uint sum = thread > 0u ? sums[thread - 1u] : 0u;
    for (uint i = 0u; i < 8u; i++) {
        if (first + i < push.count) push.values.at[first + i] = sum;
        sum = add_saturated(sum, values[i]);
    }
    if (thread == 127u) push.blocks.at[LINEAR_GROUP] = sum;
}
