#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The leaves: 32 spheres that follow each other on the curve, gathered, and the box round them.
#include "common.glsl"
#include "passes/lights/bvh.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_bvh_tree_push push; };

void main() {
    uint leaf = LINEAR_INVOCATION, count = push.count.at[0];
    if (leaf >= push.capacity_out) return;
    gpu_bvh_box box = box_empty();
    uint end = min((leaf + 1u) * BVH_WIDTH, count);
    for (uint k = leaf * BVH_WIDTH; k < end; k++) {
        gpu_bound sphere = push.bounds.at[push.pairs.at[k * 2u + 1u]];
        push.spheres.at[k] = sphere;
        float radius = cell_radius(sphere) * (1.0 + CELL_SLACK) + 1e-6 * dot(abs(sphere.center), vec3(1.0));
        vec3 low = sphere.center - radius, high = sphere.center + radius;
        // What is not finite may be anywhere: the cells' own tests decide.
        if (!(all(greaterThan(low, vec3(-BOX_FAR))) && all(lessThan(high, vec3(BOX_FAR))))) {
            low = vec3(-BOX_FAR);
            high = vec3(BOX_FAR);
        }
        box_add(box, low, high);
    }
    push.boxes.at[leaf] = box;
}
