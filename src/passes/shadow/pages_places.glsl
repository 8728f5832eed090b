// SPDX-License-Identifier: MIT
// Places in the atlas, and the parts of gpu_shadow_places.sums.
#ifndef SHADOW_PAGES_PLACES_GLSL
#define SHADOW_PAGES_PLACES_GLSL

#include "passes/shadow/pages.glsl"

const uint CELL_UNITS = SHADOW_PAGE / SHADOW_UNIT; // on a side

uint cell_count(gpu_shadow_places p) { return p.side * p.side; }
uint first_new(gpu_shadow_places p, uint c) { return c * p.block_count; }
uint first_page(gpu_shadow_places p, uint c) { return (SHADOW_CLASSES + c) * p.block_count; }
uint first_free(gpu_shadow_places p, uint c) { return 2u * SHADOW_CLASSES * p.block_count + c * cell_count(p); } // c of SHADOW_CLASSES: of free cells

uint places_of_cell(uint c) { return 1u << 2u * c; }

// The unit where a place of a cell begins; places of class c go in rows of 2^c.
uint place_of(gpu_shadow_places p, uint cell, uint c, uint slot) {
    uvec2 at = uvec2(cell % p.side, cell / p.side) * CELL_UNITS + uvec2(slot & (1u << c) - 1u, slot >> c) * (CELL_UNITS >> c);
    return at.x | at.y << 16;
}

uint cell_of(gpu_shadow_places p, uint place) { return (place >> 16) / CELL_UNITS * p.side + (place & 0xffffu) / CELL_UNITS; }

uint slot_of(uint place, uint c) {
    uvec2 at = uvec2(place & 0xffffu, place >> 16) % CELL_UNITS / (CELL_UNITS >> c);
    return at.y << c | at.x;
}

#endif
