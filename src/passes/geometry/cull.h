/* SPDX-License-Identifier: MIT */
/** The parts of cull_add (geometry.h) that occlusion culling uses by itself. */
#ifndef FNL_PASSES_CULL_H
#define FNL_PASSES_CULL_H

#include "passes/geometry/geometry.h"
#include "passes/geometry/occlusion.h"
#include "passes/geometry/prefix_sum.h"

/**
 * cull_add without blended items, which have no order yet; opaque items that `occluders` (or NULL) hide are left out.
 * Passes and buffers are called "`what` …".
 */
struct geometry_draws cull_items_add(struct graph *graph, const char *what, const struct geometry_scene *scene,
                                     VkDeviceAddress view, const struct hierarchy *occluders);
/** Like cull_items_add(), but keeps only items that are at least `least_pixels` wide or high on the screen, or that
    reach in front of the near plane. */
struct geometry_draws cull_large_add(struct graph *graph, const char *what, const struct geometry_scene *scene,
                                     VkDeviceAddress view, const struct hierarchy *occluders, float least_pixels);
/** cull_add with occluders. */
struct geometry_draws cull_add_hidden(struct graph *graph, const struct geometry_scene *scene, VkDeviceAddress view,
                                      const struct hierarchy *occluders);

#endif
