#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Bounds of the occupied cells: their cluster's sides and a box round their own pixels (ES-54); and the planes that all of their surfaces
// face away from (ES-56).
#include "common.glsl"
#include "passes/lights/bvh.glsl"
#include "passes/lights/sparse_shared.h"

layout(constant_id = 1) const uint SAMPLES = 1u;

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_sparse_push push; };

#include "passes/lights/sparse.glsl"

void main() {
    uint cell = LINEAR_INVOCATION;
    if (cell >= min(push.table.at[push.key_count], push.cell_limit)) return;
    uint key = push.keys.at[cell];
    gpu_cell_bounds bounds = cluster_bounds(push.view, push.list, key / push.buckets);
    uint first = cell * SPARSE_EXTENTS(push.buckets);
    vec3 low, high;
    for (uint axis = 0u; axis < 3u; axis++) {
        low[axis] = unordered(push.extents.at[first + axis]);
        high[axis] = unordered(push.extents.at[first + 3u + axis]);
    }
    float slack = CELL_SLACK * max_component(max(abs(low), abs(high)));
    // With more samples surfaces are shaded between them: the cluster itself is the bound.
    if (SAMPLES == 1u) {
        bounds.low = low - slack;
        bounds.high = high + slack;
    }
    push.bounds.at[cell] = bounds;
    if (push.buckets == 1u) return;
    for (uint corner = 0u; corner < 4u; corner++)
        push.facings.at[cell].planes[corner] =
            vec4(corner_in_view(cell, key % push.buckets, corner), slack - unordered(push.extents.at[first + 10u + corner]));
}
