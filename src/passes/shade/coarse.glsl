// SPDX-License-Identifier: MIT
// Blocks of SIZE x SIZE pixels, and the pixels of those that are not alike: what passes at a coarse rate share. A group has 64 threads and a
// tile of 8 x 8 blocks. coarse_find.comp.glsl leaves a word for each block; here a thread has first a block, then pixels of blocks that are
// not alike:
//
//     coarse_walk walk = coarse_begin();
//     for (uint turn = 0u; turn < walk.turns; turn++) {
//         ivec2 pixel;
//         uint side;
//         if (coarse_work(walk, turn, pixel, side)) …
//     }
//
// In the first turn that is the block's first pixel. It stands for as many pixels across as `side` says: the whole block where walk.kind is COARSE_SHARED.
//
// Sathe and Janczak, "Deferred Coarse Pixel Shading", GPU Pro 7 (2016), III.2.
#ifndef COARSE_GLSL
#define COARSE_GLSL

#include "gbuffer.glsl"
#include "passes/shade/coarse_shared.h"

layout(constant_id = COARSE_SIZE_ID) const uint SIZE = 2u; // 1, 2, 4
layout(constant_id = COARSE_FLAGS_ID) const uint FLAGS = 0u;
#ifdef FOVEATED
const bool COARSE_IS_FOVEA = true;
#elif defined(UNFOVEATED)
const bool COARSE_IS_FOVEA = false;
#else
const bool COARSE_IS_FOVEA = (FLAGS & COARSE_FOVEA) != 0u;
#endif

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_coarse_push push; };

ivec2 coarse_last() { return ivec2(push.gbuffer.view.view.size) - 1; }
bool coarse_inside(ivec2 pixel) { return all(lessThanEqual(pixel, coarse_last())); }

// The base colour that the G-buffer holds.
vec3 color_at(ivec2 pixel) { return gbuffer_decode_color(gbuffer_fetch(push.gbuffer, 0u, pixel, -1).rgb); }

// Of the group's words in push.blocks.
uint coarse_base() { return (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * COARSE_GROUP; }

// First pixel of a tile's block: neighbours in number are neighbours in the picture (Morton order), so that threads side by side want the same
// lights.
ivec2 coarse_first(uint block) {
    uvec2 at = uvec2(block & 1u | block >> 1 & 2u | block >> 2 & 4u, block >> 1 & 1u | block >> 2 & 2u | block >> 3 & 4u);
    return ivec2((gl_WorkGroupID.xy * 8u + at) * SIZE);
}

struct coarse_walk {
    ivec2 first; // the thread's block: its top left pixel
    uint kind;   // what that is
    uint base;
    uint items;  // pixels of the tile's blocks that are not alike, but for their first ones
    uint fine;   // how many such blocks there are; behind them are those lit by quads
    uint quads;  // of these, but for their first ones
    uint turns;
};

coarse_walk coarse_begin() {
    coarse_walk walk;
    walk.base = coarse_base();
    walk.first = coarse_first(gl_LocalInvocationIndex);
    walk.kind = push.blocks.at[walk.base + gl_LocalInvocationIndex] & COARSE_WORD_KIND;
    walk.fine = push.blocks.at[walk.base] >> COARSE_WORD_COUNT_SHIFT & COARSE_WORD_COUNT;
    walk.items = walk.fine * (SIZE * SIZE - 1u);
    walk.quads = COARSE_IS_FOVEA ? (push.blocks.at[walk.base] >> COARSE_WORD_HALVES_SHIFT & COARSE_WORD_COUNT) * 3u : 0u;
    walk.turns = 1u + (walk.items + walk.quads + COARSE_GROUP - 1u) / COARSE_GROUP;
    return walk;
}

uint coarse_block(coarse_walk walk, uint index) { return push.blocks.at[walk.base + index] >> COARSE_WORD_FINE_SHIFT & COARSE_WORD_FINE; }

// The thread's pixel in a turn; false when it has none. Whether it shows a surface is for the caller to see.
bool coarse_work(coarse_walk walk, uint turn, out ivec2 pixel, out uint side) {
    pixel = walk.first;
    side = walk.kind == COARSE_SHARED ? SIZE : COARSE_IS_FOVEA && walk.kind == COARSE_HALF ? 2u : 1u;
    if (turn == 0u) return walk.kind != COARSE_NOTHING;
    uint item = (turn - 1u) * COARSE_GROUP + gl_LocalInvocationIndex;
    side = 1u;
    if (COARSE_IS_FOVEA && item >= walk.items && item - walk.items < walk.quads) {
        uint quad = item - walk.items, place = 1u + quad % 3u;
        side = 2u;
        pixel = coarse_first(coarse_block(walk, walk.fine + quad / 3u)) + 2 * ivec2(place & 1u, place >> 1);
        return coarse_inside(pixel);
    }
    if (item >= walk.items) return false;
    uint block = coarse_block(walk, item / (SIZE * SIZE - 1u));
    uint inside = 1u + item % max(SIZE * SIZE - 1u, 1u);
    pixel = coarse_first(block) + ivec2(inside % SIZE, inside / SIZE);
    return coarse_inside(pixel);
}

// The pixel that stands for `side` x `side` of them from `first` on. Where what they show does not matter: one near the middle, if that shows a surface,
// else any that does.
ivec2 coarse_standing(ivec2 first, uint side) {
    if (!COARSE_IS_FOVEA || side == 1u) return first;
    uint count = side * side, middle = side == 4u ? 5u : 0u;
    for (uint i = 0u; i < count; i++) {
        uint at = (middle + i) % count;
        ivec2 pixel = first + ivec2(at % side, at / side);
        if (coarse_inside(pixel) && gbuffer_depth(push.gbuffer, pixel) > 0.0) return pixel;
    }
    return first;
}

#endif
