/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_LIGHT_INDEXED_SAMPLES_SHARED_H
#define FNL_PASSES_LIGHT_INDEXED_SAMPLES_SHARED_H

#include "passes/geometry/geometry_shared.h"

struct gpu_indexed_samples_push {
    STRUCT(gpu_geometry_push) geometry;
    ADDRESS(lighting_block) all; /* a list of the same kind whose one cell has all lights */
    uint ranges;                   /* bindless: sample_bounds.h */
};

#endif
