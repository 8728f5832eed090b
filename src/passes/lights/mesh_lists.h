/* SPDX-License-Identifier: MIT */
/**
 * A list for each draw item (RTR 4, 20.1): the lights whose bounding spheres touch the item's box. Only shading that knows which
 * item it shades can use it. Cost: items times lights in view; from `tree_lights` on each item asks a tree of the lights (bvh.h), and has
 * the same entries.
 */
#ifndef FNL_PASSES_MESH_LISTS_H
#define FNL_PASSES_MESH_LISTS_H

#include "passes/geometry/geometry.h"
#include "passes/lights/light_list.h"

struct mesh_lists_params {
    struct clustered_params grid; /* through which the tree sorts lights; its pool_capacity is that of the lists */
    uint32_t tree_lights;         /* default 4096 */
};
struct mesh_lists_params mesh_lists_params_default(void);

/** All lights where there are more than four million items. */
struct light_list mesh_lists_add(struct graph *graph, gpu_device *device, const struct light_input *input,
                                 const struct lights_in_view *in_view, const struct geometry_scene *scene,
                                 const struct mesh_lists_params *params);

#endif
