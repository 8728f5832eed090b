#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The one vertex shader: pulls the vertex of an item by address. Depth passes and shading passes use it alike, so that depths are
// equal to the bit.
#include "common.glsl"
#include "scene.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#include "passes/geometry/geometry_shared.h"

layout(push_constant, scalar) uniform push_block { gpu_geometry_push push; };

layout(location = 0) centroid out vec3 out_position;
layout(location = 1) centroid out vec3 out_normal;
layout(location = 2) centroid out vec4 out_tangent;
layout(location = 3) centroid out vec4 out_uv; // uv0, uv1
layout(location = 4) centroid out vec4 out_color;
layout(location = 5) flat out uvec3 out_ids; // material, item, 1 when the instance mirrors
layout(location = 6) flat out uint out_corner; // tells triangles of an item apart
layout(location = 7) centroid out vec3 out_bind; // position before the mesh deforms, in its own space

layout(constant_id = 31) const uint FEATURES = 0u; // GPU_FEATURE_…

invariant gl_Position;

vec3 unit(vec3 v) { return v * inversesqrt(max(dot(v, v), 1e-37)); }

void main() {
    uint item_index = push.visible.at[gl_InstanceIndex];
    gpu_item item = push.scene.scene.items.at[item_index];
    gpu_instance instance = push.scene.scene.instances.at[item.instance];
    gpu_attributes a = push.scene.scene.attributes.at[gl_VertexIndex];

    precise vec3 position = transform_point(instance, push.scene.scene.positions.at[gl_VertexIndex]);
    precise vec4 clip = push.view.view.world_to_clip * vec4(position, 1.0);
    gl_Position = clip;
    gl_PointSize = 1.0;
    out_corner = uint(gl_VertexIndex);

    float mirror;
    out_position = position;
    // Unit vectors, so that a scaled instance keeps the proportions of its tangent space.
    out_normal = unit(transform_normal(instance, unpack_normal(a.normal), mirror));
    vec4 tangent = unpack_tangent(a.tangent);
    out_tangent = vec4(unit(transform_direction(instance, tangent.xyz)), tangent.w * mirror);
    out_uv = vec4(a.uv0, a.uv1);
    out_color = vec4(unpackUnorm2x16(a.color.x), unpackUnorm2x16(a.color.y));
    gpu_primitive primitive = push.scene.scene.primitives.at[item.primitive];
    out_bind = vec3(0.0);
    if ((FEATURES & GPU_FEATURE_MESH_DECALS) != 0u)
        out_bind = push.scene.scene.positions.at[gl_VertexIndex + primitive.bind_offset];
    out_ids = uvec3(primitive.material, item_index, uint(mirror < 0.0 && primitive.corners == 3u));
}
