/* SPDX-License-Identifier: MIT */
/** Sizes of clusters, and what mesh shaders read of those that culling leaves (clusters.h). */
#ifndef FNL_PASSES_MESH_SHARED_H
#define FNL_PASSES_MESH_SHARED_H

#include "shared.h"

#define CLUSTERS_MOST_VERTICES 64
#define CLUSTERS_MOST_TRIANGLES 124
#define CLUSTERS_MASK_WORDS 4 /* bits of the triangles that a cluster keeps */
#define CLUSTERS_GROUP 64     /* threads that look at the triangles of one cluster */

/* One draw of the clusters that are left of a bucket, or of a part of them, a work group of mesh shaders for each. */
struct gpu_mesh_draw {
    ADDRESS(const_uint_array) list;         /* clusters that are left of all buckets, as numbers of slots */
    ADDRESS(const_uint_array) slots;        /* item of each slot */
    ADDRESS(const_uint_array) cluster_sums; /* of each item's clusters */
    ADDRESS(const_uint_array) masks;        /* triangles of each slot; with by_triangle */
    uint groups[3];                         /* VkDrawMeshTasksIndirectCommandEXT */
    uint first;                             /* the draw's first work group, of those of all buckets */
    uint count;                             /* its work groups; those beyond draw nothing */
    uint listed; /* work groups that `list` knows; those from here on draw the clusters of items that are drawn whole, */
    uint first_whole; /* which are this cluster, of all items in view, and those that follow */
    uint item_count;
    uint by_triangle;
};

#endif
