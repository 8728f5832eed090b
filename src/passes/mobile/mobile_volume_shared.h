/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_MOBILE_VOLUME_SHARED_H
#define FNL_PASSES_MOBILE_VOLUME_SHARED_H

#include "passes/mobile/mobile_shared.h"

/* Begins as struct gpu_volume_head does. */
struct gpu_mobile_volume_push {
    ADDRESS(view_block) view;
    ADDRESS(lighting_block) lighting;
    ADDRESS(const_uint_array) ids;
    ADDRESS(uint_array) counters;
    uint images[MOBILE_MOST_TARGETS]; /* separate passes: the targets as sampled images */
};

#endif
