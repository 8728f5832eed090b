#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Reads the ids of a pixel and makes a cell of a light list of them, ascending. A pixel that more lights may reach than there is room for
// takes all lights.
#include "common.glsl"
#include "view.glsl"
#include "passes/shade/volumes.glsl"
#include "passes/shade/light_indexed_shared.h"

layout(constant_id = 2) const uint PACKING = INDEXED_IDS;

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_indexed_list_push push; };

uint first; // of the pixel's entries, which are sorted where they stand: so many do not fit into registers
uint count = 0u;

void add_light(uint light) {
    uint i = first + count++;
    for (uint before; i > first && (before = push.list.at[i - 1u]) > light; i--) push.list.at[i] = before;
    push.list.at[i] = light;
}

void add(uint rank) { add_light(push.ids.at[rank]); }

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy, size = push.view.view.size;
    if (any(greaterThanEqual(pixel, size))) return;
    uint at = pixel.y * size.x + pixel.x;
    if (at == 0u) push.cells.at[size.x * size.y] = gpu_cell(0u, GPU_CELL_ALL); // of points that are on no pixel's surfaces
    uint capacity = push.layers * INDEXED_LAYER_LIGHTS;
    first = at * capacity;
    bool full = false;
    if (PACKING == INDEXED_IDS) {
        uint here = push.counts.at[at], words = (capacity + 1u) / 2u;
        full = here > capacity;
        for (uint i = 0u; i < here && !full; i++) add((push.slots.at[at * words + i / 2u] >> 16u * (i & 1u) & 0xffffu) - 1u);
    } else {
        for (uint layer = 0u; layer < push.layers && !full; layer++) {
            uint here = push.counts.at[layer * size.x * size.y + at];
            full = here > INDEXED_LAYER_LIGHTS;
            if (here == 0u || full) continue;
            uvec4 texel = uvec4(round(texelFetch(textures[push.images[layer]], ivec2(pixel), 0) * 255.0));
            if (PACKING == INDEXED_SETS_PACKING) {
                uint found = 0u;
                for (uint i = 0u; i < INDEXED_LAYER_LIGHTS; i++)
                    if (texel[i] != 0u) {
                        add_light(push.slots.at[(layer * INDEXED_LAYER_LIGHTS + i) << 8 | texel[i]]);
                        found++;
                    }
                full = found != here; // two of a set are here: one of them has been overwritten
            } else if (PACKING == INDEXED_STENCIL) {
                for (uint i = 0u; i < here; i++) add(layer * INDEXED_BATCH + texel[i] - 1u);
            } else if (PACKING == INDEXED_SHIFT) {
                for (uint i = 0u; i < here; i++) { // the newest in the highest bits
                    uvec4 part = texel >> 6u - 2u * i & 3u;
                    add(layer * INDEXED_BATCH + (part.x | part.y << 2 | part.z << 4 | part.w << 6) - 1u);
                }
            } else { // greatest, least, and the same of the rest; of one or three the last two are the same
                uint ids[4] = uint[4](texel.x, 255u - texel.y, texel.z, 255u - texel.w);
                for (uint i = 0u; i < here; i++) add(layer * INDEXED_BATCH + ids[i] - 1u);
            }
        }
    }
    push.cells.at[at] = gpu_cell(first, full ? GPU_CELL_ALL : count);
    if (full) {
        atomicAdd(push.totals.at[2], 1u);
        return;
    }
    atomicAdd(push.totals.at[1], count);
}
