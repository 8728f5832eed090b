/* SPDX-License-Identifier: MIT */
/**
 * Decals: what changes surfaces without being part of them. Two ways give the same picture: surfaces look the boxes that hold them up in a
 * light list while they are drawn (shaders/decals_raster.glsl; DOOM 2016, RTR4 20.4), or boxes are drawn over a finished G-buffer
 * (decals_gbuffer.h; RTR4 20.2).
 */
#ifndef FNL_PASSES_DECALS_H
#define FNL_PASSES_DECALS_H

#include "passes/lights/light_list.h"

struct decals_count_input {
    const struct light_list *list;
    graph_buffer decals;
    graph_image position, normal; /* of the AOVs: world-space position; view depth in w, 0 where nothing is seen */
    VkDeviceAddress view;
    uint32_t width, height;
};
/** Boxes and volumes that hold each pixel's surface: one uint a pixel. Cost: a walk through the pixel's list. */
graph_buffer decals_count_pass_add(struct graph *graph, const struct decals_count_input *input);

#endif
