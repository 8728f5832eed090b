#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Sizes the dispatches over clusters.
#include "passes/geometry/clusters.glsl"

layout(local_size_x = 1) in;

void main() {
    uint clusters = push.cluster_sums.at[push.params.params.item_count];
    uint slots = min(clusters, push.params.params.cluster_capacity);
    push.totals.totals.clusters = clusters;
    push.totals.totals.slots = slots;
    push.totals.totals.dispatch[0] = min(slots, 32768u);
    push.totals.totals.dispatch[1] = (slots + 32767u) / 32768u;
    push.totals.totals.dispatch[2] = 1u;
}
