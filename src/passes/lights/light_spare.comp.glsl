#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
// Makes the spare list (lights_shared.h), if cells have overflowed or it is asked for. A work group takes 32 lights, a word of every row; each
// thread writes that of its row.
#include "common.glsl"
#include "passes/lights/light_tiles.glsl"

layout(local_size_x = SPARE_ROWS) in;
layout(push_constant, scalar) uniform push_block { gpu_spare_push push; };

shared uvec4 tiles[32]; // first column and row, last ones
shared uvec2 bins[32];  // first, last; of lights that are not in view first > last

void take_light(uint lane, uint light) {
    tiles[lane] = uvec4(1u, 1u, 0u, 0u);
    bins[lane] = uvec2(1u, 0u);
    if (light >= push.light_count) return;
    uint slot = push.visible_sums.at[light];
    if (push.visible_sums.at[light + 1u] == slot) return;
    vec2 depths;
    tiles[lane] = tiles_of_light(push.view, push.bounds.at[slot], push.list.list.spare_tile_size, push.list.list.spare_tiles, depths);
    bins[lane] = uvec2(depths.x > 0.0 ? spare_bin(push.view, depths.x) : 0u,
                       depths.y < 1e30 ? spare_bin(push.view, depths.y) : SPARE_BINS - 1u);
}

void main() {
    uint row = gl_LocalInvocationIndex, words = push.list.list.spare_words;
    bool made = push.always == 1u || push.overflow.at[0] > 0u;
    if (LINEAR_GROUP == 0u && row == 0u) push.spare.at[0] = made ? 1u : 0u;
    if (!made) return;
    uvec2 size = push.list.list.spare_tiles;
    uint tile_count = size.x * size.y, bin = row - tile_count;
    uvec2 tile = uvec2(row % size.x, row / size.x);
    for (uint word = LINEAR_GROUP; word < words; word += gl_NumWorkGroups.x * gl_NumWorkGroups.y) { // the same for all threads
        barrier();
        if (row < 32u) take_light(row, word * 32u + row);
        barrier();
        uint mask = 0u;
        [[dont_unroll]] for (uint i = 0u; i < 32u; i++) { // unrolled, it takes a CPU driver over a second to compile
            bool holds = row < tile_count ? all(lessThanEqual(tiles[i].xy, tile)) && all(lessThanEqual(tile, tiles[i].zw))
                                          : bins[i].x <= bin && bin <= bins[i].y;
            if (holds) mask |= 1u << i;
        }
        if (row < tile_count + SPARE_BINS) push.spare.at[1u + row * words + word] = mask;
    }
}
