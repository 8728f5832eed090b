/* SPDX-License-Identifier: MIT */
/** The steps that tiled and clustered lists share once the bounds of their cells are known: count, prefix sum, fill, totals. */
#ifndef FNL_PASSES_CELLS_H
#define FNL_PASSES_CELLS_H

#include "passes/geometry/prefix_sum.h"
#include "passes/lights/cells_shared.h"
#include "passes/lights/light_list.h"

/** Names of the passes and buffers; one static table for each list that a frame may hold. */
struct cells_names {
    const char *bounds, *count, *fill, *totals;
    const char *bounds_buffer, *sums_buffer, *cells_buffer, *ids_buffer, *overflow_buffer, *totals_buffer;
    struct prefix_sum_names sum;
};
#define CELLS_NAMES(what)                                                                                                   \
    {                                                                                                                       \
        what " bounds", what " count", what " fill", what " totals", what " cell bounds", what " sums", what " cells",      \
            what " ids", what " overflow", what " list totals", PREFIX_SUM_NAMES(what)                                      \
    }

struct cells_build {
    const struct cells_names *names;
    const struct gpu_shader *bounds_shader;
    uint32_t bounds_samples;                   /* specialisation constant 1 of the bounds shader */
    uint32_t bounds_groups_x, bounds_groups_y; /* y 0: x groups in a row */
    graph_buffer bounds_input;                 /* what the bounds shader reads besides, or id 0 */
    graph_image depth, front;                  /* or id 0 */
    uint32_t flags;                            /* CELLS_… */
    uint32_t pool_capacity;
    struct gpu_light_list *header; /* grid filled in; the addresses are filled in while recording */
    VkDeviceAddress header_address;
};

/** The CELLS_… flags that the parameters of tiles ask for. */
uint32_t tiled_flags(const struct tiled_params *params);

/** Adds bounds, count, sum, fill and totals, and returns the list (its kind is left to the caller). */
struct light_list cells_add(struct graph *graph, const struct light_input *input, const struct lights_in_view *in_view,
                            const struct cells_build *build);

/** Gathers the counts of a frame into a struct light_totals: the last of `sum_count` sums is the number of entries. */
graph_buffer cells_totals_add(struct graph *graph, const struct cells_names *names, const struct light_input *input,
                              const struct lights_in_view *in_view, graph_buffer sums, uint32_t sum_count,
                              graph_buffer overflow);

#endif
