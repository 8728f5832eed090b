#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Writes the lights of the clusters behind one tile, ascending: as arrays, or as linked lists. A cluster that the pool cannot hold is
// marked to use all lights instead. Places come from the prefix sum of the counts, so two runs give the same bytes. One group for each
// tile and chunk.
#include "common.glsl"
#include "passes/lights/raster.glsl"

layout(constant_id = 1) const uint NODES = GPU_NODES_ARRAY;

const uint THREADS = 128u; // as many share the places of slices, lest these leave room for few waves
layout(local_size_x = THREADS) in;

shared uint places[1024]; // next place of each slice
shared uint ranges[THREADS], hits[THREADS / 32u];

bool fits(uint cell) { return RASTER.sums.at[(cell + 1u) * RASTER.chunk_count] <= RASTER.capacity; }

void write(uint cell, uint place, uint light) {
    if (NODES == GPU_NODES_ARRAY) {
        RASTER.ids.at[place] = light;
        return;
    }
    bool last = place + 1u == RASTER.sums.at[(cell + 1u) * RASTER.chunk_count];
    if (NODES == GPU_NODES_32) {
        RASTER.ids.at[place] = light << 20 | (last ? GPU_NODE_32_END : place + 1u);
    } else {
        uint shape = RASTER.list.list.lights.set.entities.at[light].shape;
        uint kind = shape == GPU_NO_SHAPE ? GPU_SHAPE_SPHERE : shape_at(set_of(RASTER.list), shape).shape.kind;
        RASTER.ids.at[2u * place] = kind << 24 | light;
        RASTER.ids.at[2u * place + 1u] = last ? GPU_NODE_END : place + 1u;
    }
}

void write_cell(uint cell) {
    uint first = RASTER.sums.at[cell * RASTER.chunk_count], count = RASTER.sums.at[(cell + 1u) * RASTER.chunk_count] - first;
    bool held = fits(cell);
    if (!held) atomicAdd(RASTER.overflow.at[0], 1u);
    if (NODES == GPU_NODES_ARRAY)
        RASTER.cells.at[cell] = gpu_cell(first, held ? count : GPU_CELL_ALL);
    else
        uint_array(RASTER.cells).at[cell] = !held ? GPU_NODE_ALL : count == 0u ? GPU_NODE_END : first;
}

void main() {
    uint tiles = RASTER.list.list.tiles_x * RASTER.list.list.tiles_y, slices = RASTER.list.list.slices;
    uint tile = LINEAR_GROUP % tiles, chunk = LINEAR_GROUP / tiles, thread = gl_LocalInvocationIndex;
    if (chunk >= RASTER.chunk_count) return;
    for (uint slice = thread; slice < slices; slice += THREADS) {
        uint cell = slice * tiles + tile;
        places[slice] = RASTER.sums.at[cell * RASTER.chunk_count + chunk];
        if (chunk == 0u) write_cell(cell);
    }
    uvec2 at = uvec2(tile % RASTER.list.list.tiles_x, tile / RASTER.list.list.tiles_x);
    uint first = chunk * RASTER.chunk_size, end = min(first + RASTER.chunk_size, RASTER.visible_sums.at[RASTER.light_count]);
    for (; first < end; first += THREADS) {
        if (thread < THREADS / 32u) hits[thread] = 0u;
        barrier();
        uint index = first + thread;
        if (index < end) {
            uvec2 range = slices_in_tile(index, at);
            ranges[thread] = range.x | range.y << 16;
            if (range.x <= range.y) atomicOr(hits[thread >> 5], 1u << (thread & 31u));
        }
        barrier();
        for (uint word = 0u; word < THREADS / 32u; word++)
            for (uint rest = hits[word]; rest != 0u; rest &= rest - 1u) {
                uint hit = word * 32u + uint(findLSB(rest)), light = RASTER.visible_ids.at[first + hit];
                uint low = ranges[hit] & 0xffffu, high = ranges[hit] >> 16;
                // Threads own slices: slice % THREADS == thread.
                for (uint slice = low + (thread + THREADS - low % THREADS) % THREADS; slice <= high; slice += THREADS) {
                    uint cell = slice * tiles + tile;
                    if (fits(cell)) write(cell, places[slice]++, light);
                }
            }
        barrier();
    }
}
