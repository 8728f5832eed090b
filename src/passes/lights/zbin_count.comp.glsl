#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Counts the words of each cell.
#include "common.glsl"
#include "passes/lights/zbin.glsl"

layout(local_size_x = 64) in;

void main() {
    uint cell = LINEAR_INVOCATION;
    if (cell > push.cell_count) return;
    if (cell == push.cell_count) {
        push.sums.at[cell] = 0u; // becomes the total
        push.overflow.at[0] = 0u;
        return;
    }
    uint records = zbin_cell(cell).records, words = 0u, groups = group_count();
    for (uint i = 0u; i < groups; i++) words += uint(bitCount(push.table.at[records + i * 2u + 1u]));
    push.sums.at[cell] = words;
}
