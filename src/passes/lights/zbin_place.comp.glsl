#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Finds the words of each cell their place in the pool and clears them. One work group takes one cell; a cell that the pool cannot hold is
// marked to use all lights.
#include "common.glsl"
#include "passes/lights/zbin.glsl"

layout(local_size_x = 64) in;

shared uint sums[64];

void main() {
    uint cell = LINEAR_GROUP, thread = gl_LocalInvocationIndex;
    if (cell >= push.cell_count) return; // the whole group
    bins_cell c = zbin_cell(cell);
    uint first = push.sums.at[cell], last = push.sums.at[cell + 1u], groups = group_count();
    if (last > push.capacity) {
        if (thread == 0u) {
            push.table.at[c.state] = BINS_ALL;
            atomicAdd(push.overflow.at[0], 1u);
        }
        return;
    }
    for (uint i = first + thread; i < last; i += 64u) push.pool.at[i] = 0u;
    uint offset = first;
    for (uint base = 0u; base < groups; base += 64u) {
        uint group = base + thread;
        uint words = group < groups ? uint(bitCount(push.table.at[c.records + group * 2u + 1u])) : 0u;
        sums[thread] = words;
        barrier();
        for (uint step = 1u; step < 64u; step *= 2u) {
            uint before = thread >= step ? sums[thread - step] : 0u;
            barrier();
            sums[thread] += before;
            barrier();
        }
        if (group < groups) push.table.at[c.records + group * 2u] = offset + sums[thread] - words;
        offset += sums[63];
        barrier();
    }
}
