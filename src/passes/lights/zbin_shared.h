/* SPDX-License-Identifier: MIT */
/** Building the masks of tiles and depth bins; how they lie in memory says shaders/lights/bins.glsl. */
#ifndef FNL_PASSES_ZBIN_SHARED_H
#define FNL_PASSES_ZBIN_SHARED_H

#include "shared.h"

struct gpu_zbin_push {
    ADDRESS(view_block) view;
    ADDRESS(light_list_block) list;
    ADDRESS(const_uint_array) visible_sums; /* its element light_count is the number of lights in view */
    ADDRESS(bound_array) bounds;            /* of the lights in view */
    ADDRESS(uint_array) table;
    ADDRESS(uint_array) sums;               /* one per cell and one more: words, then their prefix sum */
    ADDRESS(uint_array) pool;
    ADDRESS(uint_array) overflow;           /* [0]: number of cells that did not fit */
    uint light_count;
    uint cell_count;                        /* tiles of each zone, then bins */
    uint capacity;                          /* words in the pool */
};

#define ZBIN_GROUP 1024u /* lights in a group of 32 words */

#endif
