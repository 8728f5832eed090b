/* SPDX-License-Identifier: MIT */
/**
 * Deferred shading the traditional way: a solid drawn for each light, its contribution added up by blending
 * (Ishmukhametov, "Efficient Tile-Based Deferred Shading Pipeline", 2013, chapter 3; efficient-shading chapter of RTR 4, 20.1). The
 * G-buffer is read once for each light and pixel, and nothing is sorted into lists.
 */
#ifndef FNL_PASSES_VOLUMES_H
#define FNL_PASSES_VOLUMES_H

#include "passes/shade/gbuffer.h"

/** Indices of both solids, front faces counter-clockwise from outside. */
#define VOLUME_INDEX_COUNT 300u
void volumes_indices(uint32_t out[VOLUME_INDEX_COUNT]);

/** The format that volumes add up in: floats of 32 bits where the device blends them, else of 16. Thousands of small
    contributions would get lost in 16 bits. */
VkFormat volumes_format(const gpu_device *device);

struct volumes_input {
    const struct light_input *lights;
    bool cull;  /* only volumes in view; default true */
    bool quads; /* rectangles on the screen instead of solids; default false */
};
/**
 * Adds all local lights to `radiance`, which holds everything else already. Instances ascend by light, spheres before
 * cones, so that sums repeat to the bit. Returns a buffer with struct light_totals: volumes drawn, 0, 0. Cost: per
 * light 49 vertices (cones 16, rectangles 4), per pixel that a solid covers in front of its far side, or a rectangle not behind the
 * surface, a read of the G-buffer and a blend.
 */
graph_buffer volumes_add(struct graph *graph, gpu_device *device, const struct shade_input *input,
                         const struct volumes_input *volumes, const struct gbuffer *gbuffer, graph_image radiance);

#endif
