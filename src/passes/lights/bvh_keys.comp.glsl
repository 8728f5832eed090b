#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Places of the lights in view along a Morton curve through the grid of clusters: what is near on the curve is near for the clusters.
#include "common.glsl"
#include "passes/lights/bvh.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_bvh_tree_push push; };

// The lower eight bits, two zeros between any two.
uint spread_bits(uint x) {
    x = (x | x << 8) & 0x00f00fu;
    x = (x | x << 4) & 0x0c30c3u;
    return (x | x << 2) & 0x249249u;
}

uint quantise(float part) { return part > 0.0 ? uint(min(part, 1.0) * 255.0) : 0u; } // 0 for NaN

void main() {
    uint index = LINEAR_INVOCATION;
    if (index >= push.count.at[0]) return;
    vec3 center = push.bounds.at[index].center;
    float depth = -center.z;
    float spread = push.view.view.orthographic > 0.5 ? 1.0 : max(depth, push.view.view.near_distance);
    vec2 ndc = (center.xy / spread - push.view.view.ndc_offset) / push.view.view.ndc_scale;
    gpu_light_list grid = push.list.list;
    float slice = depth > 0.0 ? (grid.linear == 1u ? depth : log2(depth)) * grid.slice_scale + grid.slice_bias : 0.0;
    uvec3 place = uvec3(quantise(ndc.x * 0.5 + 0.5), quantise(ndc.y * 0.5 + 0.5), quantise(slice / float(grid.slices)));
    push.pairs.at[index * 2u] = spread_bits(place.x) | spread_bits(place.y) << 1 | spread_bits(place.z) << 2;
    push.pairs.at[index * 2u + 1u] = index;
}
