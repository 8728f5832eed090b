/* SPDX-License-Identifier: MIT */
/** The steps that tiled and clustered lists share once the bounds of their cells are known: count, prefix sum, fill, totals. */
#ifndef FNL_PASSES_CELLS_H
#define FNL_PASSES_CELLS_H

#include "passes/lights/cells_shared.h"
#include "passes/lights/light_list.h"

/** What is known when the lights of each cell are counted: sums[cell * chunk_count + chunk]. */
struct cells_counted {
    const struct light_input *input;
    const struct lights_in_view *in_view;
    const struct cells_build *build;
    graph_buffer bounds, sums, marks; /* marks: what the count kept, where flags of `tests` have CELLS_KEPT; else id 0 where lights are not marked */
    uint32_t cell_count, chunk_size, chunk_count;
    struct gpu_compute_params tests; /* the constants of count and fill, without a shader */
};

/** Passes that take counted lights out of cells again, and what fills cells without them (backface.c). */
struct cells_refine {
    void (*add)(struct graph *graph, const struct cells_counted *counted, const void *user); /* NULL: nothing is taken out */
    const void *user;
    const struct gpu_shader *fill_shader;
    VkDeviceAddress address;   /* its gpu_cells_push.extra */
    graph_buffer cones, marks; /* read, and written where id is not 0, by fill_shader */
};

/** Whether cells with these flags need lights_in_view.reaches. */
static inline bool cells_use_reaches(uint32_t flags) { return (flags & (CELLS_CONES | CELLS_RECTANGLE)) != 0; }

struct cells_build {
    const char *what; /* passes and buffers are called "`what` …" */
    const struct gpu_shader *bounds_shader;
    uint32_t bounds_samples;                   /* specialisation constant 1 of the bounds shader */
    uint32_t bounds_rows;                      /* and 2, where it includes tile_depth.glsl; 3: flags */
    uint32_t bounds_groups_x, bounds_groups_y; /* y 0: x groups in a row */
    graph_buffer bounds_input;                 /* what the bounds shader reads besides, or id 0 */
    graph_image depth, front;                  /* or id 0 */
    uint32_t flags;                            /* CELLS_… */
    bool scattered_cells;                      /* neighbours in the grid are not neighbours in space */
    uint32_t pool_capacity;
    uint64_t extra_bytes;          /* 0: nothing extra */
    struct gpu_light_list *header; /* grid filled in */
    VkDeviceAddress header_address;
    struct cells_refine refine;
};

/** What all kinds of tiles have in common: the grid in a new header, its bounds shader run by one group a tile, flags. */
struct cells_build tiled_build(struct graph *graph, gpu_device *device, const struct light_input *input, graph_image depth,
                               const struct tiled_params *params);

/**
 * Adds bounds, count, sum, fill and totals, and returns the list (its kind is left to the caller). Where there are enough lights and cells, the
 * lights that touch each block of cells are marked first ("`what` blocks", "`what` mark"), so that a cell only looks at those; the lists are the
 * same bytes. The count keeps what it finds for the fill ("`what` kept"). Cost: a test for each light and block, and one for each cell and light
 * of its block; a bit for each of these pairs, at most 64 MiB each. Where cells would need more than that, lights are tested twice.
 */
struct light_list cells_add(struct graph *graph, const struct light_input *input, const struct lights_in_view *in_view,
                            const struct cells_build *build);

#endif
