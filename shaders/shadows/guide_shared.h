/* SPDX-License-Identifier: MIT */
/**
 * What tiles of 8x8 pixels have seen of lights, by which the next frame chooses lights (passes/shadow/guide.h). A tile has GUIDE_SLOTS slots; a light
 * has the one that its index says, alone or with others. Two images hold them: `seen` a block of GUIDE_SIDE squared texels for each tile, a slot each, and
 * `weights` one of half the side, four slots each.
 */
#ifndef FNL_SHADERS_GUIDE_SHARED_H
#define FNL_SHADERS_GUIDE_SHARED_H

#include "shared.h"

#define GUIDE_TILE 8u /* pixels */
#define GUIDE_SIDE 8u
#define GUIDE_SLOTS (GUIDE_SIDE * GUIDE_SIDE)
/* A texel of `seen`: 16 bits of rays sent and, below them, 16 bits of what came through, both in units of 1 / GUIDE_UNIT ray. A tile sends at most 64 times
   16 rays a frame, and GUIDE_KEPT sums up eight frames at most: 15 bits. */
#define GUIDE_UNIT 4u
#define GUIDE_SENT(seen) ((seen) >> 16)
#define GUIDE_PASSED(seen) ((seen) & 0xffffu)
#define GUIDE_KEPT 0.875   /* of what is known, from frame to frame */
#define GUIDE_LEAST 0.125  /* weight of a light that was never seen, as a part of that of one that always was */
#define GUIDE_PRIOR 2.0    /* rays that the tiles around count for */
#define GUIDE_SURE 0.25    /* denoised: least part of the variance of unguided rays that guided ones are thought to have */

struct gpu_guide_push {
    ADDRESS(view_block) view;
    uint motion;  /* sampled; with moves */
    uint was;     /* sampled: `seen` of the last frame; with keeps */
    uint seen;    /* storage */
    uint weights; /* storage */
    uint keeps;   /* 1: there is a last frame */
    uint moves;   /* 1: something has moved since then */
    uint adverse; /* 1: weights that have nothing to do with what was seen, for tests */
};

#endif
