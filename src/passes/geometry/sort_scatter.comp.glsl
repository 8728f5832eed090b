#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Moves the keys of each run to their places; equal digits keep their order.
#include "common.glsl"
#include "view.glsl"
#include "scene.glsl"
#include "passes/geometry/cull_shared.h"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_sort_push push; };

void main() {
    uint run = LINEAR_INVOCATION;
    if (run >= push.run_count) return;
    uint places[SORT_DIGITS];
    for (uint d = 0u; d < SORT_DIGITS; d++) places[d] = push.counts.at[d * push.run_count + run];
    uint end = min((run + 1u) * SORT_RUN, push.item_count);
    for (uint i = run * SORT_RUN; i < end; i++) {
        uint key = push.keys_in.at[i * 2u], item = push.keys_in.at[i * 2u + 1u];
        uint place = places[key >> push.shift & (SORT_DIGITS - 1u)]++;
        push.keys_out.at[place * 2u] = key;
        push.keys_out.at[place * 2u + 1u] = item;
    }
}
