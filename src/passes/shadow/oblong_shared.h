/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_SHADOW_OBLONG_SHARED_H
#define FNL_PASSES_SHADOW_OBLONG_SHARED_H

#include "lighting/lighting_shared.h"
#include "shadows/maps_shared.h"

#define OBLONG_FOUND 8192u /* slots in the hash table of a sun's pages */

struct gpu_shadow_planes_push {
    ADDRESS(lighting_block) lighting;
    ADDRESS(const_shadow_sun_array) suns;
    ADDRESS(uint_array) planes; /* one word per pixel, as in struct gpu_shadow_maps */
    ADDRESS(uint_array) found;  /* OBLONG_FOUND pairs per sun: name of a page (0: free), pixels that need it */
    uint depth;                 /* sampled index */
};

struct gpu_shadow_oblong_push {
    ADDRESS(const_uint_array) found;
    ADDRESS(uint_array) keys; /* as in struct gpu_shadow_maps */
    uint least;               /* pixels that must need a page for it to be in use */
};

#endif
