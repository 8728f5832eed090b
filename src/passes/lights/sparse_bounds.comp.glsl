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
    // With more samples surfaces are shaded between them: the cluster itself is the bound.
    if (SAMPLES == 1u) {
        for (uint axis = 0u; axis < 3u; axis++) {
            bounds.low[axis] = unordered(push.extents.at[cell * 6u + axis]);
            bounds.high[axis] = unordered(push.extents.at[cell * 6u + 3u + axis]);
        }
        vec3 far = max(abs(bounds.low), abs(bounds.high));
        float slack = CELL_SLACK * max_component(far);
        bounds.low -= slack;
        bounds.high += slack;
    }
    push.bounds.at[cell] = bounds;
    if (push.buckets == 1u) return;
    for (uint corner = 0u; corner < 4u; corner++) {
        vec3 n = normalize(mat3(push.view.view.world_to_view) * bucket_corner(key % push.buckets, corner));
        vec3 nearest = mix(bounds.high, bounds.low, greaterThan(n, vec3(0.0)));
        push.facings.at[cell].planes[corner] = vec4(n, -dot(n, nearest));
    }
}
