/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_SKY_SHARED_H
#define FNL_PASSES_SKY_SHARED_H

#include "background_shared.h"
#include "shared.h"

struct gpu_sky_push {
    ADDRESS(view_block) view;
    uint gradient; /* 1: a gradient, 2: the same without an environment, of which the mean is 1 */
    float lod;     /* of the environment's cube map */
};

#endif
