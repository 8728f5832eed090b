#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The box round the triangles of each primitive: what is known of it, or where it deforms the box of its vertices as they are.
#include "common.glsl"
#include "passes/shadow/rays_build.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_ray_primitives_push push; };

shared vec3 lows[64], highs[64];

void main() {
    uint index = LINEAR_GROUP, thread = gl_LocalInvocationIndex;
    if (index >= push.primitive_count) return; // the whole group
    gpu_primitive p = push.scene.scene.primitives.at[index];
    vec3 low = vec3(RAY_FAR), high = vec3(-RAY_FAR);
    if (p.corners == 3u && p.bind_offset == 0 && p.index_count > 0u) {
        low = p.center - p.half_extent;
        high = p.center + p.half_extent;
    } else if (p.corners == 3u) {
        for (uint i = thread; i < p.index_count; i += 64u) {
            vec3 position = push.scene.scene.positions.at[push.indices.at[p.first_index + i] + uint(p.vertex_offset)];
            low = min(low, position);
            high = max(high, position);
        }
    }
    lows[thread] = low;
    highs[thread] = high;
    for (uint step = 32u; step > 0u; step /= 2u) {
        barrier();
        if (thread < step) {
            lows[thread] = min(lows[thread], lows[thread + step]);
            highs[thread] = max(highs[thread], highs[thread + step]);
        }
    }
    if (thread == 0u) push.boxes.at[index] = ray_box_widened(lows[0], highs[0]);
}
