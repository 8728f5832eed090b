/* SPDX-License-Identifier: MIT */
/**
 * Exclusive prefix sum of unsigned integers on the GPU, in place: the step between counting and filling that keeps every
 * list of the library in a fixed order. Blocks are scanned in shared memory and their totals recursively (Blelloch 1990). Cost: two
 * reads and two writes a value.
 */
#ifndef FNL_PASSES_PREFIX_SUM_H
#define FNL_PASSES_PREFIX_SUM_H

#include "graph/graph.h"

/** Names of the passes of one sum, made from a literal: PREFIX_SUM_NAMES("lights") */
struct prefix_sum_names {
    const char *block[4], *add[3], *buffers[4];
};
#define PREFIX_SUM_NAMES(what)                                                                                              \
    {                                                                                                                       \
        {what " sum", what " sum 2", what " sum 3", what " sum 4"},                                                         \
            {what " sum add", what " sum add 2", what " sum add 3"}, {                                                      \
            what " totals", what " totals 2", what " totals 3", what " totals 4"                                            \
        }                                                                                                                   \
    }

/**
 * Replaces values[i], i < count, by the sum of all values before i. To learn the total, give one element more, with any
 * value: it becomes the sum of the others. count is at least 1 and below 2^32 - 1024; sums saturate at 2^32 - 1. All steps run on
 * `queue`.
 */
void prefix_sum_add(struct graph *graph, const struct prefix_sum_names *names, enum graph_queue queue, graph_buffer values,
                    uint32_t count);

#endif
