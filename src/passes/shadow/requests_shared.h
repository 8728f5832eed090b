/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_SHADOW_REQUESTS_SHARED_H
#define FNL_PASSES_SHADOW_REQUESTS_SHARED_H

#include "shared.h"

struct gpu_shadow_requests_push {
    ADDRESS(lighting_block) lighting;
    ADDRESS(uint_array) wanted; /* SHADOW_ROW_WORDS words for each local light */
    uint depth;                 /* sampled index */
};

#endif
