/* SPDX-License-Identifier: MIT */
/**
 * Exclusive prefix sum of unsigned integers on the GPU, in place: the step between counting and filling that keeps every
 * list of the library in a fixed order. Blocks are scanned in shared memory and their totals recursively (Blelloch 1990). Cost: two
 * reads and two writes a value.
 */
#ifndef FNL_PASSES_PREFIX_SUM_H
#define FNL_PASSES_PREFIX_SUM_H

#include "graph/graph.h"

/**
 * Replaces values[i], i < count, by the sum of all values before i. To learn the total, give one element more, with any
 * value: it becomes the sum of the others. count is at least 1 and below 2^32 - 1024; sums saturate at 2^32 - 1. All steps run on
 * `queue`; passes and buffers are called "`what` sum …" and "`what` totals".
 */
void prefix_sum_add(struct graph *graph, const char *what, enum graph_queue queue, graph_buffer values, uint32_t count);

#endif
