/* SPDX-License-Identifier: MIT */
/**
 * What the samples of a multisampled G-buffer show: which of a pixel's belong to the same surface (ES-20). Two do if their stored bits are
 * equal (or alike, with a tolerance) and each lies near the plane of the other, so that a pole before a wall of its own colour is found as
 * well. Cost: the G-buffer is read once; pixels with several surfaces read it again for each pair.
 */
#ifndef FNL_PASSES_EDGES_H
#define FNL_PASSES_EDGES_H

#include "passes/shade/edges_shared.h"
#include "passes/shade/gbuffer.h"

struct edges_params {
    float
        tolerance; /* 0: stored bits are compared; else the greatest difference of colours, parameters and (as a chord) normals */
    uint32_t limit; /* surfaces of a pixel at most, 2 .. 8; those most alike are merged */
    bool lists;     /* the surfaces beyond the first of each pixel are listed */
};

struct edges {
    graph_buffer surfaces; /* a word a pixel, row by row */
    graph_buffer counts;   /* uint[EDGES_COUNTS] */
    graph_buffer sums, entries,
        dispatch; /* with lists: prefix sums over pixels, pixel | surface << 28, an indirect dispatch */
};

/** `radiance` holds the emission and is left as it is. */
struct edges edges_add(struct graph *graph, const struct shade_input *input, const struct gbuffer *gbuffer,
                       graph_image radiance, const struct edges_params *params);

#endif
