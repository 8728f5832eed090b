/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_GRID_SHARED_H
#define FNL_PASSES_GRID_SHARED_H

#include "shared.h"

/* Sampled, of four samples and half the size; ids_high may be GPU_TEXTURE_NONE. */
struct gpu_grid_push {
    uint ids;
    uint ids_high;
    uint depth;
};

#endif
