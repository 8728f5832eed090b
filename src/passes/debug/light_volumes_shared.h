/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_LIGHT_VOLUMES_SHARED_H
#define FNL_PASSES_LIGHT_VOLUMES_SHARED_H

#include "shared.h"
#include "lighting/lighting_shared.h"

struct gpu_light_volumes_push {
    ADDRESS(view_block) view;
    ADDRESS(lighting_block) lighting;
    uint albedo;   /* sampled: base color, roughness */
    uint normal;   /* sampled: normal, view depth */
    uint position; /* sampled: world position, draw item + 1 */
    uint target;   /* storage */
    uint swap;     /* 1: red and blue change places */
};

#endif
