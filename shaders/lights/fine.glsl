// SPDX-License-Identifier: MIT
// Tiles with a bit mask per pixel, or per 2 x 2 pixels, over the tile's lights (GPU_LIST_FINE). gpu_light_list.extra holds the masks and
// behind them, where shading may not be where depth says, the positions that the masks were made for. Packed tiles have no masks.
#ifndef LIGHTS_FINE_GLSL
#define LIGHTS_FINE_GLSL

const float FINE_POSITION_SLACK = 1e-5; // of the distances of position and eye from the world's origin

// How far from the tested position a point may be.
float fine_slack(light_list_block l, vec3 position) { return FINE_POSITION_SLACK * (length(position) + l.list.eye_distance); }

// Where the masks of a tile begin, behind those of all tiles before it: n entries take no more than n / 32 + 1 words a pixel, so
// (entries before) / 32 + (tiles before) are enough for all of them.
uint fine_masks_of(light_list_block l, uint cell, uint first) {
    uint side = l.list.tile_size / l.list.mask_size;
    return (first / 32u + cell) * side * side;
}

// Pixels of the tiles, tile by tile.
uint fine_pixel_of(light_list_block l, uint tile, uvec2 pixel_in_tile) {
    return (tile * l.list.tile_size + pixel_in_tile.y) * l.list.tile_size + pixel_in_tile.x;
}

// Whether the masks are those of the point: a surface that covers its pixel in part may be shaded elsewhere.
bool fine_tested(light_list_block l, uint tile, uvec2 pixel_in_tile, vec3 position) {
    if (l.list.positions == 0u) return true;
    uint at = l.list.positions + fine_pixel_of(l, tile, pixel_in_tile) * 3u;
    vec3 tested = vec3(uintBitsToFloat(l.list.extra.at[at]), uintBitsToFloat(l.list.extra.at[at + 1u]),
                       uintBitsToFloat(l.list.extra.at[at + 2u]));
    return distance(tested, position) <= 0.9 * fine_slack(l, tested);
}

struct fine_cursor {
    uint first, end; // entries of the tile
    uint word, bits; // where the next mask is, what is left of this one; packed: where the tile's words are
    bool masked, packed;
};

// Place `entry` of a packed tile.
uint fine_unpacked(light_list_block l, uint first, uint entry) {
    uint word = const_uint_array(l.list.cells).at[first + entry / 3u];
    return word >> entry % 3u * GPU_PACKED_BITS & GPU_PACKED_IN_VIEW - 1u;
}

fine_cursor fine_begin_packed(light_list_block l, uint cell) {
    fine_cursor c = fine_cursor(0u, 0u, cell * GPU_PACKED_WORDS, 0u, false, true);
    for (uint i = 0u; i < GPU_PACKED_WORDS; i++) c.end += const_uint_array(l.list.cells).at[c.word + i] >> 3u * GPU_PACKED_BITS;
    if (const_uint_array(l.list.cells).at[c.word] == GPU_PACKED_ALL) {
        c.end = const_uint_array(l.list.cells).at[c.word + 1u];
        c.packed = false;
    }
    return c;
}

// False: no tile serves the point. Scattered ones are asked for on the pixel that they are seen on.
bool fine_begin(light_list_block l, uvec2 tile, uvec2 pixel, vec3 position, out fine_cursor c) {
    uint index = tile.y * l.list.tiles_x + tile.x, cell = l.list.first_cell + index;
    uvec2 pixel_in_tile = pixel - tile * l.list.tile_size;
    c = fine_cursor(0u, 0u, 0u, 0u, l.list.mask_size != 0u, false);
    bool tested = fine_tested(l, index, pixel_in_tile, position);
    if (!tested || (LIST_SCATTERED && l.list.positions == 0u)) {
        uint first = tested ? l.list.first_cell : l.list.other_cell;
        if (first == GPU_CELL_ALL) return false;
        cell = first + index;
        c.masked = false;
    }
    if (l.list.packed == 1u) {
        c = fine_begin_packed(l, cell);
        return true;
    }
    gpu_cell at = l.list.cells.at[cell];
    if (at.count == GPU_CELL_ALL) return false;
    c.first = at.offset;
    c.end = at.offset + at.count;
    if (c.masked) {
        uvec2 square = pixel_in_tile / l.list.mask_size;
        c.word = fine_masks_of(l, cell, at.offset) +
                 (square.y * (l.list.tile_size / l.list.mask_size) + square.x) * ((at.count + 31u) / 32u);
    }
    return true;
}

// Moves on; false at the end. `first` runs over the entries, by words of the mask where there is one.
bool fine_next(light_list_block l, inout fine_cursor c, out uint id) {
    id = 0u;
    if (!c.masked) {
        if (c.first >= c.end) return false;
        id = l.list.ids.at[c.packed ? fine_unpacked(l, c.word, c.first) : c.first];
        c.first++;
        return true;
    }
    while (c.bits == 0u && c.first < c.end) { // no return from within: see bins_next()
        c.bits = l.list.extra.at[c.word++];
        c.first += 32u;
    }
    if (c.bits == 0u) return false;
    id = l.list.ids.at[c.first - 32u + uint(findLSB(c.bits))];
    c.bits &= c.bits - 1u;
    return true;
}

#endif
