/* SPDX-License-Identifier: MIT */
/**
 * Tiled light trees (Y. O'Donnell, M. G. Chajdas, "Tiled Light Trees", I3D 2017), built by threads on the CPU: each tile has a hierarchy
 * over the depths between which its lights are in it, and a pixel visits the lights whose range holds its depth. Needs no depth.
 *
 * In the source a tile has one tree, and lights come as its leaves stand. Here they must ascend, so each 128 lights of a tile have a tree
 * of their own and the walk notes what it finds in as many bits (shaders/lights/tree.glsl).
 */
#ifndef FNL_PASSES_TREE_H
#define FNL_PASSES_TREE_H

#include "base/jobs.h"
#include "passes/lights/light_list.h"
#include "view_shared.h"

struct light_tree_params {
    uint32_t tile_size; /* pixels; default 16 */
    /* Where a walk is not expected to save tests, as where most lights reach through most of the tile's depth, 128 lights stand in a plain
       row, each with its range. Default true. */
    bool hybrid;
};
struct light_tree_params light_tree_params_default(void);

struct light_tree_sphere {
    double center[3], radius; /* view space; radius <= 0: reaches nothing */
    double slack;             /* metres by which rounding may have moved it */
    double
        slopes[4]; /* its rectangle on the screen: left, right, bottom, top, as x or y / view depth (orthographic: x or y) */
};

/** Memory of the builder, kept from frame to frame. After light_tree_build `cells` and `ids` hold the lists, ascending, and `nodes` the trees. */
struct light_tree {
    const fnl_host *host;
    ARRAY(struct light_tree_sphere) spheres;
    ARRAY(struct gpu_cell) cells;
    ARRAY(uint32_t) ids;
    ARRAY(uint32_t) ranges; /* of each entry, as in shaders/lights/ranges.glsl */
    ARRAY(uint32_t) nodes;  /* four words an entry */
    uint32_t capacity;      /* entries that may be stored; cells beyond use all lights; 2^26 */
    uint32_t overflow_cells, in_view;
    uint64_t entry_count;
};

void light_tree_init(struct light_tree *builder, const fnl_host *host);
void light_tree_finish(struct light_tree *builder);

/** Fills in the spheres from bounds of these kinds (light_input.kinds). */
fnl_result light_tree_see(struct light_tree *builder, const struct gpu_entity_bounds *bounds, uint32_t count, uint32_t kinds,
                          const struct gpu_view *view);
/** Builds lists and trees for the grid of the header from the spheres. */
fnl_result light_tree_build(struct light_tree *builder, struct jobs *jobs, const struct gpu_light_list *header,
                            const struct gpu_view *view, bool hybrid);
/** Both, and sends the result to the device. `bounds`: those of `input`. */
struct light_list light_tree_add(struct light_tree *builder, gpu_device *device, const struct light_input *input,
                                 const struct gpu_entity_bounds *bounds, const struct gpu_view *view,
                                 const struct light_tree_params *params);

/** The code of a view depth: twin of depth_code() in shaders/lights/ranges.glsl. */
uint32_t light_tree_depth_code(float view_depth);
/**
 * The walk that shaders make, on the CPU: entries of a cell (their indices from the cell's first) whose range holds the depth, ascending, into
 * `out`. Returns their number; adds the nodes visited.
 */
uint32_t light_tree_walk(const struct light_tree *builder, uint32_t cell, float view_depth, uint32_t *out,
                         uint64_t *visited);

#endif
