/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_SKY_SHARED_H
#define FNL_PASSES_SKY_SHARED_H

#include "shared.h"

struct gpu_sky_push {
    ADDRESS(view_block) view;
};

#endif
