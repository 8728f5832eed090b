/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_SCALE_SHARED_H
#define FNL_PASSES_SCALE_SHARED_H

#include "shared.h"

struct gpu_scale_push {
    uint picture; /* sampled */
    uint target;  /* storage */
    uint sampler_index;
    uint width; /* of the target */
    uint height;
};

#endif
