#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Picks the tiles that are worth a look. Their order does not matter: each is dealt with by itself.
#include "common.glsl"
#include "passes/lights/backface.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_cells_push push; };

void main() {
    uint cell = LINEAR_INVOCATION;
    if (cell >= push.cell_count) return;
    uint count = 0u;
    for (uint c = 0u; c < push.chunk_count; c++) count += push.sums.at[cell * push.chunk_count + c];
    BACKFACE.cones.at[cell] = gpu_cone(vec3(0.0), BACKFACE_WIDE, 0u, 1u);
    if (count < BACKFACE.least && BACKFACE.every_tile == 0u) return;
    uint slot = atomicAdd(BACKFACE.picks.at[3], 1u);
    if (slot >= BACKFACE_ROW * BACKFACE_ROWS) return; // it keeps its lights
    BACKFACE.picks.at[4u + slot] = cell;
    atomicMax(BACKFACE.picks.at[1], slot / BACKFACE_ROW + 1u);
}
