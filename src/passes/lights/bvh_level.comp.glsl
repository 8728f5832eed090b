#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// One level of the tree from the one below.
#include "common.glsl"
#include "passes/lights/bvh.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_bvh_tree_push push; };

void main() {
    uint node = LINEAR_INVOCATION;
    if (node >= push.capacity_out) return;
    gpu_bvh_box box = box_empty();
    uint end = min((node + 1u) * BVH_WIDTH, push.capacity_in);
    for (uint child = node * BVH_WIDTH; child < end; child++) {
        gpu_bvh_box b = push.boxes.at[push.first_in + child];
        box_add(box, b.low, b.high);
    }
    push.boxes.at[push.first_out + node] = box;
}
