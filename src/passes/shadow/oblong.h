/* SPDX-License-Identifier: MIT */
/**
 * Blocks of a directional light's maps whose texels are not square (shadows/suns.glsl): which of their pages a view needs, and which rows they have.
 *
 * Cost: a look at 9 pixels of depth for each pixel, and for each sun; 4 bytes a pixel.
 */
#ifndef FNL_PASSES_SHADOW_OBLONG_H
#define FNL_PASSES_SHADOW_OBLONG_H

#include "passes/lighting/lighting.h"

/**
 * Of the opaque surfaces in `depth`, as the view of `lighting` sees them. `planes` and `keys` become what struct gpu_shadow_maps has them to be. For pages that few pixels
 * need, and for those of blocks that find no row, square ones stand in.
 */
void shadow_oblong_add(struct graph *graph, const struct lighting *lighting, graph_buffer suns, graph_image depth, graph_buffer planes, graph_buffer keys);

#endif
