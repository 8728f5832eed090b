#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Vertices of touched triangles where geometry.vert.glsl has them, to the bit: their depths are tested for equality.
#include "common.glsl"
#include "scene.glsl"
#include "decals.glsl"
#include "passes/decals/redraw.glsl"

layout(location = 0) centroid out vec4 out_position; // material.glsl says why four
layout(location = 1) centroid out vec3 out_normal;
layout(location = 2) centroid out vec3 out_bind;
layout(location = 3) flat out uint out_decal;
layout(location = 4) flat out float out_mirror; // -1: the instance is mirrored
layout(location = 5) flat out uint out_light_mask;

invariant gl_Position;

void main() {
    gpu_redraw draw = push.table.at[gl_InstanceIndex];
    gpu_instance instance = push.scene.scene.instances.at[draw.instance];
    gpu_primitive primitive = push.scene.scene.primitives.at[draw.primitive];
    int vertex = gl_VertexIndex + primitive.vertex_offset;
    precise vec3 position = transform_point(instance, push.scene.scene.positions.at[vertex]);
    precise vec4 clip = push.view.view.world_to_clip * vec4(position, 1.0);
    gl_Position = clip;
    vec3 normal = transform_normal(instance, unpack_normal(push.scene.scene.attributes.at[vertex].normal), out_mirror);
    out_position = vec4(position, 1.0);
    out_normal = normal * inversesqrt(max(dot(normal, normal), 1e-37));
    out_bind = push.scene.scene.positions.at[vertex + primitive.bind_offset];
    out_decal = draw.decal;
    out_light_mask = draw.light_mask;
}
