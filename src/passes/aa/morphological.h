/* SPDX-License-Identifier: MIT */
/**
 * Antialiasing of a finished picture from the shapes of its edges.
 *
 * Both methods find edges between neighbouring pixels, follow each line of edges to its ends, take the stair that it makes with the
 * edges that cross it there for the trace of a straight line, and blend each pixel with the one across the edge by the area that this
 * line cuts off. Colours are blended in linear light; a pixel that no line cuts keeps its bits.
 *
 * mlaa_add: A. Reshetov, Morphological Antialiasing, HPG 2009. An edge is where a channel differs by more than 0.1. Lines are of any
 * length. A line begins at height 0.5 where an edge crosses it on one side and falls to 0 at half its length; an end that nothing
 * crosses, or that is crossed on both sides, gives nothing. Shapes are thus L (one end), Z (two, on different sides), U (on one side).
 *
 * smaa_add: after J. Jimenez et al., SMAA: Enhanced Subpixel Morphological Antialiasing, Eurographics 2012, with areas computed where
 * the original looks them up. Edges are of luma, those beside one twice as strong are dropped; crossing edges end a line; corners of
 * shapes stay sharp; stairs at about 45 degrees are followed along the diagonal. At most 64 pixels (32 diagonal ones) are searched each
 * way.
 *
 * Cost: a pass over the picture that packs edges into 4 bits a pixel, and one that costs more only at edges.
 */
#ifndef FNL_PASSES_MORPHOLOGICAL_H
#define FNL_PASSES_MORPHOLOGICAL_H

#include "graph/graph.h"

struct morphological_params {
    bool linear; /* the picture is linear and may exceed 1; edges are then sought in a tone-mapped copy. Else sRGB-encoded */
    bool swap;   /* red and blue have changed places */
};

/** Return a new image of the format and size of `picture`, which is single-sampled. */
graph_image mlaa_add(struct graph *graph, graph_image picture, const struct morphological_params *params);
graph_image smaa_add(struct graph *graph, graph_image picture, const struct morphological_params *params);

#endif
