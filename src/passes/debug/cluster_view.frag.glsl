#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// A number for the cluster of triangles that a pixel shows, 1 for what is not cut into clusters; or with TRIANGLES for the
// triangle, 1 for points and lines.
#include "common.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#include "material.glsl"
#include "passes/geometry/geometry_shared.h"

layout(early_fragment_tests) in;
layout(constant_id = FEATURES_ID) const uint FEATURES = 0u; // GPU_FEATURE_…
layout(push_constant, scalar) uniform push_block { gpu_geometry_push push; };

#include "passes/geometry/triangle_number.glsl"

uint number(uint first) { return (first * 0x9e3779b9u ^ in_ids.y * 0x85ebca6bu) | 2u; }

uint find_number() {
#ifdef TRIANGLES
    return in_ids.z == 2u ? 1u : number(triangle_number());
#else
    gpu_primitive primitive = push.scene.scene.primitives.at[push.scene.scene.items.at[in_ids.y].primitive];
    uint low = 0u, high = primitive.cluster_count, triangle = triangle_number();
    while (high - low > 1u && high > 0u) {
        uint middle = (low + high) / 2u;
        if (push.scene.scene.clusters.at[primitive.first_cluster + middle].first_triangle <= triangle) low = middle;
        else high = middle;
    }
    return primitive.cluster_count > 0u ? number(primitive.first_cluster + low) : 1u;
#endif
}

void main() {
    uint hash = find_number();
    uvec2 pixel = uvec2(gl_FragCoord.xy);
    atomicMax(push.counters.at[pixel.y * push.view.view.size.x + pixel.x], hash); // of surfaces at equal depth always the same one
}
