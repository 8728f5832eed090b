/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_SURFACE_LAYERS_SHARED_H
#define FNL_PASSES_SURFACE_LAYERS_SHARED_H

#include "passes/shade/edges_shared.h"

#define SURFACE_LAYERS 8u /* at most: as many surfaces as a pixel has samples */

/* A draw over the screen: of one layer's depth, or of what all layers hold, to the samples that show it. */
struct gpu_surface_layers_push {
    ADDRESS(view_block) view;
    ADDRESS(uint_array) surfaces; /* edges_shared.h */
    uint depth;                   /* bindless: multisampled */
    uint layer;
    uint layers[SURFACE_LAYERS];  /* bindless, to be spread */
};

#endif
