// SPDX-License-Identifier: MIT
// What the steps of the fine-pruned tiles share.
#ifndef FINE_STEPS_GLSL
#define FINE_STEPS_GLSL

#include "view.glsl"
#include "passes/lights/cells.glsl"

layout(buffer_reference) buffer fine_box_array;
layout(buffer_reference) buffer fine_range_array;
layout(buffer_reference) buffer fine_volume_array;

#include "passes/lights/fine_shared.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer fine_box_array { gpu_fine_box at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer fine_range_array { gpu_fine_range at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer fine_volume_array { gpu_fine_volume at[]; };

layout(push_constant, scalar) uniform push_block { gpu_fine_push push; };

const float FINE_FAR = 1e30;

uint fine_flags(uint list) { return push.lists >> list * 8u & 255u; }
uint fine_tile_count() { return push.list.list.tiles_x * push.list.list.tiles_y; }
uvec2 fine_blocks() { return (uvec2(push.list.list.tiles_x, push.list.list.tiles_y) + push.block - 1u) / push.block; }
uint fine_words() { return (push.list.list.local_count + 31u) / 32u; } // of a block's marks
uint fine_marks_of(uint list, uvec2 tile) {
    uvec2 blocks = fine_blocks(), block = tile / push.block;
    return ((list * blocks.y + block.y) * blocks.x + block.x) * fine_words();
}

uint fine_squares() { // of a tile that have masks of their own
    uint side = push.list.list.mask_size == 0u ? 0u : push.list.list.tile_size / push.list.list.mask_size;
    return side * side;
}

gpu_fine_range fine_range_of(uint flags, uvec2 tile) {
    uint index = tile.y * push.list.list.tiles_x + tile.x;
    return push.ranges.at[(flags & FINE_BLENDED) != 0u ? fine_tile_count() + index : index];
}

// The view depths that a list of the tile is for; x > y: none.
vec2 fine_depths(uint flags, gpu_fine_range range) {
    bool empty = range.near > range.far, both = (flags & FINE_MIN_DEPTH) != 0u && (flags & FINE_MAX_DEPTH) != 0u;
    if (both && empty) return vec2(1.0, -1.0);
    vec2 depths = vec2(0.0, FINE_FAR);
    if (!empty && (flags & FINE_MIN_DEPTH) != 0u) depths.x = range.near * (1.0 - CELL_SLACK);
    // Blended surfaces before the sky may stand at any depth.
    bool open = range.sky != 0u && (!both || (flags & FINE_BLENDED) != 0u);
    if (!empty && (flags & FINE_MAX_DEPTH) != 0u && !open) depths.y = range.far * (1.0 + CELL_SLACK);
    return depths;
}

// Whether the light may reach a rectangle of the screen (pixels: left, top, right, bottom) between two view depths.
bool fine_touches(gpu_fine_box box, uint flags, vec4 rect, vec2 depths) {
    return box.kind == flags >> FINE_KIND_SHIFT && box.rect.x <= box.rect.z && all(lessThanEqual(box.rect.xy, rect.zw)) &&
           all(greaterThanEqual(box.rect.zw, rect.xy)) && box.depth.x <= depths.y && box.depth.y >= depths.x;
}

#endif
