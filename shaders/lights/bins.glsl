// SPDX-License-Identifier: MIT
// Bit masks of tiles, cut by those of depth bins (GPU_LIST_BINS): how they lie in memory, and the walk through what both have.
//
// Depth bins follow each other in zones of gpu_light_list.zone_slices, and each tile has a mask for each zone: of many lights that a tile holds, few
// are as near as the pixel, but nearly every word of a bin holds some light. Cells are the tiles of the first zone, those of the next …, then
// the bins. They are sets of lights in view, which are numbered by ascending index. 32 lights are a word, 32 words a
// group, 32 groups a top word. Zero words are not stored. The table (gpu_light_list.cells) begins with BINS_HEAD words: the number of
// lights in view, groups and top words; then for each cell a state and its top words; then for each cell and group where its
// words begin in the pool (gpu_light_list.ids), and which of the group's words are there. gpu_light_list.extra leads from lights in
// view to lights.
#ifndef LIGHTS_BINS_GLSL
#define LIGHTS_BINS_GLSL

const uint BINS_HEAD = 4u;
const uint BINS_ALL = 1u; // state of a cell that the pool could not hold: the spare list

struct bins_cell {
    uint state;
    uint tops;    // index of its top words in the table
    uint records; // … and of its groups
};

bins_cell bins_cell_of(uint cell, uint cell_count, uint group_count, uint top_count) {
    uint state = BINS_HEAD + cell * (top_count + 1u);
    return bins_cell(state, state + 1u, BINS_HEAD + cell_count * (top_count + 1u) + cell * group_count * 2u);
}

uint bins_zones(light_list_block l) { return (l.list.slices + l.list.zone_slices - 1u) / l.list.zone_slices; }
uint bins_slice(light_list_block l, float view_depth) { return slice_of(l, max(view_depth, 1e-30)); }

struct bins_cursor {
    bins_cell tile, bin;
    uint top_count;
    uint top, group, word;                // where the walk is
    uint groups_left, words_left, left;   // what is not visited yet: groups of the top word, words of the group, lights of the word
    uint tile_words, bin_words;           // which words of the group there are
    uint tile_offset, bin_offset;         // where they begin
};

// False: the pool could not hold the tile or the bin.
bool bins_begin(light_list_block l, uint tile, float view_depth, out bins_cursor c) {
    const_uint_array table = const_uint_array(l.list.cells);
    uint tile_count = l.list.tiles_x * l.list.tiles_y, slice = bins_slice(l, view_depth);
    uint first_bin = tile_count * bins_zones(l), cell_count = first_bin + l.list.slices;
    uint group_count = table.at[1];
    c.top_count = table.at[2];
    c.tile = bins_cell_of(slice / l.list.zone_slices * tile_count + tile, cell_count, group_count, c.top_count);
    c.bin = bins_cell_of(first_bin + slice, cell_count, group_count, c.top_count);
    c.top = 0xffffffffu;
    c.group = c.word = c.groups_left = c.words_left = c.left = c.tile_words = c.bin_words = c.tile_offset = c.bin_offset = 0u;
    return table.at[c.tile.state] != BINS_ALL && table.at[c.bin.state] != BINS_ALL;
}

// Moves on; false at the end. One loop that takes one step at a time: Mesa's CPU driver ends loops within loops too early for some threads,
// and runs those on that return from within one.
bool bins_next(light_list_block l, inout bins_cursor c, out uint id) {
    const_uint_array table = const_uint_array(l.list.cells);
    bool ended = false;
    while (c.left == 0u && !ended) {
        if (c.words_left != 0u) {
            uint word = uint(findLSB(c.words_left)), before = (1u << word) - 1u;
            c.words_left &= c.words_left - 1u;
            c.word = c.group * 32u + word;
            c.left = l.list.ids.at[c.tile_offset + uint(bitCount(c.tile_words & before))] &
                     l.list.ids.at[c.bin_offset + uint(bitCount(c.bin_words & before))];
        } else if (c.groups_left != 0u) {
            c.group = c.top * 32u + uint(findLSB(c.groups_left));
            c.groups_left &= c.groups_left - 1u;
            uint tile_record = c.tile.records + c.group * 2u, bin_record = c.bin.records + c.group * 2u;
            c.tile_offset = table.at[tile_record];
            c.tile_words = table.at[tile_record + 1u];
            c.bin_offset = table.at[bin_record];
            c.bin_words = table.at[bin_record + 1u];
            c.words_left = c.tile_words & c.bin_words;
        } else {
            c.top = min(c.top + 1u, c.top_count); // from -1
            ended = c.top == c.top_count;
            if (!ended) c.groups_left = table.at[c.tile.tops + c.top] & table.at[c.bin.tops + c.top];
        }
    }
    id = 0u;
    bool found = c.left != 0u;
    if (found) {
        id = l.list.extra.at[c.word * 32u + uint(findLSB(c.left))];
        c.left &= c.left - 1u;
    }
    return found;
}

#endif
