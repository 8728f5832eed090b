#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
// Puts the lights of each cell into ascending order: one work group a cell. Short lists by rank, long ones by radix: n log(lights).
#include "common.glsl"
#include "passes/lights/bvh.glsl"
#include "passes/geometry/radix.glsl"

layout(local_size_x = BVH_SORT_THREADS) in;
layout(push_constant, scalar) uniform push_block { gpu_bvh_sort_push push; };

const uint RANKED = 2u * BVH_SORT_THREADS; // they lie where the counts of the other way would
shared uint bases[RADIX_DIGITS];

// An id's place is the number of smaller ones.
void sort_by_rank(uint first, uint count) {
    uint thread = gl_LocalInvocationIndex;
    for (uint i = thread; i < count; i += BVH_SORT_THREADS) radix_counts[i] = push.first.at[first + i];
    barrier();
    for (uint i = thread; i < count; i += BVH_SORT_THREADS) {
        uint id = radix_counts[i], rank = 0u;
        for (uint k = 0u; k < count; k++) rank += radix_counts[k] < id ? 1u : 0u;
        push.target.at[first + rank] = id;
    }
}

void move_digits(coherent_uint_array from, coherent_uint_array to, uint first, uint count, uint shift) {
    uint thread = gl_LocalInvocationIndex;
    uint total = 0u, before = 0u;
    for (uint part = 0u; part < count; part += RADIX_LIMIT) {
        radix_clear();
        for (uint i = part + thread; i < min(part + RADIX_LIMIT, count); i += RADIX_THREADS) radix_count(radix_digit(from.at[first + i], shift));
        radix_sum();
        if (thread < RADIX_DIGITS) total += radix_total(thread);
        barrier();
    }
    if (thread < RADIX_DIGITS) bases[thread] = total;
    barrier();
    for (uint d = 0u; d < min(thread, RADIX_DIGITS); d++) before += bases[d];
    barrier();
    if (thread < RADIX_DIGITS) bases[thread] = before;
    barrier();
    for (uint block = 0u; block < count; block += RADIX_BLOCK) {
        uint begin = min(block + thread * RADIX_ITEMS, count), end = min(begin + RADIX_ITEMS, count);
        radix_clear();
        for (uint i = begin; i < end; i++) radix_count(radix_digit(from.at[first + i], shift));
        radix_sum();
        if (thread < RADIX_DIGITS) total = radix_total(thread);
        radix_spread();
        for (uint i = begin; i < end; i++) {
            uint id = from.at[first + i], digit = radix_digit(id, shift);
            to.at[first + bases[digit] + radix_take(digit)] = id;
        }
        barrier();
        if (thread < RADIX_DIGITS) bases[thread] += total;
        barrier();
    }
}

void main() {
    uint cell_count = push.counted == 1u ? min(push.cell_counter.at[0], push.cell_count) : push.cell_count;
    for (uint cell = LINEAR_GROUP; cell < cell_count; cell += gl_NumWorkGroups.x * gl_NumWorkGroups.y) { // the same for all threads
        uint first = push.list.list.cells.at[cell].offset, count = push.list.list.cells.at[cell].count;
        if (count == GPU_CELL_ALL || count == 0u) continue;
        if (count <= RANKED) {
            sort_by_rank(first, count);
        } else {
            for (uint step = 0u; step < push.steps; step++) {
                coherent_uint_array from = push.first, to = push.second;
                if ((step & 1u) == 1u) from = push.second, to = push.first;
                move_digits(from, to, first, count, step * RADIX_BITS); // one call, as it is inlined
                memoryBarrierBuffer();
                barrier();
            }
        }
        barrier();
    }
}
