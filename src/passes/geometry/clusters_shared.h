/* SPDX-License-Identifier: MIT */
/** Culling by clusters of triangles and by triangles (clusters.h). */
#ifndef FNL_PASSES_CLUSTERS_SHARED_H
#define FNL_PASSES_CLUSTERS_SHARED_H

#include "passes/geometry/mesh_shared.h"

/* Kinds of buckets. */
#define CLUSTERS_BUCKET_CULLED 1u /* triangles of opaque and cutout materials: the others are drawn as items */
#define CLUSTERS_BUCKET_DOUBLE_SIDED 2u
#define CLUSTERS_BUCKET_MIRRORED 4u

/* Where the triangles went: pairs of 32 bits, low and high. */
#define CLUSTERS_DRAWN 0
#define CLUSTERS_OUTSIDE 1
#define CLUSTERS_BACK 2
#define CLUSTERS_SMALL 3
#define CLUSTERS_OCCLUDED 4
#define CLUSTERS_REASONS 5

#define CLUSTERS_WHOLE 0xffffffffu /* of an item that is drawn as it is */

struct gpu_cull_bucket {
    uint first_item;
    uint flags; /* CLUSTERS_BUCKET_… */
};

/* What is the same for all steps; the buckets follow. */
struct gpu_cluster_params {
    uint item_count;
    uint bucket_count;
    uint cluster_capacity;  /* of items in view, together */
    uint triangle_capacity; /* of what is left of them */
    uint first_pool_index;  /* where their indices begin in the index buffer */
    uint sample_count;      /* 0: nothing is too small to be seen */
    float slack;            /* pixels by which a rasteriser moves vertices, at most */
    float
        pixels_per_slope; /* at least so many pixels to a difference of x / depth, or of x where the view is orthographic */
    vec2 samples[9];      /* where a pixel is looked at */
    uint hierarchy_width; /* of struct gpu_hierarchy's first level; 0: there is none */
    uint hierarchy_height;
    uint mesh_draws; /* of each bucket, of mesh_rows rows of mesh_row work groups at most */
    uint mesh_row;
    uint mesh_rows;
};

/* Written by the GPU; the numbers of draws of each bucket follow. */
struct gpu_cluster_totals {
    uint dispatch[3]; /* work groups: one for each cluster */
    uint slots;       /* clusters that are looked at */
    uint clusters;    /* of items in view, whether there is room or not */
    uint triangles;   /* left of them, likewise */
    uint clusters_drawn;
    uint whole_items; /* drawn as they are since a pool was too small */
    uint items_drawn;
    uint reasons[10]; /* CLUSTERS_REASONS pairs */
};

struct gpu_cluster_push {
    ADDRESS(view_block) view;
    ADDRESS(scene_block) scene;
    ADDRESS(cluster_params_block) params;
    ADDRESS(cull_bucket_array) buckets;
    ADDRESS(const_uint_array) visible_sums; /* of the items */
    ADDRESS(uint_array) cluster_sums;       /* of each item's clusters */
    ADDRESS(uint_array) slots;              /* item of each cluster */
    ADDRESS(uint_array) counts; /* triangles left of each cluster, with meshes 1 where there are some; then their sums */
    ADDRESS(uint_array) masks;
    ADDRESS(uint_array) draw_sums; /* of the items that draw something; with meshes gpu_mesh_draw.list */
    ADDRESS(draw_array)
    draws; /* those of a bucket from its first item on; with meshes struct gpu_mesh_draw, mesh_draws of each bucket */
    ADDRESS(cluster_totals_block) totals;
    ADDRESS(uint_array) indices; /* of the scene, and the pool */
    ADDRESS(uint_array)
    triangles; /* item -> where its triangles begin in here, or CLUSTERS_WHOLE; then numbers of triangles */
    ADDRESS(hierarchy_array) hierarchy;
    ADDRESS(const_uint_array) hidden; /* items that are; with hierarchy_width > 0 */
};

#endif
