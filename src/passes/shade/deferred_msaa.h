/* SPDX-License-Identifier: MIT */
/**
 * Deferred shading of a multisampled G-buffer: which samples are shaded is the method's choice (ES-20, ES-22). Samples of a pixel that store
 * the same surface (edges.h) are lit at one point, as forward shading does, so that the methods all .. compact give the same bits. Shading
 * writes to a buffer; a draw over the screen spreads it over the samples, which tone mapping averages after it has mapped them.
 *
 *     all        every sample                                                    N times the pixels
 *     tiles      every sample of tiles of 8x8 pixels that have an edge           (Lauritzen 2010)
 *     stencil    every sample of edge pixels, in a pass of their own             pixels + (N - 1) edges (Sousa 2013)
 *     compact    each surface once: those beyond the first are listed and        pixels + surfaces beyond the first
 *                shaded by a dispatch of as many threads                         (after Pettineo 2015)
 *     coverage   the surface with the most samples; the others take the light    pixels
 *                of a neighbour that shows them: coverage is exact, light is not (after Shishkovtsov 2005)
 *     aggregate  at most `groups` surfaces: those alike are merged and shaded    pixels + up to (groups - 1) edges
 *                by the statistics of their samples                              (after Crassin et al. 2015)
 */
#ifndef FNL_PASSES_DEFERRED_MSAA_H
#define FNL_PASSES_DEFERRED_MSAA_H

#include "passes/shade/deferred_msaa_shared.h"
#include "passes/shade/edges.h"

struct deferred_msaa_params {
    uint32_t method; /* MSAA_… */
    uint32_t groups; /* aggregate: surfaces of a pixel at most, 2 or more */
    float tolerance; /* of struct edges_params */
};

/** `radiance`, multisampled like the G-buffer, holds the emission and gets the light. */
struct edges deferred_msaa_add(struct graph *graph, const struct shade_input *input, const struct gbuffer *gbuffer,
                               const struct deferred_msaa_params *params, graph_image radiance);

#endif
