#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The least pressure under which all pages fit into the atlas, and the least part of the lights that must be under it. One work group.
#include "passes/shadow/pages.glsl"

layout(local_size_x = SHADOW_IMPORTANCES) in;
layout(push_constant, scalar) uniform push_block { gpu_shadow_pick_push push; };

shared uint least, best, best_cut, wanted, oblong, cells, totals[SHADOW_PRESSURES * SHADOW_CLASSES];

uint tally(uint importance, uint bias, uint c) { return push.tallies.at[(importance * SHADOW_BIASES + bias) * SHADOW_CLASSES + c]; }

// Cells of the atlas that so many pages of each class take.
uint cells_for(uvec4 pages) { return pages.x + (pages.y + 3u >> 2u) + (pages.z + 15u >> 4u) + (pages.w + 63u >> 6u); }

void main() {
    uint thread = gl_LocalInvocationIndex;
    if (thread < SHADOW_PRESSURES * SHADOW_CLASSES) totals[thread] = 0u;
    if (thread == 0u) {
        least = SHADOW_IMPORTANCES - 1u;
        best = SHADOW_PRESSURES - 1u;
        best_cut = SHADOW_IMPORTANCES;
        wanted = oblong = cells = 0u;
    }
    barrier();
    uint own = 0u;
    for (uint c = 0u; c < SHADOW_CLASSES; c++) own += tally(thread, 0u, c);
    if (own > 0u) {
        if (thread != SHADOW_SPARE) atomicMin(least, thread);
        else oblong = own;
        atomicAdd(wanted, own);
    }
    barrier();
    for (uint pressure = 0u; own > 0u && pressure < SHADOW_PRESSURES; pressure++) {
        uint bias = shadow_bias(pressure, SHADOW_IMPORTANCES, least, thread);
        for (uint c = 0u; c < SHADOW_CLASSES && bias != SHADOW_TRACED; c++)
            atomicAdd(totals[pressure * SHADOW_CLASSES + c], tally(thread, bias, c));
    }
    barrier();
    if (thread < SHADOW_PRESSURES) {
        uvec4 pages = uvec4(totals[thread * SHADOW_CLASSES], totals[thread * SHADOW_CLASSES + 1u], totals[thread * SHADOW_CLASSES + 2u],
                            totals[thread * SHADOW_CLASSES + 3u]);
        if (thread == 0u) cells = cells_for(pages);
        if (cells_for(pages) <= push.cell_count) atomicMin(best, thread);
    }
    barrier();
    if (best > 0u) { // each thread tries one cut
        uvec4 pages = uvec4(0u);
        for (uint importance = 0u; importance < SHADOW_IMPORTANCES; importance++) {
            if (importance != SHADOW_SPARE && importance < least) continue;
            uint bias = shadow_bias(best, thread, least, importance);
            for (uint c = 0u; c < SHADOW_CLASSES && bias != SHADOW_TRACED; c++) pages[c] += tally(importance, bias, c);
        }
        if (cells_for(pages) <= push.cell_count) atomicMin(best_cut, thread);
    }
    barrier();
    if (thread != 0u) return;
    uint last = push.fresh != 0u ? 0u : push.counts.counts.pages;
    push.choice.choice = gpu_shadow_choice(best, best_cut, least, last, 0u);
    push.counts.counts = gpu_shadow_counts(wanted, 0u, 0u, last, 0u, 0u, 0u, 0u, 0u, 0u, oblong, cells); // the pages that stay are taken off `evicted`
}
