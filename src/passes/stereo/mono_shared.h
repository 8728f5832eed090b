/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_MONO_SHARED_H
#define FNL_PASSES_MONO_SHARED_H

#include "shared.h"

/* The mono view begins so much nearer than the plane: what an eye sees just behind the plane stands in it, however steep it is. */
#define MONO_OVERLAP 0.1f

/* Words of what is counted. */
#define MONO_SHADED 0u /* pixels that the view shades */
#define MONO_SPARED 1u /* that others shade: of an eye, those beyond the plane; of the mono view, those that both eyes cover */
#define MONO_COUNTS 2u

struct gpu_mono_push {
    ADDRESS(view_block) eye;
    ADDRESS(view_block) mono;
    ADDRESS(mono_counts) counts; /* read only with COUNTS */
    float distance;              /* of the plane, metres; 0: `eye` is the mono view itself */
    uint depth;                  /* sampled: of the eye; in the composition of the mono view, as `radiance` is */
    uint radiance;
};

struct gpu_mono_block_push {
    ADDRESS(view_block) mono;
    ADDRESS(view_block) eyes; /* one after the other */
    uint eye_count;
    uint depths[6]; /* sampled */
};

#endif
