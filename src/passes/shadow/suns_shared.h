/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_SHADOW_SUNS_SHARED_H
#define FNL_PASSES_SHADOW_SUNS_SHARED_H

#include "lighting/lighting_shared.h"
#include "shadows/maps_shared.h"
#include "shadows/rays_shared.h"

struct gpu_shadow_suns_push {
    ADDRESS(lighting_block) lighting;
    ADDRESS(rays_block) rays;
    ADDRESS(shadow_sun_array) suns; /* a struct gpu_shadow_sun for each directional light */
};

#endif
