/* SPDX-License-Identifier: MIT */
/** Drawing pages of shadow maps: what the steps of fill.h pass on. */
#ifndef FNL_PASSES_FILL_SHARED_H
#define FNL_PASSES_FILL_SHARED_H

#include "passes/geometry/geometry_shared.h"
#include "scene_shared.h"
#include "shadows/maps_shared.h"

/* What a page shows, in the order of pages: a unit (struct gpu_group) of an item. */
struct gpu_fill_entry {
    uint item;
    uint unit;
    uint rank; /* entries of the unit that were counted before this one */
};

/* The same in the order of units: what an instance of a draw is. */
struct gpu_fill_pair {
    uint item;
    uint page;
};

struct gpu_fill_totals {
    STRUCT(gpu_draw) clear;     /* a square for each page that is drawn */
    uint draw_counts[2];        /* opaque, cutout */
    uint triangles;             /* of all draws */
    uint groups[3];             /* for a dispatch: as many as pages are drawn, 1, 1 */
};

/* An item as pages show it: where it is, and the box round it in the space of its mesh. low.x > high.x: it casts no shadow. */
struct gpu_fill_caster {
    vec4 rows[3];
    vec3 low;
    vec3 high;
    uint primitive;
};

/* Which pages no longer show what is there. */
struct gpu_fill_mark_push {
    ADDRESS(rays_block) rays;
    ADDRESS(const_shadow_shape_array) shapes;
    ADDRESS(shadow_page_array) pages;
    ADDRESS(shadow_counts_block) counts;
    ADDRESS(fill_kept_block) kept;
    ADDRESS(uint_array) changed;         /* how many; then numbers of items, as they are or were, in any order */
    uint page_limit;
    uint item_count;
    uint caster_count;
    uint all_changed;                    /* 1: nothing is known of what was there */
};

struct gpu_fill_push {
    ADDRESS(rays_block) rays;
    ADDRESS(const_shadow_shape_array) shapes; /* by row */
    ADDRESS(shadow_page_array) pages;
    ADDRESS(shadow_counts_block) counts;
    ADDRESS(uint_array) sums;            /* entries of each page, and one more; then their prefix sums */
    ADDRESS(uint_array) unit_sums;       /* the same of units; of the pages that are drawn */
    ADDRESS(fill_entry_array) entries;
    ADDRESS(fill_pair_array) pairs;
    ADDRESS(uint_array) drawn;           /* the pages that are drawn, in any order */
    ADDRESS(draw_array) draws;           /* of opaque units, then from unit_count on those of cutouts, in any order */
    ADDRESS(fill_totals_block) totals;
    uint page_limit;
    uint pair_capacity;
    uint caster_count;                   /* items before this one cast shadows, if they are triangles */
    uint group_count;
    uint unit_count;
};

/* Begins as what fragment shaders of the scene expect. */
struct gpu_fill_draw_push {
    STRUCT(gpu_geometry_push) geometry;
    ADDRESS(fill_pair_array) pairs;
    ADDRESS(const_uint_array) drawn;
    ADDRESS(shadow_page_array) pages;
    ADDRESS(const_shadow_shape_array) shapes;
    float side; /* of the atlas, texels */
};

#endif
