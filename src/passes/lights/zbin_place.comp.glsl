#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Finds the words of each cell their place in the pool, and clears them. A cell that the pool cannot hold is marked to use all lights.
#include "common.glsl"
#include "passes/lights/zbin.glsl"

layout(local_size_x = 64) in;

void main() {
    uint cell = LINEAR_INVOCATION, threads = gl_NumWorkGroups.x * gl_NumWorkGroups.y * 64u;
    uint used = min(push.sums.at[push.cell_count], push.capacity);
    for (uint i = cell; i < used; i += threads) push.pool.at[i] = 0u;
    if (cell >= push.cell_count) return;
    bins_cell c = zbin_cell(cell);
    if (push.sums.at[cell + 1u] > push.capacity) {
        push.table.at[c.state] = BINS_ALL;
        atomicAdd(push.overflow.at[0], 1u);
        return;
    }
    uint groups = group_count(), offset = push.sums.at[cell];
    for (uint i = 0u; i < groups; i++) {
        push.table.at[c.records + i * 2u] = offset;
        offset += uint(bitCount(push.table.at[c.records + i * 2u + 1u]));
    }
}
