// SPDX-License-Identifier: MIT
// What the steps of culling by clusters share: where things are, and what of them a picture can show. Every test keeps what it is not sure of;
// comparisons are written so that a NaN keeps too.
#ifndef CLUSTERS_GLSL
#define CLUSTERS_GLSL

#include "common.glsl"
#include "view.glsl"
#include "scene.glsl"
#include "passes/geometry/hierarchy.glsl"

layout(buffer_reference) buffer cluster_params_block;
layout(buffer_reference) buffer cull_bucket_array;
layout(buffer_reference) buffer cluster_totals_block;

#include "passes/geometry/clusters_shared.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer cluster_params_block { gpu_cluster_params params; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer cull_bucket_array { gpu_cull_bucket at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer cluster_totals_block {
    gpu_cluster_totals totals;
    uint draw_counts[];
};

layout(push_constant, scalar) uniform push_block { gpu_cluster_push push; };

// The flags of an item's bucket, and the bucket's first item.
uint bucket_flags(uint item, out uint first_item) {
    uint low = 0u, high = push.params.params.bucket_count; // buckets are in order
    while (high - low > 1u) {
        uint middle = (low + high) / 2u;
        if (push.buckets.at[middle].first_item <= item) low = middle;
        else high = middle;
    }
    first_item = push.buckets.at[low].first_item;
    return push.buckets.at[low].flags;
}

void count_reason(uint reason, uint amount) {
    if (amount == 0u) return;
    uint before = atomicAdd(push.totals.totals.reasons[reason * 2u], amount);
    if (before + amount < before) atomicAdd(push.totals.totals.reasons[reason * 2u + 1u], 1u);
}

vec2 pixel_of_ndc(vec2 ndc) { return hierarchy_pixel(push.view, ndc); }

// Whether no sample of any pixel lies in a rectangle.
bool misses_samples(vec2 low, vec2 high) {
    bool misses = push.params.params.sample_count > 0u;
    for (uint i = 0u; i < push.params.params.sample_count; i++) {
        vec2 at = push.params.params.samples[i];
        bvec2 empty = lessThan(floor(high - at), ceil(low - at));
        misses = misses && (empty.x || empty.y);
    }
    return misses;
}

#endif
