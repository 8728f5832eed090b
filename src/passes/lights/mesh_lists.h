/* SPDX-License-Identifier: MIT */
/**
 * A list for each draw item (RTR 4, 20.1): the lights whose bounding spheres touch the item's box. Only shading that knows which
 * item it shades can use it. Cost: items times lights in view.
 */
#ifndef FNL_PASSES_MESH_LISTS_H
#define FNL_PASSES_MESH_LISTS_H

#include "passes/geometry/geometry.h"
#include "passes/lights/light_list.h"

/** All lights where there are more than four million items. */
struct light_list mesh_lists_add(struct graph *graph, gpu_device *device, const struct light_input *input,
                                 const struct lights_in_view *in_view, const struct geometry_scene *scene,
                                 uint32_t pool_capacity);

#endif
