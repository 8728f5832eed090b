/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_TAA_SHARED_H
#define FNL_PASSES_TAA_SHARED_H

#include "shared.h"

#define TAA_SLOW 16.0  /* frames that what was collected counts for, where it moves slowly, */
#define TAA_FAST 6.0   /* and by a pixel a frame or faster */
#define TAA_SPREAD 1.5 /* standard deviations that it may be off the mean */
#define TAA_DEPTH_TOLERANCE 0.05
#define TAA_FARTHEST 6e4 /* what history keeps of depths beyond, metres */

struct gpu_taa_push {
    ADDRESS(view_block) view;
    ADDRESS(float_array) exposure;
    float factor;
    uint metered;       /* 1: exposure is read, 0: factor is used */
    uint radiance;      /* sampled */
    uint depth;         /* sampled */
    uint motion;        /* sampled */
    uint history;       /* sampled: radiance; with keeps */
    uint history_depth; /* sampled: view depth, frames collected, speed of its own; with keeps */
    uint target;        /* storage */
    uint target_depth;  /* storage */
    uint keeps;
    uint still;
};

#endif
