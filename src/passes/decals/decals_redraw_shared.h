/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_DECALS_REDRAW_SHARED_H
#define FNL_PASSES_DECALS_REDRAW_SHARED_H

#include "shared.h"

/* One draw: a decal on a primitive of an instance. */
struct gpu_redraw {
    uint instance;
    uint primitive;
    uint decal;
    uint light_mask; /* of the instance, 8 bits */
};

#ifdef GL_core_profile
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer redraw_array { gpu_redraw at[]; };
#endif

struct gpu_redraw_push {
    ADDRESS(view_block) view;
    ADDRESS(scene_block) scene;
    ADDRESS(lighting_block) lighting;
    ADDRESS(uint_array) counters; /* 0: these fragments are not counted */
    ADDRESS(redraw_array) table;
    ADDRESS(decal_block) set;
};

#endif
