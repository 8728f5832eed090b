/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_DECALS_PASS_SHARED_H
#define FNL_PASSES_DECALS_PASS_SHARED_H

#include "shared.h"
#include "gbuffer_shared.h"

struct gpu_decals_count_push {
    ADDRESS(view_block) view;
    ADDRESS(uint_array) counts;
    uint position; /* sampled */
    uint normal;
};

#define DECAL_TILE 8u /* pixels of a side of the squares that boxes are drawn to */

#ifdef GL_core_profile
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer depths_array { vec2 at[]; };
#endif

struct gpu_decals_box_push {
    ADDRESS(view_block) view;
    ADDRESS(decal_block) set;
    ADDRESS(const_uint_array) ids; /* of the boxes in view */
    ADDRESS(uint_array) counts;    /* by tile: counts, then their prefix sum; while filling the next free place */
    ADDRESS(uint_array) entries;   /* decals of the tiles */
    ADDRESS(depths_array) depths;  /* by tile: least and greatest view depth */
    uvec2 tiles;
    uint depth; /* sampled */
    uint capacity;
};

struct gpu_decals_merge_push {
    STRUCT(gpu_gbuffer) gbuffer; /* a copy */
    ADDRESS(decal_block) set;
    ADDRESS(const_uint_array) sums; /* by tile: where its decals begin */
    ADDRESS(const_uint_array) entries;
    ADDRESS(uint_array) totals; /* struct decals_gbuffer_totals */
    uint receivers;             /* sampled: mask of 8 bits and the face's normal, the vertices' normal */
    uint radiance;              /* sampled: a copy, where decals emit */
    uint capacity;
    uint mip_fix;
    uint tiles_x;
};

#endif
