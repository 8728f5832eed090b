/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_SHADOW_OBLONG_SHARED_H
#define FNL_PASSES_SHADOW_OBLONG_SHARED_H

#include "lighting/lighting_shared.h"
#include "shadows/maps_shared.h"

#define OBLONG_FOUND 8192u /* pages of a sun that there is room for, as they are hashed */

struct gpu_shadow_planes_push {
    ADDRESS(lighting_block) lighting;
    ADDRESS(const_shadow_sun_array) suns;
    ADDRESS(uint_array) planes; /* a word for each pixel: as struct gpu_shadow_maps has them */
    ADDRESS(uint_array) found;  /* OBLONG_FOUND times two words for each sun: 0 or the name of a page, and how many pixels need it */
    uint depth;                 /* sampled index */
};

struct gpu_shadow_oblong_push {
    ADDRESS(const_uint_array) found;
    ADDRESS(uint_array) keys; /* as struct gpu_shadow_maps has them */
    uint least;               /* pixels that must need a page for it to be in use */
};

#endif
