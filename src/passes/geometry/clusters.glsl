// SPDX-License-Identifier: MIT
// What the steps of culling by clusters share: where things are, and what of them a picture can show. Every test keeps what it is not sure of;
// comparisons are written so that a NaN keeps too.
#ifndef CLUSTERS_GLSL
#define CLUSTERS_GLSL

#include "common.glsl"
#include "view.glsl"
#include "scene.glsl"

layout(buffer_reference) buffer cluster_params_block;
layout(buffer_reference) buffer cull_bucket_array;
layout(buffer_reference) buffer cluster_totals_block;
layout(buffer_reference) buffer hierarchy_array;

#include "passes/geometry/clusters_shared.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer cluster_params_block { gpu_cluster_params params; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer cull_bucket_array { gpu_cull_bucket at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer cluster_totals_block {
    gpu_cluster_totals totals;
    uint draw_counts[];
};
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer hierarchy_array { float at[]; };

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

// Pixels from the top left.
vec2 pixel_of_ndc(vec2 ndc) { return (vec2(ndc.x, -ndc.y) * 0.5 + 0.5) * vec2(push.view.view.size); }

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

// The rectangle that a box round a point in view space covers, in pixels, with slack; false where it may reach before the near plane.
bool screen_rectangle(vec3 center, vec3 extent, out vec2 low, out vec2 high, out float nearest_depth) {
    float z = -center.z, z0 = z - extent.z, z1 = z + extent.z;
    bool orthographic = push.view.view.orthographic > 0.5;
    low = high = vec2(0.0);
    nearest_depth = 1.0;
    if (!(z0 > push.view.view.near_distance * 1.001)) return false;
    vec2 a = center.xy - extent.xy, b = center.xy + extent.xy;
    if (!orthographic) {
        a = min(a / z0, a / z1);
        b = max(b / z0, b / z1);
    }
    vec2 p = pixel_of_ndc((a - push.view.view.ndc_offset) / push.view.view.ndc_scale);
    vec2 q = pixel_of_ndc((b - push.view.view.ndc_offset) / push.view.view.ndc_scale);
    float slack = push.params.params.slack;
    low = min(p, q) - slack - 1e-5 * abs(p);
    high = max(p, q) + slack + 1e-5 * abs(q);
    vec4 clip = push.view.view.view_to_clip * vec4(0.0, 0.0, -z0, 1.0);
    nearest_depth = clip.z / clip.w;
    return true;
}

#endif
