// SPDX-License-Identifier: MIT
// Ids of a visibility buffer, and the order of its pixels.
#ifndef VISIBLE_GLSL
#define VISIBLE_GLSL

#define SAMPLES_AT VISIBLE_SAMPLES_ID
#define FLOATS_AT VISIBLE_FLOATS_ID
#include "common.glsl"
#include "scene_shared.h"
#include "passes/shade/samples.glsl"
#include "passes/visibility/visible_shared.h"

layout(constant_id = VISIBLE_LISTED_ID) const uint LISTED = VISIBLE_GRID;

// Bits 0..31 and 32..63 of a sample's id. With several samples the targets hold bytes: few devices have samples of integers.
uvec2 visible_id(uint ids, uint ids_high, ivec2 pixel, int at) {
    if (SAMPLES > 1u) {
        uint low = packUnorm4x8(texelFetch(textures_multisampled[ids], pixel, at));
        return uvec2(low, ids_high == GPU_TEXTURE_NONE ? 0u : packUnorm4x8(texelFetch(textures_multisampled[ids_high], pixel, at)));
    }
    uint high = ids_high == GPU_TEXTURE_NONE ? 0u : texelFetch(textures_uint[ids_high], pixel, 0).r;
    return uvec2(texelFetch(textures_uint[ids], pixel, 0).r, high);
}

// Item + 1, or 0 where nothing is seen.
uint visible_item(uvec2 id, uint triangle_bits) {
    return id.x >> triangle_bits | (triangle_bits == 0u ? 0u : id.y << (32u - triangle_bits));
}

uint visible_triangle(uvec2 id, uint triangle_bits) { return id.x & ((1u << triangle_bits) - 1u); }

// The pixel of a thread, 64 to a group, and back.
uvec2 pixel_of_place(uvec2 block, uint place) {
    uint square = place >> 2;
    return block * 8u + uvec2(square & 3u, square >> 2) * 2u + uvec2(place & 1u, place >> 1 & 1u);
}

uint place_of_pixel(uvec2 pixel, uvec2 size) {
    uvec2 block = pixel >> 3, square = pixel >> 1 & 3u;
    return (block.y * (size.x + 7u >> 3) + block.x) * 64u + (square.y * 4u + square.x) * 4u + (pixel.y & 1u) * 2u + (pixel.x & 1u);
}

#endif
