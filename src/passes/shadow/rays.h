/* SPDX-License-Identifier: MIT */
/**
 * The scene as shadow rays see it, for shaders/shadows/rays.glsl: one linear bounding volume hierarchy over the triangles of all primitives, in
 * which each primitive has a root of its own, and one over the draw items (Karras 2012). Both are made on the GPU by a radix sort of Morton
 * codes and need nothing but compute shaders. Cost: 40 bytes for each triangle, 28 for each primitive and 92 for each item.
 */
#ifndef FNL_PASSES_SHADOW_RAYS_H
#define FNL_PASSES_SHADOW_RAYS_H

#include "graph/graph.h"
#include "passes/shadow/ray_query.h"
#include "shadows/rays_shared.h"

struct rays_input {
    graph_buffer vertices; /* positions and instances, for their hazards */
    VkDeviceAddress scene, indices;
    VkDeviceAddress mesh_table; /* struct gpu_ray_mesh[primitive_count]: triangles one primitive after the other, none for lines and points */
    uint32_t primitive_count, triangle_count, item_count;
    vec3 low, high;        /* of the scene; items beyond it cost rays time alone */
    const struct gpu_buffer *meshes, *items; /* what is kept: of rays_mesh_bytes() and rays_item_bytes(). `meshes` NULL: no rays
                                                are traced, and the tree over items is all that is wanted */
    bool make_meshes;      /* triangles have come or gone, or their vertices have moved */
    bool place;            /* that, or items have come, gone or moved, and the tree over items is wanted */
    const struct ray_query_input *query; /* rays go through the device's own structures: `meshes` is NULL. NULL: they do not */
};
uint64_t rays_mesh_bytes(uint32_t triangle_count, uint32_t primitive_count);
uint64_t rays_item_bytes(uint32_t item_count, uint32_t primitive_count);

struct rays {
    graph_buffer meshes, items; /* for shaders that trace: rays_use(). meshes may be id 0 */
    graph_buffer bottoms, top;  /* with rays_input.query; or id 0 */
    graph_buffer vertices;
    VkDeviceAddress address;    /* struct gpu_rays; 0: no memory */
};
struct rays rays_add(struct graph *graph, gpu_device *device, const struct rays_input *input);
/** Declares that a pass traces shadow rays. */
void rays_use(struct graph_pass *pass, const struct rays *rays, enum graph_use use);

#endif
