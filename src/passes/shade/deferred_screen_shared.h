/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_DEFERRED_SCREEN_SHARED_H
#define FNL_PASSES_DEFERRED_SCREEN_SHARED_H

#include "gbuffer_shared.h"

struct gpu_deferred_screen_push {
    ADDRESS(lighting_block) lighting;
    ADDRESS(uint_array) counters;
    STRUCT(gpu_gbuffer) gbuffer;
    uint emission; /* sampled */
};

#endif
