/* SPDX-License-Identifier: MIT */
/**
 * Light lists of a grid in world space (RTR 4, 20.3: world-space clusters; and Just Cause 2's grid seen from above): a surface looks
 * itself up by its position. Nothing depends on the view, so the lists are built once, on the CPU, and kept until the lights change.
 */
#ifndef FNL_PASSES_WORLD_GRID_H
#define FNL_PASSES_WORLD_GRID_H

#include "base/maths.h"
#include "passes/lights/light_list.h"

struct world_grid_params {
    bool flat; /* one cell for all heights: the grid is seen from above; default false */
    float
        cell_size; /* metres; 0: by the number of lights; default 0, with `flat` 4. Doubled while a limit on cells or spans is exceeded */
    uint32_t cell_limit;  /* default 2^20 */
    uint64_t span_limit;  /* cells in the boxes round all lights, each as often as it lies in one; default 2^26 */
    uint64_t entry_limit; /* entries that may be stored: cells beyond use all lights; default 2^28 */
};
struct world_grid_params world_grid_params_default(void);

/** A grid, and the lists that were built for it; kept from frame to frame. */
struct world_grid {
    const fnl_host *host;
    ARRAY(struct gpu_cell) cells; /* x fastest, then y, then z */
    ARRAY(uint32_t) ids;
    vec3 origin;
    float cell_size, inverse_size;
    uint32_t size[3];
    uint32_t light_count; /* that reach anything */
    uint64_t entry_count;
    uint32_t overflow_cells;
    struct gpu_buffer cell_buffer, id_buffer;
    struct world_grid_params params; /* those that it was built with */
    uint64_t version;                /* of the lights; UINT64_MAX: none yet */
    uint32_t build_count;
};
void world_grid_init(struct world_grid *grid, const fnl_host *host);
void world_grid_finish(struct world_grid *grid, gpu_device *device);

/**
 * Fills `cells` and `ids`: each of the bounds of these kinds (light_input.kinds) goes to the cells that its bounding sphere touches. The grid covers where both bounds and `scene` are
 * (which may be empty: then where bounds are); cells at its border reach on to infinity. Cost: one step for each light and cell that touch.
 */
fnl_result world_grid_build(struct world_grid *grid, const struct gpu_entity_bounds *bounds, uint32_t count, uint32_t kinds,
                            const struct box *scene, const struct world_grid_params *params);
/** The cell that a position is looked up in, as shaders do it. */
uint32_t world_grid_cell(const struct world_grid *grid, vec3 position);

/**
 * The lists of a frame. `version` changes when the bounds do: then, and in the first frame, they are built and a pass uploads them;
 * otherwise there is no pass at all. `bounds` are those of `input`, and its kinds stay the same.
 */
struct light_list world_grid_add(struct world_grid *grid, struct graph *graph, gpu_device *device,
                                 const struct light_input *input, const struct gpu_entity_bounds *bounds, uint64_t version,
                                 const struct box *scene, const struct world_grid_params *params);

#endif
