#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
// Decides which pages are resident, in one work group: of those that the last frame wanted, coarse ones first, as many as there is room
// for. Pages that nobody wants stay until their place is needed.
#include "common.glsl"
#include "scene.glsl"
#include "passes/texturing/virtual_shared.h"

const uint THREADS = 256u;
const uint KEPT = 2u;

layout(local_size_x = 256) in;
layout(push_constant, scalar) uniform push_block { gpu_virtual_push push; };

shared uint sums[THREADS];

// Sum over the threads before this one; `total`: over all.
uint sum_before(uint value, out uint total) {
    uint t = gl_LocalInvocationIndex;
    barrier();
    sums[t] = value;
    [[dont_unroll]] for (uint step = 1u; step < THREADS; step *= 2u) {
        barrier();
        uint other = t >= step ? sums[t - step] : 0u;
        barrier();
        sums[t] += other;
    }
    barrier();
    total = sums[THREADS - 1u];
    return sums[t] - value;
}

void main() {
    uint t = gl_LocalInvocationIndex, page_count = push.pages.v.page_count, capacity = push.pages.v.capacity;
    uint_array wanted = push.pages.v.wanted, table = push.pages.v.table, owners = push.pages.v.owners, places = push.pages.v.places;
    // Each thread has pages and places of its own.
    uint share = (page_count + THREADS - 1u) / THREADS, first = min(t * share, page_count), end = min(first + share, page_count);
    uint place_share = (capacity + THREADS - 1u) / THREADS, first_place = min(t * place_share, capacity),
         end_place = min(first_place + place_share, capacity);

    uint count = 0u, total_wanted, total_empty, total_unwanted, total_filled;
    for (uint v = first; v < end; v++) count += v < push.pages.v.always || wanted.at[v] != 0u ? 1u : 0u;
    uint rank = sum_before(count, total_wanted);
    for (uint v = first; v < end; v++) {
        bool is_wanted = v < push.pages.v.always || wanted.at[v] != 0u;
        wanted.at[v] = is_wanted && rank < capacity ? KEPT : 0u;
        if (is_wanted) rank++;
    }
    memoryBarrierBuffer();
    barrier();

    // Empty places, then those of pages that are not kept.
    count = 0u;
    for (uint p = first_place; p < end_place; p++) count += owners.at[p] == 0u ? 1u : 0u;
    rank = sum_before(count, total_empty);
    for (uint p = first_place; p < end_place; p++)
        if (owners.at[p] == 0u) places.at[rank++] = p;
    count = 0u;
    for (uint p = first_place; p < end_place; p++) {
        uint owner = owners.at[p];
        if (owner != 0u && wanted.at[owner - 1u] != KEPT) count++;
    }
    rank = sum_before(count, total_unwanted) + total_empty;
    for (uint p = first_place; p < end_place; p++) {
        uint owner = owners.at[p];
        if (owner != 0u && wanted.at[owner - 1u] != KEPT) places.at[rank++] = p;
    }
    memoryBarrierBuffer();
    barrier();

    // The first of those places are for what is kept and not there yet; these pages, and those that give way, are of different threads.
    count = 0u;
    for (uint v = first; v < end; v++) count += wanted.at[v] == KEPT && table.at[v] == 0u ? 1u : 0u;
    rank = sum_before(count, total_filled);
    for (uint v = first; v < end; v++) {
        if (wanted.at[v] != KEPT || table.at[v] != 0u) continue;
        uint p = places.at[rank++], owner = owners.at[p];
        if (owner != 0u) table.at[owner - 1u] = 0u;
        owners.at[p] = v + 1u;
        table.at[v] = p + 1u;
    }
    memoryBarrierBuffer();
    barrier();

    for (uint v = first; v < end; v++) wanted.at[v] = 0u;
    if (t != 0u) return;
    uint_array commands = push.pages.v.commands;
    commands.at[0] = VIRTUAL_BLOCKS;
    commands.at[1] = total_filled;
    commands.at[2] = 1u;
    commands.at[4] = total_wanted;
    commands.at[5] = capacity - total_empty + min(total_filled, total_empty);
    commands.at[6] = total_filled;
    commands.at[7] = total_wanted - min(total_wanted, capacity);
    commands.at[8] = total_filled - min(total_filled, total_empty);
}
