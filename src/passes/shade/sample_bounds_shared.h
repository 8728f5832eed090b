/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_SAMPLE_BOUNDS_SHARED_H
#define FNL_PASSES_SAMPLE_BOUNDS_SHARED_H

#include "view_shared.h"

struct gpu_sample_bounds_push {
    ADDRESS(view_block) view;
    uint depth; /* bindless: multisampled */
};

#endif
