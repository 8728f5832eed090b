// SPDX-License-Identifier: MIT
// The tree over the lights in view.
#ifndef BVH_GLSL
#define BVH_GLSL

#include "passes/lights/cells.glsl"

layout(buffer_reference) buffer box_array;
layout(buffer_reference) buffer facing_array;
layout(buffer_reference) buffer bvh_query_block;
layout(buffer_reference) buffer coherent_uint_array;

#include "passes/lights/bvh_shared.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer box_array { gpu_bvh_box at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer facing_array { gpu_facing at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer bvh_query_block { gpu_bvh_query query; };
layout(buffer_reference, scalar, buffer_reference_align = 4) coherent buffer coherent_uint_array { uint at[]; };

const float BOX_FAR = 3e38;

gpu_bvh_box box_empty() { return gpu_bvh_box(vec3(BOX_FAR), vec3(-BOX_FAR)); }

void box_add(inout gpu_bvh_box b, vec3 low, vec3 high) {
    b.low = min(b.low, low);
    b.high = max(b.high, high);
}

// Blocks of a grid of clusters, or runs where cells are numbered without gaps.
uint group_of(light_list_block l, uint cell, gpu_bvh_groups rule) {
    if (rule.run > 0u) return cell / rule.run;
    uint x = cell % l.list.tiles_x, y = cell / l.list.tiles_x % l.list.tiles_y, slice = cell / (l.list.tiles_x * l.list.tiles_y);
    uvec2 groups = (uvec2(l.list.tiles_x, l.list.tiles_y) + rule.block.xy - 1u) / rule.block.xy;
    return (slice / rule.block.z * groups.y + y / rule.block.y) * groups.x + x / rule.block.x;
}

bool boxes_touch(vec3 low_a, vec3 high_a, vec3 low_b, vec3 high_b) {
    return all(lessThanEqual(low_a, high_b)) && all(lessThanEqual(low_b, high_a));
}

// False only where cell_touches() is for all spheres in the box.
bool cell_touches_box(gpu_cell_bounds b, gpu_bvh_box box) {
    if (!boxes_touch(b.low, b.high, box.low, box.high)) return false;
    for (int i = 0; i < 4; i++) {
        vec3 farthest = mix(box.low, box.high, greaterThan(b.planes[i].xyz, vec3(0.0)));
        if (dot(b.planes[i].xyz, farthest) + b.planes[i].w < 0.0) return false;
    }
    return true;
}

#endif
