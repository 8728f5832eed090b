/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_SHADOW_VIEW_SHARED_H
#define FNL_PASSES_SHADOW_VIEW_SHARED_H

#include "shared.h"
#include "lighting/lighting_shared.h"

/* Values of fnl_debug_view. */
#define GPU_DEBUG_SHADOW_PAGES 31u
#define GPU_DEBUG_SHADOW_LEVELS 32u
#define GPU_DEBUG_SHADOW_TEXELS 33u
#define GPU_DEBUG_SHADOW_ERRORS 34u
#define GPU_DEBUG_PROBE_LOOKUP 37u
#define GPU_DEBUG_PROBE_LEVELS 38u
#define GPU_DEBUG_SHADOW_RAYS 40u
#define GPU_DEBUG_SHADOW_AGE 41u
#define GPU_DEBUG_SHADOW_CLASSES 42u

struct gpu_shadow_view_push {
    ADDRESS(view_block) view;
    ADDRESS(lighting_block) lighting;
    ADDRESS(const_uint_array) classes; /* of GPU_DEBUG_SHADOW_CLASSES: gpu_shadow_dark_push has it */
    uint albedo; /* as gpu_debug_push has them, and all below */
    uint normal;
    uint position;
    uint target;
    uint swap;
    uint mode;
};

#endif
