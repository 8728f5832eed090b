/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_SHADOW_DARK_SHARED_H
#define FNL_PASSES_SHADOW_DARK_SHARED_H

#include "shadows/maps_shared.h"

/* The least depth in each square of SHADOW_DARK_BLOCK texels of the atlas, row by row, as bits of a float; then in each square of four times the side, which
   holds one only in pages that are no smaller. */
#define SHADOW_DARK_BLOCK 8u
#define SHADOW_DARK_WIDE 32u

struct gpu_shadow_least_push {
    ADDRESS(const_uint_array) drawn;  /* numbers of pages, one for each work group */
    ADDRESS(shadow_page_array) pages;
    ADDRESS(uint_array) least;
    uint atlas;                       /* sampled index */
    uint side;                        /* of the atlas, texels */
};

struct gpu_shadow_dark_push {
    ADDRESS(lighting_block) lighting;
    ADDRESS(const_uint_array) least;
    ADDRESS(shadow_counts_block) counts;
    ADDRESS(uint_array) classes; /* by tile: lights in its list, of them those that leave; null: nobody asks */
    uint depth; /* sampled index */
    uint side;  /* of the atlas, texels */
};

#endif
