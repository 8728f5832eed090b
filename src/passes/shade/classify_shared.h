/* SPDX-License-Identifier: MIT */
/** Classes of blocks of pixels that need the same parts of the deferred shader (ES-48, ES-49). */
#ifndef FNL_PASSES_CLASSIFY_SHARED_H
#define FNL_PASSES_CLASSIFY_SHARED_H

#include "gbuffer_shared.h"

/* Bits of a class. The first two are set where any pixel of the block needs the code, the last where every pixel does. */
#define SHADE_LIGHTS 1u    /* some list holds a light */
#define SHADE_METAL 2u     /* some surface is a metal in part */
#define SHADE_FULL 4u      /* every pixel is to be shaded: nothing needs to ask */
#define SHADE_CLASSES 8u
#define SHADE_NOTHING 8u   /* sky, unlit surfaces: the radiance is there already */

struct gpu_classify_push {
    ADDRESS(view_block) view;
    ADDRESS(lighting_block) lighting;
    ADDRESS(uint_array) classes;    /* one per block */
    ADDRESS(uint_array) sums;       /* class * block_count + block, and one more: 1 where the block is of the class, then prefix sums */
    ADDRESS(uint_array) blocks;     /* their indices, class after class */
    ADDRESS(uint_array) dispatches; /* three per class */
    ADDRESS(uint_array) counts;     /* blocks of each class, and those of none */
    STRUCT(gpu_gbuffer) gbuffer;
    uint block_size;                /* pixels: 8 or 4 */
    uint blocks_x;
    uint block_count;
};

#endif
