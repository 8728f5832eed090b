#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// For mesh shaders: the list of the clusters that are left, the draws of each bucket, and how many items draw something. The sums of clusters rise
// from item to item, so those that the pool cannot hold are the last ones, and their work groups follow those of the list.
#include "passes/geometry/clusters.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 8) buffer mesh_draw_array { gpu_mesh_draw at[]; };

layout(local_size_x = 64) in;
layout(constant_id = 0) const uint BY_TRIANGLE = 0u;

bool fits(uint item) { return push.cluster_sums.at[item] <= push.params.params.cluster_capacity; } // all before it, that is

// The sum of the clusters of all items that fit.
uint sum_that_fits() {
    uint low = 0u, high = push.params.params.item_count + 1u;
    while (high - low > 1u) {
        uint middle = (low + high) / 2u;
        if (fits(middle)) low = middle;
        else high = middle;
    }
    return push.cluster_sums.at[low];
}

uint groups_before(uint item, uint fitting) {
    uint clusters = push.cluster_sums.at[item];
    return push.counts.at[min(clusters, fitting)] + max(clusters, fitting) - fitting;
}

void write_draw(uint index) {
    uint bucket = index / push.params.params.mesh_draws, size = push.params.params.mesh_row * push.params.params.mesh_rows;
    uint end_item = bucket + 1u < push.params.params.bucket_count ? push.buckets.at[bucket + 1u].first_item : push.params.params.item_count;
    uint fitting = sum_that_fits();
    uint end = groups_before(end_item, fitting), first = min(groups_before(push.buckets.at[bucket].first_item, fitting) +
                                                             (index - bucket * push.params.params.mesh_draws) * size, end);
    uint count = min(end - first, size);
    mesh_draw_array draws = mesh_draw_array(push.draws);
    draws.at[index].list = const_uint_array(push.draw_sums);
    draws.at[index].slots = const_uint_array(push.slots);
    draws.at[index].cluster_sums = const_uint_array(push.cluster_sums);
    draws.at[index].masks = const_uint_array(push.masks);
    draws.at[index].first = first;
    draws.at[index].count = count;
    draws.at[index].groups[0] = min(count, push.params.params.mesh_row);
    draws.at[index].groups[1] = (count + push.params.params.mesh_row - 1u) / push.params.params.mesh_row;
    draws.at[index].groups[2] = 1u;
    draws.at[index].listed = push.counts.at[fitting];
    draws.at[index].first_whole = fitting;
    draws.at[index].item_count = push.params.params.item_count;
    draws.at[index].by_triangle = BY_TRIANGLE;
}

void main() {
    uint index = LINEAR_INVOCATION;
    if (index < push.totals.totals.slots) {
        uint place = push.counts.at[index];
        if (push.counts.at[index + 1u] != place) push.draw_sums.at[place] = index;
    }
    if (index == 0u) push.totals.totals.clusters_drawn = push.counts.at[push.totals.totals.slots];
    if (index < push.params.params.bucket_count * push.params.params.mesh_draws) write_draw(index);
    if (index >= push.params.params.item_count) return;
    uint first = push.cluster_sums.at[index], end = push.cluster_sums.at[index + 1u];
    if (first == end) return;
    if (fits(index + 1u)) {
        if (push.counts.at[end] != push.counts.at[first]) atomicAdd(push.totals.totals.items_drawn, 1u);
        return;
    }
    atomicAdd(push.totals.totals.whole_items, 1u);
    atomicAdd(push.totals.totals.items_drawn, 1u);
    count_reason(CLUSTERS_DRAWN, push.scene.scene.primitives.at[push.scene.scene.items.at[index].primitive].index_count / 3u);
}
