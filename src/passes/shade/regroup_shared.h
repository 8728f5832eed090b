/* SPDX-License-Identifier: MIT */
/** Draws of opaque items, dealt out anew by what lights them. */
#ifndef FNL_PASSES_REGROUP_SHARED_H
#define FNL_PASSES_REGROUP_SHARED_H

#include "passes/geometry/geometry_shared.h"
#include "shared.h"

#define REGROUP_COUNT 0u
#define REGROUP_FILL 1u
#define REGROUP_DRAWS 2u

/* Batches: items by the number of their lights: 0, 1, 2, up to 4, 8, 16, more. */
#define REGROUP_CLASSES 7u

struct gpu_regroup_push {
    ADDRESS(scene_block) scene;
    ADDRESS(light_list_block) list;    /* of GPU_LIST_ITEMS */
    ADDRESS(const_uint_array) culled;  /* prefix sums of the items' visibility */
    ADDRESS(const_uint_array) visible; /* items in view, in order */
    ADDRESS(uint_array) counts;        /* key * group_count + group, and one more: items, then their prefix sum */
    ADDRESS(uint_array) cursors;       /* as counts: items written so far; zero to begin with */
    ADDRESS(uint_array) items;         /* those in view, then those of each key and group */
    ADDRESS(draw_array) draws;         /* as counts */
    uint item_count;
    uint group_count;
    uint key_count;                    /* lights or classes */
    uint capacity;                     /* of items, behind the first item_count */
};

/* What the fragment shaders of these passes need besides. */
struct gpu_regroup_draw_push {
    STRUCT(gpu_geometry_push) geometry;
    uint owners;      /* bindless: the item that each pixel shows */
    uint sum;         /* bindless: light so far, for the last step */
    uint light;       /* index into the light array */
};

#define MULTIPASS_DIRECTIONAL 0u
#define MULTIPASS_LIGHT 1u
#define MULTIPASS_REST 2u

#endif
