#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Counts the lights that every tile they touch has dropped.
#include "common.glsl"
#include "passes/lights/backface.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_cells_push push; };


void main() {
    uint i = LINEAR_INVOCATION;
    if (i < push.visible_sums.at[push.list.list.local_count] && BACKFACE.marks.at[i] == 1u)
        atomicAdd(BACKFACE.tally.at[0], 1u);
}
