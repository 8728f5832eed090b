/* SPDX-License-Identifier: MIT */
/** The order in which opaque items are drawn. */
#ifndef FNL_PASSES_GEOMETRY_ORDER_H
#define FNL_PASSES_GEOMETRY_ORDER_H

#include "passes/geometry/geometry.h"

/**
 * Sorts the draws of one view so that opaque items are drawn front to back: the groups of a bucket by the nearest
 * point of their nearest item, the items of a group by their nearest points. Buckets keep their order, because each
 * has its own pipeline. Blended and transmissive items keep their order. Culled items stay culled. No effect in scenes
 * with more than 1024 buckets.
 *
 * Cost: a sort of all items and a sort of all groups.
 */
void order_front_to_back(struct graph *graph, gpu_device *device, const struct geometry_scene *scene, VkDeviceAddress view, struct geometry_draws *draws);

#endif
