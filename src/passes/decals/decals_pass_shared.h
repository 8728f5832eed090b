/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_DECALS_PASS_SHARED_H
#define FNL_PASSES_DECALS_PASS_SHARED_H

#include "shared.h"

struct gpu_decals_count_push {
    ADDRESS(view_block) view;
    ADDRESS(uint_array) counts;
    uint position; /* sampled */
    uint normal;
};

#endif
