#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Sorts the blocks by class and writes the dispatches.
#include "common.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#include "passes/shade/classify_shared.h"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_classify_push push; };

void main() {
    uint block = LINEAR_INVOCATION;
    if (block < push.block_count) {
        uint found = push.classes.at[block];
        if (found < SHADE_CLASSES) push.blocks.at[push.sums.at[found * push.block_count + block]] = block;
    }
    if (block > SHADE_CLASSES) return;
    uint first = push.sums.at[min(block, SHADE_CLASSES) * push.block_count];
    if (block == SHADE_CLASSES) {
        push.counts.at[block] = push.block_count - first;
        return;
    }
    uint count = push.sums.at[(block + 1u) * push.block_count] - first;
    uint groups = push.block_size == 8u ? count : (count + 3u) / 4u; // four blocks of 4x4 share a group
    uint wide = min(groups, 32768u);
    push.dispatches.at[block * 3u] = wide;
    push.dispatches.at[block * 3u + 1u] = wide == 0u ? 0u : (groups + wide - 1u) / wide;
    push.dispatches.at[block * 3u + 2u] = 1u;
    push.counts.at[block] = count;
}
