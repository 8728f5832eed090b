/* SPDX-License-Identifier: MIT */
/**
 * The scene for shadow rays through the device's own acceleration structures (VK_KHR_ray_query), in place of the trees of rays.h: a structure for the
 * triangles of each primitive, and one over the draw items, which the device builds. Only where fnl_device_info.ray_query.
 */
#ifndef FNL_PASSES_SHADOW_RAY_QUERY_H
#define FNL_PASSES_SHADOW_RAY_QUERY_H

#include "graph/graph.h"

enum { RAY_QUERY_MOST_ITEMS = 1 << 24 }; /* numbers of instances have 24 bits */

struct ray_query_copy {
    struct gpu_structure from, to;
};

/** What is there, and what of it is to be made. All it points to stays until the frame is executed. */
struct ray_query_input {
    const struct gpu_buffer *bottoms;   /* stands in the graph for the structures of all primitives */
    const struct gpu_structure *top;    /* over the items */
    const struct gpu_buffer *instances; /* ray_query_instance_bytes() */
    VkDeviceAddress structures;         /* by primitive: address of its structure, or 0 */
    struct gpu_structure_build *builds; /* of primitives; `scratch`: bytes that it needs, which become its offset here */
    uint32_t build_count;
    const struct ray_query_copy *copies; /* to be compacted */
    uint32_t copy_count;
    const struct gpu_structure_queries *queries; /* sizes are measured of `measured`, once these are built */
    const struct gpu_structure *measured;
    uint32_t measured_count;
    uint64_t top_scratch;
    bool place; /* items have come, gone or moved, or some structure is another */
};
uint64_t ray_query_instance_bytes(uint32_t item_count);

struct rays;
struct rays_input;
/** Adds to `rays`, of rays_add. */
void ray_query_add(struct graph *graph, gpu_device *device, const struct rays_input *input, VkDeviceAddress placed, struct rays *rays);

#endif
