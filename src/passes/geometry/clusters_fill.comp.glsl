#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Writes the indices of the triangles that are left, and which they were; a work group for each cluster.
#include "passes/geometry/clusters.glsl"

layout(local_size_x = CLUSTERS_GROUP) in;
layout(constant_id = 0) const uint BY_TRIANGLE = 0u;

void main() {
    uint slot = LINEAR_GROUP;
    if (slot >= push.totals.totals.slots) return;
    uint before = push.counts.at[slot], count = push.counts.at[slot + 1u] - before;
    if (count == 0u) return;
    uint item = push.slots.at[slot];
    if (push.counts.at[push.cluster_sums.at[item + 1u]] > push.params.params.triangle_capacity) return; // drawn whole
    if (gl_LocalInvocationIndex == 0u) atomicAdd(push.totals.totals.clusters_drawn, 1u);
    gpu_primitive primitive = push.scene.scene.primitives.at[push.scene.scene.items.at[item].primitive];
    gpu_cluster cluster = push.scene.scene.clusters.at[primitive.first_cluster + slot - push.cluster_sums.at[item]];
    for (uint i = gl_LocalInvocationIndex; i < cluster.triangle_count; i += CLUSTERS_GROUP) {
        uint place = before + i;
        if (BY_TRIANGLE != 0u) {
            uint word = push.masks.at[slot * CLUSTERS_MASK_WORDS + (i >> 5)], bit = 1u << (i & 31u);
            if ((word & bit) == 0u) continue;
            place = before + bitCount(word & (bit - 1u));
            for (uint k = 0u; k < i >> 5; k++) place += bitCount(push.masks.at[slot * CLUSTERS_MASK_WORDS + k]);
        }
        uint triangle = cluster.first_triangle + i;
        for (uint k = 0u; k < 3u; k++)
            push.indices.at[push.params.params.first_pool_index + place * 3u + k] = push.indices.at[primitive.first_index + triangle * 3u + k];
        push.triangles.at[push.params.params.item_count + place] = triangle;
    }
}
