/* SPDX-License-Identifier: MIT */
/** How many cells of a grid lights touch, told from some of them: how large the pool of a list has to be is known before it is made. */
#ifndef FNL_RENDER_LIGHT_REACH_H
#define FNL_RENDER_LIGHT_REACH_H

#include "passes/lights/clustered.h"
#include "render/device/scene.h"
#include "view_shared.h"

struct light_reach {
    double in_view;        /* lights */
    double tiles;          /* a tile for each light that may touch it */
    double slices;         /* … a slice of depth */
    double clusters;       /* … a tile within a slice */
};

/**
 * Looks at no more than 4096 of the lights, evenly spread, by the box round their bounding sphere; sums are widened by three standard
 * errors of such a sample. Fewer lights are all looked at: then no sum is less than what lists find. Cost: under a millisecond.
 */
struct light_reach light_reach_estimate(const struct gpu_view *view, const struct gpu_entity_bounds *lights, uint32_t count,
                                        const struct clustered_params *grid);

/** Pairs of an item of the scene and a light in view whose sphere touches the item's box; told from no more than 256 nodes and 1024 lights. */
double light_reach_items(const struct gpu_view *view, const struct gpu_entity_bounds *lights, uint32_t count, const fnl_scene *scene);

#endif
