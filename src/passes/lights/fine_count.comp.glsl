#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Counts the lights of each tile and keeps the first of them.
#include "common.glsl"
#include "passes/lights/fine_steps.glsl"
#include "passes/lights/fine_tile.glsl"

void main() {
    begin_tile();
    if ((flags & FINE_PIXELS) != 0u) take_positions();
    uint count = walk(push.found, cell * FINE_FOUND, (cell + 1u) * FINE_FOUND);
    if (thread != 0u) return;
    push.sums.at[cell] = count;
    if (cell == 0u) {
        push.sums.at[fine_tile_count() * gl_NumWorkGroups.z] = 0u; // becomes the total
        push.overflow.at[0] = 0u;
    }
}
