/* SPDX-License-Identifier: MIT */
/**
 * Only the clusters that hold a visible surface, with bounds round what they hold (Olsson, Billeter, Assarsson 2012): occupied clusters are
 * marked, numbered by a prefix sum, measured, and filled from the tree of bvh.h. With normals a cluster is split further by the 54 ranges
 * of a cube's faces in thirds, and lights behind all surfaces of a range are left out. A surface that finds no cell, for rounding or for
 * what multisampling shades beside its samples, uses all lights.
 */
#ifndef FNL_PASSES_SPARSE_H
#define FNL_PASSES_SPARSE_H

#include "passes/lights/bvh.h"
#include "passes/shade/gbuffer.h"

struct sparse_params {
    struct clustered_params grid;
    graph_image depth;             /* of everything that looks lights up; single- or multisampled */
    const struct gbuffer *gbuffer; /* single-sampled: by its normals lights behind the surfaces are left out; or NULL */
    bool blend;                    /* a dense list for blended surfaces, too */
};

struct sparse_lists {
    struct light_list lights, blend;
};

struct sparse_lists sparse_add(struct graph *graph, gpu_device *device, const struct light_input *input,
                               const struct lights_in_view *in_view, const struct sparse_params *params);

#endif
