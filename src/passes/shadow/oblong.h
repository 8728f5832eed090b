/* SPDX-License-Identifier: MIT */
/**
 * Oblong blocks of a directional light's maps, whose texels are not square (shadows/suns.glsl): the pages that a view
 * needs and the rows of the blocks.
 *
 * Cost: per pixel, 9 depths and one evaluation of each sun; 4 bytes per pixel.
 */
#ifndef FNL_PASSES_SHADOW_OBLONG_H
#define FNL_PASSES_SHADOW_OBLONG_H

#include "passes/lighting/lighting.h"

/**
 * Selects oblong pages for the opaque surfaces in `depth`, from the view of `lighting`. Writes `planes` and `keys`
 * (struct gpu_shadow_maps). Square pages replace an oblong page that few pixels need, or whose block gets no row.
 */
void shadow_oblong_add(struct graph *graph, const struct lighting *lighting, graph_buffer suns, graph_image depth, graph_buffer planes, graph_buffer keys);

#endif
