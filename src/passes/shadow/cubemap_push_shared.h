/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_SHADOW_CUBEMAP_PUSH_SHARED_H
#define FNL_PASSES_SHADOW_CUBEMAP_PUSH_SHARED_H

#include "shadows/cubemap_shared.h"
#include "shadows/rays_shared.h"

/* Texels are RGBA8 in a word each: all six faces of the finest level, row by row, then those of the next. */
struct gpu_cubemap_push {
    ADDRESS(rays_block) rays;
    ADDRESS(probes_block) probes;
    ADDRESS(uint_array) texels;
    ADDRESS(uint_array) blocks; /* output of compression: four words per block */
    uint probe;
    uint from; /* of the level that is filtered or compressed: its first word */
    uint to;   /* of the level that is made, or of its blocks */
    uint side; /* of that */
};

#endif
