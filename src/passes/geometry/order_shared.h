/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_GEOMETRY_ORDER_SHARED_H
#define FNL_PASSES_GEOMETRY_ORDER_SHARED_H

#include "shared.h"

/* Steps. */
#define ORDER_DEPTHS 0u
#define ORDER_GROUPS 1u
#define ORDER_ITEMS 2u
#define ORDER_KEYS 3u
#define ORDER_DRAWS 4u

#define ORDER_MOST_BUCKETS 1024u
#define ORDER_KEPT 0x80000000u /* the bucket's items keep the scene's order */

struct gpu_order_push {
    ADDRESS(view_block) view;
    ADDRESS(scene_block) scene;
    ADDRESS(const_uint_array) buckets; /* first group of each bucket, and ORDER_KEPT */
    ADDRESS(uint_array) pairs_in;      /* a key, then an item or a group */
    ADDRESS(uint_array) pairs_out;
    ADDRESS(const_uint_array) sums;    /* prefix sums of the cull step */
    ADDRESS(uint_array) visible;
    ADDRESS(draw_array) draws;
    ADDRESS(draw_array) ordered;
    uint item_count;
    uint group_count;
    uint bucket_count;
};

#endif
