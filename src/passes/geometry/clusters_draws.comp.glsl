#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// One indirect draw for each item that draws something, those of a bucket in a row.
#include "passes/geometry/clusters.glsl"

layout(local_size_x = 64) in;

void main() {
    uint index = LINEAR_INVOCATION, count = push.params.params.item_count;
    if (index < push.params.params.bucket_count) {
        uint end = index + 1u < push.params.params.bucket_count ? push.buckets.at[index + 1u].first_item : count;
        push.totals.draw_counts[index] = push.draw_sums.at[end] - push.draw_sums.at[push.buckets.at[index].first_item];
    }
    if (index >= count) return;
    uint place = push.draw_sums.at[index], first_item;
    uint begin = CLUSTERS_WHOLE;
    if (push.draw_sums.at[index + 1u] != place) {
        bucket_flags(index, first_item);
        gpu_primitive primitive = push.scene.scene.primitives.at[push.scene.scene.items.at[index].primitive];
        gpu_draw draw;
        draw.index_count = primitive.index_count;
        draw.instance_count = 1u;
        draw.first_index = primitive.first_index;
        draw.vertex_offset = primitive.vertex_offset;
        draw.first_instance = push.visible_sums.at[index];
        uint first = push.cluster_sums.at[index], end = push.cluster_sums.at[index + 1u];
        if (end <= push.params.params.cluster_capacity && push.counts.at[end] <= push.params.params.triangle_capacity) {
            uint before = push.counts.at[first];
            draw.index_count = (push.counts.at[end] - before) * 3u;
            draw.first_index = push.params.params.first_pool_index + before * 3u;
            begin = count + before;
        }
        push.draws.at[first_item + place - push.draw_sums.at[first_item]] = draw;
    }
    push.triangles.at[index] = begin;
}
