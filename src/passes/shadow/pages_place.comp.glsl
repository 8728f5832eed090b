#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Gives each new page a place: first in cells that hold its class already, then in free ones. Where too few are free, all pages are laid out anew.
#include "passes/shadow/pages_places.glsl"

layout(local_size_x = SHADOW_BLOCK) in;
layout(push_constant, scalar) uniform push_block { gpu_shadow_place_push push; };

shared uvec2 ranks[SHADOW_BLOCK]; // two classes a word
shared uint drawn;

uint sum_from(uint first, uint at) { return push.places.sums.at[at] - push.places.sums.at[first]; }

// The cell of a part of the sums that has thing number `rank`, and the number that the thing has there.
uvec2 find_cell(uint first, uint rank) {
    uint low = 0u, high = cell_count(push.places);
    while (high - low > 1u) {
        uint middle = (low + high) / 2u;
        if (sum_from(first, first + middle) <= rank)
            low = middle;
        else
            high = middle;
    }
    return uvec2(low, rank - sum_from(first, first + low));
}

// Free place number `rank` of a cell that some pages have stayed in.
uint free_slot(uvec2 taken, uint rank) {
    uvec2 open = ~taken;
    uint in_first = uint(bitCount(open.x)), word = rank < in_first ? 0u : 1u, bits = open[word];
    for (uint i = word * in_first; i < rank; i++) bits &= bits - 1u;
    return word * 32u + uint(findLSB(bits));
}

void main() {
    uint index = LINEAR_INVOCATION, thread = gl_LocalInvocationIndex, total = push.places.total.at[0];
    if (LINEAR_GROUP > 0u && LINEAR_GROUP * SHADOW_BLOCK >= total) return; // the whole group

    // How many pages seek a place, how many find it in cells of their class, and from which free cell on the others are.
    uvec4 seeking, found, first_cell;
    uint cells = 0u, free = sum_from(first_free(push.places, SHADOW_CLASSES), first_free(push.places, SHADOW_CLASSES + 1u));
    for (uint c = 0u; c < SHADOW_CLASSES; c++) {
        seeking[c] = sum_from(first_new(push.places, c), first_new(push.places, c + 1u));
        found[c] = min(seeking[c], sum_from(first_free(push.places, c), first_free(push.places, c + 1u)));
        first_cell[c] = cells;
        cells += (seeking[c] - found[c] + places_of_cell(c) - 1u) >> 2u * c;
    }
    bool anew = cells > free;
    uint used = cell_count(push.places) - free + cells;
    if (anew) {
        used = 0u;
        for (uint c = 0u; c < SHADOW_CLASSES; c++) {
            found[c] = 0u;
            first_cell[c] = used;
            used += (sum_from(first_page(push.places, c), first_page(push.places, c + 1u)) + places_of_cell(c) - 1u) >> 2u * c;
        }
    }

    gpu_shadow_page page = gpu_shadow_page(0u, 0u, 0u, 0u);
    uint c = 0u;
    bool seeks = false;
    uvec2 own = uvec2(0u);
    if (thread == 0u) drawn = 0u;
    if (index < total) {
        page = push.places.pages.at[index];
        c = shadow_class_of(page.bit);
        seeks = anew || page.place == SHADOW_NO_PLACE;
        if (seeks) own[c / 2u] = 1u << 16u * (c % 2u);
    }
    ranks[thread] = own;
    barrier();
    for (uint step = 1u; step < SHADOW_BLOCK; step *= 2u) {
        uvec2 before = thread >= step ? ranks[thread - step] : uvec2(0u);
        barrier();
        ranks[thread] += before;
        barrier();
    }
    if (seeks) {
        uint first = anew ? first_page(push.places, c) : first_new(push.places, c);
        uint rank = sum_from(first, first + LINEAR_GROUP) + ((ranks[thread] - own)[c / 2u] >> 16u * (c % 2u) & 0xffffu);
        if (rank < found[c]) {
            uvec2 at = find_cell(first_free(push.places, c), rank);
            page.place = place_of(push.places.side, at.x, c, free_slot(push.places.cells.at[at.x].taken, at.y));
        } else {
            rank -= found[c];
            uint number = first_cell[c] + (rank >> 2u * c);
            uint cell = anew ? number : find_cell(first_free(push.places, SHADOW_CLASSES), number).x;
            page.place = place_of(push.places.side, cell, c, rank & places_of_cell(c) - 1u);
        }
        page.flags = SHADOW_PAGE_DRAW;
        push.places.pages.at[index] = page;
    }
    if ((page.flags & SHADOW_PAGE_DRAW) != 0u) atomicAdd(drawn, 1u);
    barrier();
    if (thread != 0u) return;
    if (drawn > 0u) atomicAdd(push.places.counts.counts.drawn, drawn);
    if (LINEAR_GROUP > 0u) return;
    push.places.counts.counts.pages = total;
    push.places.counts.counts.cells = used;
}
