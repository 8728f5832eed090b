/* SPDX-License-Identifier: MIT */
/**
 * Surfaces that show what is behind them (KHR_materials_transmission): drawn over a picture of all that is opaque, in layers from the farthest to the
 * nearest. Each layer sees a copy of the picture with everything behind it, whose mips hold what rough surfaces blur. Depth is peeled from the
 * nearest layer on (Everitt 2001, "Interactive Order-Independent Transparency"), so that any surfaces may overlap, cross or lie in one
 * another; where there are more than `layers` of them in a pixel the farthest are left out.
 */
#ifndef FNL_PASSES_TRANSMISSION_H
#define FNL_PASSES_TRANSMISSION_H

#include "passes/shade/shade.h"

#define TRANSMISSION_LAYERS_MAX 8

/** What the GPU counts. */
struct transmission_totals {
    uint32_t fragments, longest; /* that nothing opaque hides; most of them in one pixel */
};
struct transmission {
    graph_image depths[TRANSMISSION_LAYERS_MAX]; /* of the layers, the nearest first: or of what is opaque where there is none */
    uint32_t layers;
    graph_buffer totals; /* struct transmission_totals */
    VkFormat format;     /* of the copy: floats where `radiance` is and the device filters them, else halves */
    uint64_t byte_count; /* of depths and of the copy */
};
/** Finds the layers, at most `layers` of them; `depth` is that of all that is opaque. Cost: geometry once for each, and once more. */
struct transmission transmission_find(struct graph *graph, gpu_device *device, const struct shade_input *input, uint32_t layers, graph_image radiance,
                                      graph_image depth);
/**
 * Draws GEOMETRY_GLASS over `radiance`, which shows all that is behind. input->lights serves any depth. Cost: geometry and a copy of the picture with its
 * mips for each layer, a shading per fragment.
 */
void transmission_add(struct graph *graph, const struct shade_input *input, const struct transmission *found,
                      graph_image radiance, graph_image depth);

#endif
