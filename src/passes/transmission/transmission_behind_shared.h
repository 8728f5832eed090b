/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_TRANSMISSION_BEHIND_SHARED_H
#define FNL_PASSES_TRANSMISSION_BEHIND_SHARED_H

#include "shared.h"

#define TRANSMISSION_MIPS 15u /* of pictures up to 16384 */

/* A texel of what is behind, four halves or floats: radiance, and 1 / view depth, 0 for the sky. Mips are tightly packed one after the other. */
struct gpu_transmission_behind_push {
    ADDRESS(view_block) view;
    ADDRESS(texel_array) texels;
    uint radiance; /* sampled */
    uint depth;    /* sampled: of what is shown so far */
    uint samples;
};

struct gpu_transmission_level_push {
    ADDRESS(texel_array) texels;
    uint from, to; /* first texel of the finer mip, and of this one */
    uvec2 from_size, to_size;
};

#endif
