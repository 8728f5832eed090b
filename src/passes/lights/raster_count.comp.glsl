#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Counts the lights of the clusters behind one tile, among one chunk of the lights in view: each light adds one where its slices begin and
// takes it back after they end. One group for each tile and chunk.
#include "common.glsl"
#include "passes/lights/raster.glsl"

const uint THREADS = 128u; // two waves of 64 share what 4 KiB of shared memory hold
layout(local_size_x = THREADS) in;

shared uint changes[1024]; // by slice

void main() {
    uint tiles = RASTER.list.list.tiles_x * RASTER.list.list.tiles_y, slices = RASTER.list.list.slices;
    uint tile = LINEAR_GROUP % tiles, chunk = LINEAR_GROUP / tiles, thread = gl_LocalInvocationIndex;
    if (chunk >= RASTER.chunk_count) return;
    if (LINEAR_GROUP == 0u && thread == 0u) {
        RASTER.sums.at[RASTER.cell_count * RASTER.chunk_count] = 0u; // becomes the total
        RASTER.overflow.at[0] = 0u;
    }
    for (uint i = thread; i < slices; i += THREADS) changes[i] = 0u;
    barrier();
    uvec2 at = uvec2(tile % RASTER.list.list.tiles_x, tile / RASTER.list.list.tiles_x);
    uint first = chunk * RASTER.chunk_size, end = min(first + RASTER.chunk_size, RASTER.visible_sums.at[RASTER.light_count]);
    for (uint i = first + thread; i < end; i += THREADS) {
        uvec2 range = slices_in_tile(i, at);
        if (range.x > range.y) continue;
        atomicAdd(changes[range.x], 1u);
        if (range.y + 1u < slices) atomicAdd(changes[range.y + 1u], 0xffffffffu);
    }
    barrier();
    if (thread != 0u) return;
    uint count = 0u;
    for (uint slice = 0u; slice < slices; slice++) {
        count += changes[slice];
        RASTER.sums.at[(slice * tiles + tile) * RASTER.chunk_count + chunk] = count;
    }
}
