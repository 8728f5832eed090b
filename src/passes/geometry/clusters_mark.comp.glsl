#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Which items draw something: what is left of them, or, where the pools cannot hold it, all of them.
#include "passes/geometry/clusters.glsl"

layout(local_size_x = 64) in;

void main() {
    uint index = LINEAR_INVOCATION, count = push.params.params.item_count;
    if (index > count) return;
    if (index == count) {
        push.draw_sums.at[index] = 0u;
        push.totals.totals.triangles = push.counts.at[push.totals.totals.slots];
        return;
    }
    uint first = push.cluster_sums.at[index], end = push.cluster_sums.at[index + 1u], draws = 0u;
    if (end != first) {
        bool fits = end <= push.params.params.cluster_capacity;
        uint triangles = 0u;
        if (fits) {
            triangles = push.counts.at[end] - push.counts.at[first];
            fits = push.counts.at[end] <= push.params.params.triangle_capacity;
        }
        if (!fits) {
            triangles = push.scene.scene.primitives.at[push.scene.scene.items.at[index].primitive].index_count / 3u;
            atomicAdd(push.totals.totals.whole_items, 1u);
        }
        draws = triangles > 0u ? 1u : 0u;
        if (draws == 1u) atomicAdd(push.totals.totals.items_drawn, 1u);
        count_reason(CLUSTERS_DRAWN, triangles);
    }
    push.draw_sums.at[index] = draws;
}
