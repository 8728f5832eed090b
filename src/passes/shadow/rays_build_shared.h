/* SPDX-License-Identifier: MIT */
/** Building the trees of shadows/rays_shared.h. */
#ifndef FNL_PASSES_RAYS_BUILD_SHARED_H
#define FNL_PASSES_RAYS_BUILD_SHARED_H

#include "shadows/rays_shared.h"

/* Keys of triangles: the primitive's number in the upper bits, and where in its box the triangle lies in the others. */
struct gpu_ray_keys_push {
    ADDRESS(scene_block) scene;
    ADDRESS(const_uint_array) indices;
    ADDRESS(ray_mesh_array) mesh_table;
    ADDRESS(uint_array) pairs;
    uint triangle_count;
    uint primitive_count;
    uint shift;          /* of the primitive's number */
};

struct gpu_ray_primitives_push {
    ADDRESS(scene_block) scene;
    ADDRESS(const_uint_array) indices;
    ADDRESS(ray_box_array) boxes;
    uint primitive_count;
};

struct gpu_ray_place_push {
    ADDRESS(rays_block) rays;
    ADDRESS(ray_item_array) placed;
    ADDRESS(ray_box_array) boxes; /* by item */
    ADDRESS(uint_array) pairs;
    uint item_count;
    vec3 low;            /* of the scene */
    vec3 scale;          /* 1 / its size, or 0 */
};

/* As VkAccelerationStructureInstanceKHR. */
struct gpu_ray_instance {
    vec4 rows[3];          /* object to world */
    uint index_and_mask;   /* number of the draw item, 24 bits; the mask above */
    uint offset_and_flags;
    uvec2 structure;       /* address of that of the triangles; 0: the instance is none */
};

struct gpu_ray_instances_push {
    ADDRESS(scene_block) scene;
    ADDRESS(ray_item_array) placed;
    ADDRESS(ray_instance_array) instances;
    ADDRESS(structure_array) structures; /* by primitive: addresses, uvec2 */
    uint item_count;
};

struct gpu_ray_links_push {
    ADDRESS(const_uint_array) pairs; /* sorted */
    ADDRESS(ray_node_array) nodes;
    ADDRESS(uint_array) next;
    ADDRESS(uint_array) ids;
    ADDRESS(uint_array) parents;     /* of nodes, then of leaves: a node's number or RAY_END */
    ADDRESS(uint_array) roots;       /* by the upper bits of the keys; or 0: there is one */
    uint count;          /* leaves, at least 1 */
    uint shift;
    uint has_roots;
};

struct gpu_ray_boxes_push {
    ADDRESS(rays_block) rays;
    ADDRESS(ray_node_array) nodes;
    ADDRESS(const_uint_array) next;
    ADDRESS(const_uint_array) parents;
    ADDRESS(coherent_counter_array) arrived; /* of nodes: how many children are done */
    ADDRESS(ray_box_array) boxes;    /* of items; triangles: 0 */
    ADDRESS(const_uint_array) ids;
    uint count;
    uint primitive_count;            /* items: 0 */
};

#endif
