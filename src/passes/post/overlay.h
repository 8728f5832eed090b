/* SPDX-License-Identifier: MIT */
/**
 * What goes over a finished picture, and how it comes to another size. Cost: the pixels of the triangles; of scaling, those of the target.
 */
#ifndef FNL_PASSES_OVERLAY_H
#define FNL_PASSES_OVERLAY_H

#include "fanal/overlay.h"
#include "graph/graph.h"

struct overlay_params {
    const fnl_overlay *overlay; /* read during the call */
    uint32_t images[FNL_OVERLAY_IMAGES_MAX]; /* bindless: sampled; GPU_NO_INDEX: white */
    bool linear, swap;          /* of the picture, as tonemap_params has them */
    int32_t x, y;               /* place of the picture's upper left corner, where it is a part of what the overlay is for */
};
/** Draws it over `picture`. */
void overlay_add(gpu_device *device, struct graph *graph, graph_image picture, const struct overlay_params *params);

/** The picture at another size, bilinear. */
graph_image scale_add(gpu_device *device, struct graph *graph, graph_image picture, uint32_t width, uint32_t height);

#endif
