// SPDX-License-Identifier: MIT
// What the shaders that choose pages share.
#ifndef SHADOW_PAGES_GLSL
#define SHADOW_PAGES_GLSL

#include "common.glsl"

#ifndef LIGHTS_ITERATE_GLSL
layout(buffer_reference) readonly buffer lighting_block;
#endif
#ifndef SHADOWS_FACES_GLSL
layout(buffer_reference) buffer shadow_page_array;
layout(buffer_reference) buffer const_shadow_shape_array;
layout(buffer_reference) buffer const_shadow_sun_array;
#endif
layout(buffer_reference) buffer shadow_shape_array;
layout(buffer_reference) buffer shadow_choice_block;
layout(buffer_reference) buffer shadow_counts_block;
layout(buffer_reference) buffer shadow_cell_array;

#include "passes/shadow/pages_shared.h"

#ifndef SHADOWS_FACES_GLSL
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer shadow_page_array { gpu_shadow_page at[]; };
#endif
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer shadow_shape_array { gpu_shape at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer shadow_choice_block { gpu_shadow_choice choice; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer shadow_counts_block { gpu_shadow_counts counts; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer shadow_cell_array { gpu_shadow_cell at[]; };

// Levels that the pages of a light are made coarser under a pressure, or SHADOW_TRACED. The less important lights give way first.
uint shadow_bias(uint pressure, uint cut, uint least, uint importance) {
    if (importance >= cut && pressure > 0u) pressure--;
    if (importance == SHADOW_SPARE) return pressure < SHADOW_SPARE_PRESSURES ? pressure : SHADOW_TRACED;
    pressure -= min(pressure, SHADOW_SPARE_PRESSURES);
    uint offset = importance > least ? min((importance - least) / 2u, SHADOW_MOST_OFFSET) : 0u;
    uint all = SHADOW_BIASES - 1u + SHADOW_MOST_OFFSET; // from here on every light is at the coarsest
    if (pressure > all && offset < pressure - all) return SHADOW_TRACED;
    return pressure > offset ? min(pressure - offset, SHADOW_BIASES - 1u) : 0u;
}

// The wanted pages of a face; bits that are of no page are left out.
void shadow_load_face(const_uint_array wanted, uint face, out uint words[SHADOW_FACE_WORDS]) {
    for (uint i = 0u; i < SHADOW_FACE_WORDS; i++) words[i] = wanted.at[face * SHADOW_FACE_WORDS + i];
    words[10] &= 0xffffffu;
}

// Bits 0, 2, 4 … of each half of a word, next to each other.
uint shadow_even_bits(uint x) {
    x &= 0x55555555u;
    x = (x | x >> 1) & 0x33333333u;
    x = (x | x >> 2) & 0x0f0f0f0fu;
    return (x | x >> 4) & 0x00ff00ffu;
}

// Each page becomes the one of the next level that holds it; those of the last level stay. Word 10 has levels 2 to 7 in bits 0, 16, 20, 21, 22 and 23.
void shadow_coarsen_face(inout uint words[SHADOW_FACE_WORDS]) {
    uint last = words[10], next = (last & 0x700000u) << 1 | (last & 0x800000u);
    if ((last & 0xf0000u) != 0u) next |= 0x100000u;
    uint x = last & 0xffffu; // rows of 4 bits to rows of 2
    x = shadow_even_bits((x | x >> 4) & 0x0f0fu | ((x | x >> 4) & 0x0f0fu) >> 1);
    next |= (x & 3u | x >> 2 & 0xcu) << 16;
    for (uint i = 0u; i < 2u; i++) { // rows of 8 bits to rows of 4
        x = words[8u + i];
        x |= x >> 8;
        x = shadow_even_bits(x | x >> 1);
        next |= (x & 0xfu | x >> 12 & 0xf0u) << (8u * i);
        words[8u + i] = 0u;
    }
    for (uint i = 0u; i < 8u; i++) { // rows of 16 bits to rows of 8
        x = words[i] | words[i] >> 16;
        words[8u + i / 4u] |= (shadow_even_bits(x | x >> 1) & 0xffu) << (8u * (i % 4u));
        words[i] = 0u;
    }
    words[10] = next;
}

// Pages of each class.
uvec4 shadow_count_face(uint words[SHADOW_FACE_WORDS]) {
    uint last = words[10];
    uvec4 counts = uvec4(bitCount(last & 0x1fffffu), last >> 21 & 1u, last >> 22 & 1u, last >> 23 & 1u);
    for (uint i = 0u; i < 10u; i++) counts.x += bitCount(words[i]);
    return counts;
}

uint shadow_class_of(uint bit) {
    bit %= SHADOW_FACE_WORDS * 32u;
    return bit < 341u ? 0u : bit - 340u;
}

uint shadow_youth(gpu_shadow_cell cell) { return (cell.taken.x | cell.taken.y) != 0u ? SHADOW_YOUTHS : cell.youth; }

const uint CELL_UNITS = SHADOW_PAGE / SHADOW_UNIT; // on a side

uint places_of_cell(uint c) { return 1u << 2u * c; }

// Of an atlas `side` cells wide, the cell that a place lies in; and which of the cell's places of class c it is, in rows of 2^c.
uint cell_of(uint side, uint place) { return (place >> 16) / CELL_UNITS * side + (place & 0xffffu) / CELL_UNITS; }
uint slot_of(uint place, uint c) {
    uvec2 at = uvec2(place & 0xffffu, place >> 16) % CELL_UNITS / (CELL_UNITS >> c);
    return at.y << c | at.x;
}
uint place_of(uint side, uint cell, uint c, uint slot) {
    uvec2 at = uvec2(cell % side, cell / side) * CELL_UNITS + uvec2(slot & (1u << c) - 1u, slot >> c) * (CELL_UNITS >> c);
    return at.x | at.y << 16;
}

#endif
