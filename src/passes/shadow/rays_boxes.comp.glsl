#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The boxes of nodes, from the leaves up: of the two threads that come to a node the second goes on.
#include "common.glsl"
#include "passes/shadow/rays_build.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_ray_boxes_push push; };

gpu_ray_box leaf_box(uint leaf) {
    uint id = push.ids.at[leaf];
    if (push.primitive_count == 0u) return push.boxes.at[id];
    ray_mesh_array table = push.rays.rays.mesh_table;
    uint primitive = primitive_of(table, push.primitive_count, id);
    uvec3 corners = ray_corners(push.rays, table.at[primitive], primitive, id);
    position_array positions = push.rays.rays.scene.scene.positions;
    vec3 a = positions.at[corners.x], b = positions.at[corners.y], c = positions.at[corners.z];
    return ray_box_widened(min(a, min(b, c)), max(a, max(b, c)));
}

gpu_ray_box child_box(uint reference) {
    if ((reference & RAY_LEAF) != 0u) return leaf_box(reference & ~RAY_LEAF);
    return gpu_ray_box(push.nodes.at[reference].low, push.nodes.at[reference].high);
}

void main() {
    uint leaf = LINEAR_INVOCATION;
    if (leaf >= push.count) return;
    uint node = push.parents.at[push.count + leaf];
    while (node != RAY_END) {
        memoryBarrierBuffer();
        if (atomicAdd(push.arrived.at[node], 1u) == 0u) return;
        memoryBarrierBuffer();
        uint first = push.nodes.at[node].first;
        uint second = push.next.at[(first & RAY_LEAF) != 0u ? first & ~RAY_LEAF : push.nodes.at[first].last];
        gpu_ray_box a = child_box(first), b = child_box(second);
        push.nodes.at[node].low = min(a.low, b.low);
        push.nodes.at[node].high = max(a.high, b.high);
        node = push.parents.at[node];
    }
}
