/* SPDX-License-Identifier: MIT */
/**
 * Culling finer than items: clusters of triangles, then triangles, in compute shaders that write the indices of what is left (Engel, "The
 * filtered and culled visibility buffer", GDC Europe 2016; Haar and Aaltonen, "GPU-driven rendering pipelines", SIGGRAPH 2015). The picture
 * stays the same to the bit: items and triangles keep their order, and nothing goes that could cover a sample.
 */
#ifndef FNL_PASSES_CLUSTERS_H
#define FNL_PASSES_CLUSTERS_H

#include "passes/geometry/clusters_shared.h"
#include "passes/geometry/geometry.h"
#include "view_shared.h"

struct hierarchy; /* occlusion.h */

struct clusters_params {
    bool by_triangle; /* looks at each triangle of the clusters that are left */
    /**
     * Everything is drawn into pixels of the view's size and of `samples` samples: what covers none of those is left out. False where some
     * pass draws in a coarser raster.
     */
    bool full_raster;
    uint32_t samples;
    bool centers; /* besides, some pass looks at the pixels' centres alone */
    uint32_t
        cluster_capacity; /* of the items in view; those that do not fit are drawn whole, as are those whose triangles do not */
    uint32_t pool; /* which part of the triangle pool: views that are culled before one of them is drawn have parts of their own */
    const struct hierarchy *occluders; /* or NULL */
    /** For mesh shaders: no indices are written, and no triangle pool is needed; fnl_device_info.mesh_shader. */
    bool meshes;
    uint32_t mesh_row, mesh_rows; /* with meshes: work groups of a draw, in two dimensions: at most 65535 and 64 */
};

/**
 * Adds item_draws and what goes with them to `draws`, which cull_add made. `view` is `camera` on the device. Cost: of each visible item a few
 * reads, of each of its clusters a sphere and a cone against the view, of each triangle three vertices; 4 bytes for each cluster and each item,
 * 16 for each triangle drawn, or, with meshes, 4 more for each cluster and none for triangles.
 */
void clusters_add(struct graph *graph, gpu_device *device, const struct geometry_scene *scene, const struct gpu_view *camera,
                  VkDeviceAddress view, const struct clusters_params *params, struct geometry_draws *draws);

#endif
