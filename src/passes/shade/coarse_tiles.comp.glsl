#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Lists for each tile of 8 x 8 blocks those that are not alike, and counts them: a thread has a tile. Together with coarse_find.comp.glsl it
// stands for the barriers and shared counters of the publication's one pass. Without them the pass that lights is as fast as one that has a
// pixel for each thread, whatever a device makes of barriers.
#include "common.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#include "passes/shade/coarse_shared.h"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_coarse_tiles_push push; };

void main() {
    uint tile = LINEAR_INVOCATION;
    if (tile >= push.tile_count) return;
    uint base = tile * COARSE_GROUP, fine_count = 0u, half_count = 0u, pixels = 0u, shaded = 0u, kinds[COARSE_KINDS];
    for (uint k = 0u; k < COARSE_KINDS; k++) kinds[k] = 0u;
    for (uint i = 0u; i < COARSE_GROUP; i++) {
        uint word = push.blocks.at[base + i], kind = word & COARSE_WORD_KIND, shown = word >> COARSE_WORD_PIXELS_SHIFT & COARSE_WORD_PIXELS;
        for (uint k = 0u; k < COARSE_KINDS; k++) kinds[k] += uint(k == kind);
        pixels += shown;
        shaded += kind == COARSE_SHARED ? 1u : kind == COARSE_HALF ? 1u + (word >> COARSE_WORD_QUADS_SHIFT & COARSE_WORD_QUADS) : shown;
        half_count += uint(kind == COARSE_HALF);
        if (kind > COARSE_SHARED && kind != COARSE_HALF) push.blocks.at[base + fine_count++] |= i << COARSE_WORD_FINE_SHIFT;
    }
    if (half_count > 0u)
        for (uint i = 0u, next = fine_count; i < COARSE_GROUP; i++)
            if ((push.blocks.at[base + i] & COARSE_WORD_KIND) == COARSE_HALF) push.blocks.at[base + next++] |= i << COARSE_WORD_FINE_SHIFT;
    if (fine_count + half_count > 0u) push.blocks.at[base] |= fine_count << COARSE_WORD_COUNT_SHIFT | half_count << COARSE_WORD_HALVES_SHIFT;
    for (uint k = COARSE_SHARED; k < COARSE_KINDS; k++)
        if (kinds[k] > 0u) atomicAdd(push.counts.at[k], kinds[k]);
    if (pixels > 0u) {
        atomicAdd(push.counts.at[COARSE_COUNT_PIXELS], pixels);
        atomicAdd(push.counts.at[COARSE_COUNT_SHADED], shaded);
    }
}
