/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_CULL_SHARED_H
#define FNL_PASSES_CULL_SHARED_H

#include "shared.h"

struct gpu_cull_push {
    ADDRESS(view_block) view;
    ADDRESS(scene_block) scene;
    ADDRESS(uint_array) sums;           /* one per item and one more: 1 for visible ones, then their prefix sum */
    ADDRESS(uint_array) visible;        /* ids of visible items, in order */
    ADDRESS(draw_array) draws;          /* one per group */
    ADDRESS(hierarchy_array) hierarchy; /* of hierarchy_width x hierarchy_height; 0: nothing hides anything */
    ADDRESS(uint_array) hidden;         /* one per item: 1 where it is hidden; then how many are */
    uint item_count;
    uint group_count;
    uint hierarchy_width;
    uint hierarchy_height;
    uint occludee_count; /* items before this one may be hidden */
    uint repeat;         /* how often each instance is drawn */
    float least_pixels;  /* items narrower and lower than this on the screen are culled; 0: off */
};

/* Marks for several views, which stand one after the other. */
struct gpu_cull_views_push {
    ADDRESS(view_block) view;
    ADDRESS(scene_block) scene;
    ADDRESS(uint_array) sums; /* one per item and one more: 1 for those that some view sees */
    uint item_count;
    uint view_count;
};

/* Marks for several views, each of which has been culled by itself. */
struct gpu_cull_union_push {
    ADDRESS(const_uint_array) views[6]; /* one per item and one more: prefix sums of the marks of each view */
    ADDRESS(uint_array) sums;           /* the same for all: 1 for those that some view draws */
    uint item_count;
    uint view_count;
};

/* Back-to-front order of blended items. */
struct gpu_sort_push {
    ADDRESS(view_block) view;
    ADDRESS(scene_block) scene;
    ADDRESS(uint_array) keys_in; /* pairs: key, item */
    ADDRESS(uint_array) keys_out;
    ADDRESS(const_uint_array) sums; /* of the cull step: which items are visible */
    ADDRESS(draw_array) draws;
    ADDRESS(uint_array) visible;
    uint first_item; /* of the blended items */
    uint item_count;
};

#endif
