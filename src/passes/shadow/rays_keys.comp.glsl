#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Keys of all triangles. What deforms takes those of its vertices as they are modelled: its tree then stays good for any pose.
#include "common.glsl"
#include "passes/shadow/rays_build.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_ray_keys_push push; };

void main() {
    uint triangle = LINEAR_INVOCATION;
    if (triangle >= push.triangle_count) return;
    uint primitive = primitive_of(push.mesh_table, push.primitive_count, triangle);
    gpu_ray_mesh mesh = push.mesh_table.at[primitive];
    gpu_primitive p = push.scene.scene.primitives.at[primitive];
    vec3 sum = vec3(0.0);
    for (uint k = 0u; k < 3u; k++) {
        uint vertex = push.indices.at[p.first_index + 3u * (triangle - mesh.first) + k] + uint(p.vertex_offset + p.bind_offset);
        sum += push.scene.scene.positions.at[vertex];
    }
    uint code = morton_code((sum / 3.0 - mesh.low) * mesh.scale, push.shift / 3u);
    push.pairs.at[triangle * 2u] = (push.primitive_count > 1u ? primitive << push.shift : 0u) | code;
    push.pairs.at[triangle * 2u + 1u] = triangle;
}
