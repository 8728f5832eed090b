/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_SPLIT_SHARED_H
#define FNL_PASSES_SPLIT_SHARED_H

#include "shared.h"

#define SPLIT_KNOWN 1u        /* it was decided once */
#define SPLIT_TRACED 2u       /* rays find the shadows */
#define SPLIT_PATIENCE_SHIFT 4u
#define SPLIT_MOST_PATIENCE 6u
#define SPLIT_AGE_SHIFT 8u    /* frames since the light has switched, up to SPLIT_OLD */
#define SPLIT_OLD 128u

/* By row. */
struct gpu_shadow_split_row {
    float regret; /* rays: how much cheaper the other way would have been since it last was not */
    uint flags;   /* SPLIT_… */
    uint drawn;   /* pages, in the last frame */
};

struct gpu_shadow_split_counts {
    uint maps;     /* local lights that some pixel may look up in maps */
    uint rays;     /* those that pixels send rays to instead */
    uint reached;  /* pixels that these may reach, one by one */
    uint switched; /* lights that went from one to the other in this frame */
    uint probed;   /* rays of the probe */
    uint open;     /* of them, those that nothing stops */
};

struct gpu_shadow_split_push {
    ADDRESS(uint_array) wanted;   /* as requests leave it; rows whose shadows rays find lose their bits */
    ADDRESS(const_uint_array) rows; /* SHADOW_ROW_… */
    ADDRESS(split_row_array) kept;
    ADDRESS(uint_array) traced;   /* 1: rays */
    ADDRESS(split_counts_block) counts;
    uint row_count;
    uint known_rows; /* that `kept` knows */
    uint sun_rows;
    float page_rays;
};

/* For each page that was drawn. */
struct gpu_shadow_drawn_push {
    ADDRESS(const_uint_array) drawn;
    ADDRESS(shadow_page_array) pages;
    ADDRESS(split_row_array) kept;
};

struct gpu_shadow_probe_push {
    ADDRESS(lighting_block) lighting;
    ADDRESS(split_counts_block) counts;
    uint depth;  /* sampled index */
    uint seed;
};

#endif
