#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// What room there is beside pages that stay, by the youth of cells.
#include "passes/shadow/pages.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_shadow_room_push push; };

void main() {
    uint index = LINEAR_INVOCATION;
    if (index >= push.cell_count) return;
    gpu_shadow_cell cell = push.cells.at[index];
    uint youth = shadow_youth(cell);
    atomicAdd(push.rooms.at[youth * SHADOW_ROOM_WORDS + SHADOW_CLASSES], 1u);
    if (cell.size == 0u) return;
    uvec2 taken = cell.taken | cell.idle;
    uint c = cell.size - 1u;
    atomicAdd(push.rooms.at[youth * SHADOW_ROOM_WORDS + c], places_of_cell(c) - bitCount(taken.x) - bitCount(taken.y));
}
