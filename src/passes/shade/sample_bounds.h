/* SPDX-License-Identifier: MIT */
/**
 * Where the surfaces of a pixel lie that has several samples, for what finds the lights of a pixel by depth alone: two ranges of view
 * depths that hold all samples and reach some way beyond, since shading may choose a point of a covered triangle between its samples or
 * beside them. A point within the ranges has all its lights found; one that is not (sample_bounds.glsl) must not rely on that.
 */
#ifndef FNL_PASSES_SAMPLE_BOUNDS_H
#define FNL_PASSES_SAMPLE_BOUNDS_H

#include "passes/shade/sample_bounds_shared.h"
#include "passes/shade/shade.h"

struct sample_bounds {
    graph_image ranges;   /* RGBA32F: near and far of the nearer, then of the farther range; nothing but sky: none has anything */
    graph_image nearest; /* one stored depth, of the near end of the ranges: solids are kept whose far sides are behind it */
};
/** Reads `depth`, which is multisampled and complete. Cost: the depth once, 20 bytes a pixel. */
struct sample_bounds sample_bounds_add(struct graph *graph, const struct shade_input *input, graph_image depth);

#endif
