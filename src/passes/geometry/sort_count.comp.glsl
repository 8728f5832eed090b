#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Counts the digits of each run of keys.
#include "common.glsl"
#include "view.glsl"
#include "scene.glsl"
#include "passes/geometry/cull_shared.h"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_sort_push push; };

void main() {
    uint run = LINEAR_INVOCATION;
    if (run >= push.run_count) return;
    uint counts[SORT_DIGITS];
    for (uint d = 0u; d < SORT_DIGITS; d++) counts[d] = 0u;
    uint end = min((run + 1u) * SORT_RUN, push.item_count);
    for (uint i = run * SORT_RUN; i < end; i++) counts[push.keys_in.at[i * 2u] >> push.shift & (SORT_DIGITS - 1u)]++;
    for (uint d = 0u; d < SORT_DIGITS; d++) push.counts.at[d * push.run_count + run] = counts[d];
}
