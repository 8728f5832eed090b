/* SPDX-License-Identifier: MIT */
/**
 * Stable radix sort of pairs of unsigned integers on the GPU, four bits a step, lowest first: count the digits of blocks, prefix sum,
 * move. No atomics and no subgroups, so the order never depends on the device (Satish, Harris, Garland 2009, "Designing efficient
 * sorting algorithms for manycore GPUs"). Cost: a step reads the pairs twice and writes them once.
 */
#ifndef FNL_PASSES_RADIX_SORT_H
#define FNL_PASSES_RADIX_SORT_H

#include "passes/geometry/prefix_sum.h"

struct radix_sort_params {
    const char *what; /* passes and buffers are called "`what` sort …" */
    enum graph_queue queue;
    graph_buffer pairs;    /* key, value; not changed */
    uint32_t capacity;     /* pairs that the buffer holds, at least 1, below 2^31 */
    uint32_t bits;         /* of the keys, 1 .. 32, rounded up to a multiple of 4: higher ones are ignored */
    graph_buffer count;    /* how many pairs there are, at most `capacity`; id 0: `capacity` */
    uint64_t count_offset; /* bytes */
};

/** Returns the pairs by ascending key; equal keys keep their order. What lies behind the count is undefined. */
graph_buffer radix_sort_add(struct graph *graph, const struct radix_sort_params *params);

#endif
