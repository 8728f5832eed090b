/* SPDX-License-Identifier: MIT */
/** From radiance to a picture: metering, exposure, tone mapping, encoding. */
#ifndef FNL_PASSES_POST_H
#define FNL_PASSES_POST_H

#include "graph/graph.h"

/**
 * Meters `count` pictures together, by radiance and depth (0: background), and returns a buffer of two floats: the exposure factor and its EV100.
 * exposure_shared.h says how.
 */
graph_buffer exposure_add(struct graph *graph, const graph_image *radiance, const graph_image *depth, uint32_t count);

struct tonemap_params {
    uint32_t tonemap;      /* GPU_TONEMAP_… */
    graph_buffer exposure; /* of exposure_add; id 0: `factor` is used */
    float factor;          /* radiance is multiplied by it */
    bool linear;           /* no tone mapping nor encoding: for floating-point targets */
    bool swap;             /* red and blue change places: for BGRA targets */
};
/** Writes the picture of `radiance` (single- or multisampled) to `target`, a storage image of the same size. */
void tonemap_add(struct graph *graph, graph_image radiance, graph_image target, const struct tonemap_params *params);

/** What a target of linear light, or of high dynamic range, takes: the picture in the other encoding. */
enum display_format { DISPLAY_LINEAR, DISPLAY_ABGR10, DISPLAY_ARGB10 }; /* GPU_DISPLAY_ */
/**
 * `picture` is in linear light, or with `decode` encoded as sRGB. For the 10-bit formats the result is HDR10 (ITU-R BT.2100: BT.2020 primaries,
 * ST 2084), in an image of RGBA8 whose bytes are those of the packed format.
 */
graph_image display_add(struct graph *graph, graph_image picture, enum display_format format, bool decode);

/**
 * The depth of each pixel's first sample as an image of one sample; with `forward` 1 minus it. `depth` itself where that is the same.
 */
graph_image depth_picture_add(struct graph *graph, graph_image depth, bool forward);

/** Averages the samples of `radiance` into `target` (RGBA32F), in linear light. */
void resolve_add(struct graph *graph, graph_image radiance, graph_image target);

#endif
