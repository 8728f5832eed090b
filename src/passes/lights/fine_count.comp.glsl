#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Counts the lights of each tile, and keeps what it finds for the fill.
#include "common.glsl"
#include "passes/lights/fine_steps.glsl"
#include "passes/lights/fine_tile.glsl"

// The masks of what is tested, without the bits of what the tile does not keep.
void store_masks(uint first, uint count) {
    uint words = (count + 31u) / 32u, step = joined_pixels();
    for (uint i = 0u; i < OWN; i++) {
        if (i % step != 0u) continue;
        uint at = 0u, mask = 0u, to = 0u;
        for (uint w = 0u; w < min(tested_words, KEPT_WORDS); w++) {
            for (uint k = 0u; k < OWN; k++) masks[k] = kept_masks[k * KEPT_WORDS + w];
            uint square = join_masks(i);
            if (w == 0u) to = first + square * words;
            for (uint bits = square < fine_squares() ? kept_bits[w] : 0u; bits != 0u; bits &= bits - 1u) {
                mask |= (masks[i] >> uint(findLSB(bits)) & 1u) << (at & 31u);
                at++;
                if ((at & 31u) != 0u && at < count) continue;
                push.found.at[to++] = mask;
                mask = 0u;
            }
            if (SIDE == 1u) barrier(); // see join_masks()
        }
    }
}

void main() {
    begin_tile();
    if ((flags & FINE_PIXELS) != 0u) take_positions();
    makes_masks = (flags & FINE_PIXELS) != 0u && push.list.list.mask_size != 0u;
    for (uint k = 0u; k < OWN * KEPT_WORDS; k++) kept_masks[k] = 0u;
    uint first = fine_found_of(cell), end = first + FINE_FOUND - 1u;
    uint count = walk(push.found, first, end);
    if (has_masks) store_masks(first + FINE_FOUND, count);
    if (thread != 0u) return;
    push.found.at[end] = has_masks ? 1u : 0u;
    push.sums.at[cell] = count;
    if (cell == 0u) {
        push.sums.at[fine_tile_count() * gl_NumWorkGroups.z] = 0u; // becomes the total
        push.overflow.at[0] = 0u;
    }
}
