#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Clears as much of the table as this frame's lights in view need, and writes its head.
#include "common.glsl"
#include "passes/lights/zbin.glsl"

layout(local_size_x = 64) in;

void main() {
    uint groups = group_count(), tops = top_count(), first = LINEAR_INVOCATION * 4u;
    uint size = BINS_HEAD + push.cell_count * (tops + 1u) + push.cell_count * groups * 2u;
    if (first == 0u) {
        push.table.at[0] = visible_count();
        push.table.at[1] = groups;
        push.table.at[2] = tops;
        push.table.at[3] = 0u;
        return;
    }
    for (uint i = first; i < min(first + 4u, size); i++) push.table.at[i] = 0u;
}
