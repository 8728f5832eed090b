#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// How many fragments there are, in the longest list, and in how many pixels they do not fit.
#include "common.glsl"
#include "passes/transparency/linked.glsl"

layout(local_size_x = 256) in;
layout(push_constant, scalar) uniform push_block { gpu_linked_totals_push push; };

shared uint longest, overflow;

void main() {
    uint index = LINEAR_INVOCATION;
    if (gl_LocalInvocationID.x == 0u) longest = overflow = 0u;
    barrier();
    if (index < push.pixel_count) {
        uint end = push.sums.at[index + 1u], count = end - push.sums.at[index];
        if (count > 0u) atomicMax(longest, count);
        if (count > 0u && end > push.capacity) atomicAdd(overflow, 1u);
        if (index + 1u == push.pixel_count) push.totals.at[0] = end;
    }
    barrier();
    if (gl_LocalInvocationID.x != 0u) return;
    if (longest > 0u) atomicMax(push.totals.at[1], longest);
    if (overflow > 0u) atomicAdd(push.totals.at[2], overflow);
}
