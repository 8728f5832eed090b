#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Counts the lights of each tile, and keeps what it finds for the fill.
#include "common.glsl"
#include "passes/lights/fine_steps.glsl"
#include "passes/lights/fine_tile.glsl"

void main() {
    begin_tile();
    if ((flags & FINE_PIXELS) != 0u) take_positions();
    makes_masks = (flags & FINE_PIXELS) != 0u && push.list.list.mask_size != 0u;
    uint first = fine_found_of(cell), end = first + FOUND;
    uint count = walk(push.found, first, end);
    if (thread != 0u) return;
    push.found.at[end] = tested_words;
    push.sums.at[cell] = count;
    if (cell == 0u) {
        push.sums.at[fine_tile_count() * gl_NumWorkGroups.z] = 0u; // becomes the total
        push.overflow.at[0] = 0u;
    }
}
