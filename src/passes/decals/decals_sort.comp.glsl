#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Puts the decals of each tile into their order, whichever came first. Where a box's faces meet one may be noted twice: the merge skips it.
#include "common.glsl"
#include "decals.glsl"
#include "passes/decals/decals_pass_shared.h"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_decals_box_push push; };

void main() {
    uint tile = LINEAR_INVOCATION;
    if (tile >= push.tiles.x * push.tiles.y) return;
    uint first = push.counts.at[tile], end = push.counts.at[tile + 1u];
    if (end > push.capacity) return; // its pixels go through all decals
    for (uint i = first + 1u; i < end; i++) {
        uint id = push.entries.at[i], k = i;
        for (; k > first && push.entries.at[k - 1u] > id; k--) push.entries.at[k] = push.entries.at[k - 1u];
        push.entries.at[k] = id;
    }
}
