/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_REFLECTIONS_VIEW_SHARED_H
#define FNL_PASSES_REFLECTIONS_VIEW_SHARED_H

#include "shared.h"

struct gpu_reflections_view_push {
    ADDRESS(view_block) view;
    uint albedo; /* as gpu_debug_push has them, and all below */
    uint normal;
    uint position;
    uint target;
    uint swap;
};

#endif
