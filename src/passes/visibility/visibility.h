/* SPDX-License-Identifier: MIT */
/**
 * Visibility buffer: the geometry pass stores which triangle a pixel shows and nothing else; a compute pass fetches its vertices, redoes
 * the vertex work, interpolates with exact gradients and shades (Burns and Hunt, "The Visibility Buffer", JCGT 2013; RTR 4, 20.5).
 */
#ifndef FNL_PASSES_VISIBILITY_H
#define FNL_PASSES_VISIBILITY_H

#include "passes/shade/shade.h"

/** Ids of what is seen: 32 bits where items and triangles fit, else 48 or 64 in two images. */
struct visibility {
    graph_image depth, ids, ids_high; /* ids_high.id 0: 32 bits */
    uint32_t triangle_bits;
};

/** Bits of an id for a scene of so many items, the largest of so many triangles: 32, 48 or 64; `out_triangle_bits` of them tell triangles. */
uint32_t visibility_bits(uint32_t item_count, uint32_t triangle_count, uint32_t *out_triangle_bits);

/**
 * Draws the opaque set into ids and depth; cutouts are tested here. Single-sampled. The device needs fnl_device_info.primitive_ids. `bits` 48 or
 * 64 makes ids wider than they need to be; 0: as wide as they need to be. Cost: of attributes only the position is read, but for cutouts; 4 to 8
 * bytes a pixel.
 */
struct visibility visibility_add(struct graph *graph, const struct shade_input *input, uint32_t bits, graph_image depth);

/** Shades each pixel once into `radiance`; those that show nothing get the background. Cost: three vertices fetched for each pixel. */
void visibility_shade_add(struct graph *graph, const struct shade_input *input, const struct visibility *visibility,
                          graph_image radiance);

#endif
