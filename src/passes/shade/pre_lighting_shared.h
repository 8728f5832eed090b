/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_PRE_LIGHTING_SHARED_H
#define FNL_PASSES_PRE_LIGHTING_SHARED_H

#include "passes/shade/light_prepass_shared.h"
#include "passes/shade/volumes_shared.h"

struct gpu_pre_lighting_push {
    STRUCT(gpu_volume_head) head;
    ADDRESS(uint_array) words;           /* with several samples a pixel, as the last: edges_shared.h */
    STRUCT(gpu_light_surfaces) surfaces;
    uint layer;                          /* which surface of each pixel is lit */
};

#endif
