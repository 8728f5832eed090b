/* SPDX-License-Identifier: MIT */
/**
 * Takes lights out of light lists where shadow maps show that they give nothing. The least depth of each square of 8x8 and 32x32 texels of the atlas is kept;
 * a light leaves the list of a tile if all squares that the surfaces in the tile may look up are nearer to the light than those surfaces.
 * Shading then gives the same light to the bit, and has less to look up.
 *
 * Blocks of pixels that are all in shadow are known from *Split/Second*: B. Knight et al., "Screen Space Classification for Efficient Deferred Shading",
 * 2010. There a mask of the sun's shadow is looked at; here the maps, before anything is shaded.
 *
 * Cost: a look at each light of each tile, and one at each texel of the pages that were drawn in this frame.
 */
#ifndef FNL_PASSES_SHADOW_DARK_H
#define FNL_PASSES_SHADOW_DARK_H

#include "passes/lighting/lighting.h"
#include "passes/shadow/fill.h"
#include "passes/shadow/pages.h"

/** Brings the least depths of squares of texels up to date with the pages that were drawn: in each frame, after shadow_fill_add(). */
void shadow_least_add(struct graph *graph, const struct shadow_pages *pages, const struct shadow_fill *fill);

/**
 * Shortens `list`: of GPU_LIST_TILES with tiles of 8 pixels, without GPU_LIST_SCATTERED and GPU_LIGHTING_FILTERED, and with the maps of this frame. `depth` is
 * what its tiles were made for, with one sample a pixel; shading must look up nothing else with it. After shadow_least_add(). `classes` (id 0: none): gets for
 * each tile how many lights were in its list, and how many of them left.
 */
void shadow_dark_add(struct graph *graph, const struct shadow_pages *pages, const struct lighting *lighting, graph_image depth, graph_buffer classes);

#endif
