/* SPDX-License-Identifier: MIT */
/** A tree over the lights in view, and clusters that are filled from it. */
#ifndef FNL_PASSES_BVH_SHARED_H
#define FNL_PASSES_BVH_SHARED_H

#include "shared.h"
#include "passes/lights/cells_shared.h"

#define BVH_WIDTH 32u      /* children of a node, spheres of a leaf */
#define BVH_KEY_BITS 24u   /* eight an axis */
#define BVH_SORT_THREADS 64u

/* View space; low.x > high.x: holds nothing. */
struct gpu_bvh_box {
    vec3 low;
    vec3 high;
};

struct gpu_bvh_tree_push {
    ADDRESS(view_block) view;
    ADDRESS(light_list_block) list;  /* its grid gives the curve */
    ADDRESS(const_uint_array) count; /* lights in view */
    ADDRESS(bound_array) bounds;     /* of the lights in view */
    ADDRESS(uint_array) pairs;       /* key, index among the lights in view */
    ADDRESS(bound_array) spheres;    /* the bounds along the curve */
    ADDRESS(box_array) boxes;        /* all levels, the leaves first */
    uint first_in;                   /* the level below, in boxes */
    uint first_out;
    uint capacity_in;                /* its nodes, as many as there could be */
    uint capacity_out;
};

/* How cells make up groups. */
struct gpu_bvh_groups {
    uint run;                     /* this many follow each other, and the number of cells is read; 0: they are blocks of a grid */
    uvec3 block;                  /* clusters across, up and deep */
};

/* Which nodes touch which groups of cells, level by level from the top. */
struct gpu_bvh_mask_push {
    ADDRESS(light_list_block) list;
    ADDRESS(const_uint_array) count;
    ADDRESS(const_uint_array) cell_counter; /* number of cells, where they are runs */
    ADDRESS(bounds_array) cells;
    ADDRESS(box_array) groups;
    ADDRESS(box_array) boxes;
    ADDRESS(uint_array) masks;    /* of all levels: [group][word], a bit for each node */
    uint cell_count;
    STRUCT(gpu_bvh_groups) rule;
    uint group_count;
    uint first_node;              /* the level's, in boxes */
    uint node_lights;             /* that a node of the level holds */
    uint first_mask;
    uint words;
    uint first_parent;            /* masks of the level above */
    uint parent_words;            /* 0: this is the top */
};

/* What a query does not change from pass to pass. */
struct gpu_bvh_query {
    uint cell_count;
    STRUCT(gpu_bvh_groups) rule;
    uint words;                   /* of the leaves' masks, for a group */
    uint chunk_words;             /* that one thread takes */
    uint chunk_count;
    uint capacity;                /* of the pool */
    uint flags;                   /* CELLS_CONES, BVH_FACINGS */
};
#define BVH_FACINGS 0x10000u

/* Surfaces face away from all lights on the outer side of these planes at once, view space: unit normals. */
struct gpu_facing {
    vec4 planes[4];
};

struct gpu_bvh_query_push {
    ADDRESS(bvh_query_block) query;
    ADDRESS(light_list_block) list;
    ADDRESS(const_uint_array) count;
    ADDRESS(const_uint_array) cell_counter;
    ADDRESS(bounds_array) cells;
    ADDRESS(facing_array) facings;
    ADDRESS(box_array) boxes;
    ADDRESS(uint_array) masks;
    ADDRESS(bound_array) spheres;
    ADDRESS(uint_array) pairs;
    ADDRESS(reach_array) reaches;
    ADDRESS(const_uint_array) visible_ids;
    ADDRESS(uint_array) sums;     /* cell * chunk_count + chunk, and one more */
    ADDRESS(uint_array) ids;      /* the pool, not in order yet */
    ADDRESS(uint_array) overflow;
};

struct gpu_bvh_sort_push {
    ADDRESS(light_list_block) list;
    ADDRESS(const_uint_array) cell_counter;
    ADDRESS(coherent_uint_array) first;  /* where the ids are */
    ADDRESS(coherent_uint_array) second; /* the other pool */
    ADDRESS(coherent_uint_array) target; /* one of the two: where they end */
    uint cell_count;
    uint counted;
    uint steps;                   /* of RADIX_BITS */
};

#endif
