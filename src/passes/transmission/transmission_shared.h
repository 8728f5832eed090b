/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_TRANSMISSION_SHARED_H
#define FNL_PASSES_TRANSMISSION_SHARED_H

#include "passes/geometry/geometry_shared.h"

struct gpu_transmission_push {
    STRUCT(gpu_geometry_push) geometry;
    uint behind; /* sampled, with all mips */
    float last_mip;
};

/* Of the depth of layers behind the first: fragments of nearer layers are left out. */
struct gpu_transmission_depth_push {
    STRUCT(gpu_geometry_push) geometry;
    uint nearer; /* sampled: depth of the layer before */
};

struct gpu_transmission_count_push {
    STRUCT(gpu_geometry_push) geometry; /* counters: one for each pixel */
    ADDRESS(uint_array) totals;         /* struct transmission_totals */
};

#endif
