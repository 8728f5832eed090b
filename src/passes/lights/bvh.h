/* SPDX-License-Identifier: MIT */
/**
 * A tree over the lights in view, made anew in each frame, and clusters that are filled from it (Olsson, Billeter, Assarsson 2012): the
 * lights are sorted along a Morton curve through the grid of clusters, 32 spheres make a leaf, and 32 boxes a node. Groups of clusters
 * walk down the tree together, a bit for each node that their box touches; then each cluster asks the leaves that are left and their spheres
 * with the very test of the other cells. At last the lights of each cluster are put back into ascending order. All steps are counted
 * before they are written: nothing depends on the order of threads.
 */
#ifndef FNL_PASSES_BVH_H
#define FNL_PASSES_BVH_H

#include "passes/geometry/radix_sort.h"
#include "passes/lights/cells.h"

enum { BVH_LEVELS = 7 };

struct bvh {
    graph_buffer pairs;   /* key, index among the lights in view */
    graph_buffer spheres; /* struct gpu_bound along the curve */
    graph_buffer boxes;   /* struct gpu_bvh_box of all levels */
    uint32_t level_count;
    uint32_t counts[BVH_LEVELS], firsts[BVH_LEVELS]; /* nodes of each level, leaves first, as if all lights were in view */
};

/** The tree, one a view; `header` is a list whose grid is filled in. */
struct bvh bvh_tree_add(struct graph *graph, const struct light_input *input, const struct lights_in_view *in_view,
                        VkDeviceAddress header);

struct bvh_query {
    const char *what;             /* passes and buffers are called "`what` …" */
    graph_buffer bounds;          /* struct gpu_cell_bounds */
    uint32_t cell_count;          /* that could be */
    graph_buffer cell_counter;    /* their number; id 0: cell_count, and they are the clusters of the header's grid */
    uint64_t cell_counter_offset; /* bytes */
    graph_buffer facings;         /* struct gpu_facing, or id 0 */
    bool cone_tests;
    bool occupied; /* cells serve the surfaces alone that they were made for: scattered points need bounds and the spare list */
    uint32_t pool_capacity;
    struct gpu_light_list *header; /* grid filled in */
    VkDeviceAddress header_address;
};

/** Fills the lists of cells from the tree; the list's kind and what its cells take are left to the caller. */
struct light_list bvh_query_add(struct graph *graph, gpu_device *device, const struct light_input *input,
                                const struct lights_in_view *in_view, const struct bvh *tree, const struct bvh_query *query);

/** Clusters of the header's grid, filled from the tree. */
struct light_list bvh_clusters_add(struct graph *graph, gpu_device *device, const struct light_input *input,
                                   const struct lights_in_view *in_view, const struct bvh *tree, const char *what,
                                   struct gpu_light_list *header, VkDeviceAddress header_address,
                                   const struct clustered_params *params);

/** The clusters of clustered_add, filled from a tree made for them: the same entries in the same order. Needs no depth. */
struct light_list bvh_add(struct graph *graph, gpu_device *device, const struct light_input *input,
                          const struct lights_in_view *in_view, const struct clustered_params *params);

#endif
