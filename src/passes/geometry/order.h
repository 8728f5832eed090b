/* SPDX-License-Identifier: MIT */
/** The order in which opaque items are drawn. */
#ifndef FNL_PASSES_GEOMETRY_ORDER_H
#define FNL_PASSES_GEOMETRY_ORDER_H

#include "passes/geometry/geometry.h"

/**
 * Changes draws of one view so that opaque items are drawn front to back: the groups of a bucket by the nearest point of their nearest item, and the items of a
 * group by their nearest points. Buckets stay in order, as each has a pipeline of its own, and so do blended and transmissive items. Items that the view does not see
 * are undrawn as before. Does nothing in scenes with more than 1024 buckets. Cost: a sort of all items, and one of the groups.
 */
void order_front_to_back(struct graph *graph, gpu_device *device, const struct geometry_scene *scene, VkDeviceAddress view, struct geometry_draws *draws);

#endif
