/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_ZIOMA_SHARED_H
#define FNL_PASSES_ZIOMA_SHARED_H

#include "passes/geometry/geometry_shared.h"
#include "passes/shade/volumes_shared.h"

#define ZIOMA_LAYERS 8u /* at most */

/* A layer's depth target orders lights by index: 1 - (index + 1) / 2^24, 0 for none. */
struct gpu_zioma_push {
    STRUCT(gpu_volume_head) head;
    uint depth;    /* bindless: of the surfaces; of several samples a pixel: their ranges (sample_bounds.h) */
    uint previous; /* bindless: depth target of the layer before; with constant LAYER 0 none */
};

struct gpu_zioma_material_push {
    STRUCT(gpu_geometry_push) geometry;
    ADDRESS(uint_array) totals; /* struct light_totals */
    uint layers;
    uint last;                  /* bindless: depth target of the last layer */
    uint rays[ZIOMA_LAYERS];    /* bindless: unit vector to the light; attenuation */
    uint colors[ZIOMA_LAYERS];
};

/* With several samples a pixel layers name lights, which each surface then asks for itself. */
struct gpu_zioma_samples_push {
    STRUCT(gpu_geometry_push) geometry;
    ADDRESS(uint_array) totals;
    uint layers;
    uint ranges;               /* bindless: sample_bounds.h */
    uint places[ZIOMA_LAYERS]; /* bindless: depth targets of the layers */
};

#endif
