/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_INFERRED_SHARED_H
#define FNL_PASSES_INFERRED_SHARED_H

#include "passes/shade/light_prepass_shared.h"

/* Blended items take the texels of one of three places in squares of 2 x 2; the fourth is never theirs. */
#define INFERRED_PLACE(item) (1u + (item) % 3u)

struct gpu_inferred_material_push {
    STRUCT(gpu_geometry_push) geometry; /* lights: all of them */
    ADDRESS(view_block) low;            /* the view at the resolution of light */
    STRUCT(gpu_light_surfaces) surfaces; /* at that resolution, as the next */
    uint items;                          /* bindless: item + 1 of each texel */
    uint targets[LIGHT_BUFFER_TARGETS];
};

#endif
