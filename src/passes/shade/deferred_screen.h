/* SPDX-License-Identifier: MIT */
/**
 * Deferred lighting as a full-screen draw that a stencil holds off sky and off what a forward pass lights (Mikkelsen, "Fine Pruned Tiled
 * Light Lists", GPU Pro 7, 2016), where deferred.h dispatches threads that look at depth and mask themselves. The same bits come out. Cost
 * beside that of lighting: a pass that lays the stencil down, one byte a pixel, and a second radiance image.
 */
#ifndef FNL_PASSES_DEFERRED_SCREEN_H
#define FNL_PASSES_DEFERRED_SCREEN_H

#include "passes/shade/gbuffer.h"

/** Whether the device has a stencil without depth. */
bool deferred_screen_supported(const gpu_device *device);
/** Takes the emission from `radiance`, which the G-buffer pass filled, and returns the lit image. */
graph_image deferred_screen_add(struct graph *graph, const struct shade_input *input, const struct gbuffer *gbuffer,
                                graph_image radiance);

#endif
