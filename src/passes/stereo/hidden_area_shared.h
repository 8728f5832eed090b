/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_HIDDEN_AREA_SHARED_H
#define FNL_PASSES_HIDDEN_AREA_SHARED_H

#include "shared.h"

struct gpu_hidden_area_push {
    ADDRESS(hidden_area_corners) corners; /* vec2, normalised device coordinates */
    float depth;
};

#endif
