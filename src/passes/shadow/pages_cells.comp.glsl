#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Where the atlas has room.
#include "passes/shadow/pages_places.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_shadow_place_push push; };

void main() {
    uint index = LINEAR_INVOCATION;
    if (index >= cell_count(push.places)) return;
    gpu_shadow_cell cell = push.places.cells.at[index];
    if (shadow_youth(cell) >= push.places.choice.choice.youth) cell.taken |= cell.idle;
    if ((cell.taken.x | cell.taken.y) == 0u) cell.size = 0u;
    push.places.cells.at[index].taken = cell.taken;
    for (uint c = 0u; c < SHADOW_CLASSES; c++)
        push.places.sums.at[first_free(push.places, c) + index] =
            cell.size == c + 1u ? places_of_cell(c) - bitCount(cell.taken.x) - bitCount(cell.taken.y) : 0u;
    push.places.sums.at[first_free(push.places, SHADOW_CLASSES) + index] = cell.size == 0u ? 1u : 0u;
}
