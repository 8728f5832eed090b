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

struct gpu_decals_box_push {
    ADDRESS(view_block) view;
    ADDRESS(decal_block) set;
    ADDRESS(const_uint_array) ids; /* of the boxes in view */
    ADDRESS(uint_array) counts;    /* by pixel: counts, or while filling the next free place */
    ADDRESS(uint_array) fragments; /* decals of the pixels */
    uint depth;                    /* sampled */
    uint receivers;                /* sampled: mask of 8 bits and the face's normal, the vertices' normal */
    uint capacity;
};

struct gpu_decals_merge_push {
    STRUCT(gpu_gbuffer) gbuffer; /* a copy */
    ADDRESS(decal_block) set;
    ADDRESS(const_uint_array) sums; /* by pixel: where its decals begin */
    ADDRESS(uint_array) fragments;
    ADDRESS(uint_array) totals; /* struct decals_gbuffer_totals */
    uint receivers;
    uint radiance; /* sampled: a copy, where decals emit */
    uint capacity;
    uint mip_fix;
};

#endif
