#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// How many clusters each visible item has.
#include "passes/geometry/clusters.glsl"

layout(local_size_x = 64) in;

void main() {
    uint index = LINEAR_INVOCATION;
    if (index > push.params.params.item_count) return;
    uint count = 0u;
    if (index < push.params.params.item_count) {
        uint first;
        if ((bucket_flags(index, first) & CLUSTERS_BUCKET_CULLED) != 0u) {
            gpu_primitive primitive = push.scene.scene.primitives.at[push.scene.scene.items.at[index].primitive];
            if (push.visible_sums.at[index] != push.visible_sums.at[index + 1u]) count = primitive.cluster_count;
            else {
                bool hidden = push.params.params.hierarchy_width > 0u && push.hidden.at[index] != 0u;
                count_reason(hidden ? CLUSTERS_OCCLUDED : CLUSTERS_OUTSIDE, primitive.index_count / 3u);
            }
        }
    }
    push.cluster_sums.at[index] = count;
}
