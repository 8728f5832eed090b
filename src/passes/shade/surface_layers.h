/* SPDX-License-Identifier: MIT */
/**
 * A multisampled picture as several pictures of one sample: layer k has the k-th surface of each pixel that has so many (edges.h). What
 * knows pixels alone, volumes of lights above all, then lights each surface of a pixel once, at the point where deferred_msaa.h does. The
 * first layer is the picture; the others hold the edges.
 */
#ifndef FNL_PASSES_SURFACE_LAYERS_H
#define FNL_PASSES_SURFACE_LAYERS_H

#include "passes/shade/edges.h"
#include "passes/shade/surface_layers_shared.h"

struct surface_layers {
    graph_buffer surfaces; /* struct edges; id 0: one sample a pixel, and so no layers but the picture */
    uint32_t count;        /* layers: samples of a pixel; 1 without */
    graph_image depths[SURFACE_LAYERS]; /* single-sampled; id 0 until surface_layers_add_depths */
};

/** Draws a depth image for each layer, 0 where a pixel has no such surface, so that depth tests leave the edges alone. `depth`: the samples'. */
void surface_layers_add_depths(struct graph *graph, const struct shade_input *input, graph_image depth,
                               struct surface_layers *layers);
/** Adds what single-sampled images hold, one for each layer, to the samples of `radiance`. */
void surface_layers_spread(struct graph *graph, const struct shade_input *input, const struct surface_layers *layers,
                           const graph_image images[SURFACE_LAYERS], graph_image radiance);

#endif
