#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Vertices for ids with weights: what cutouts and ids need, no more. Depth is that of geometry.vert.glsl, to the bit.
#include "common.glsl"
#include "scene.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#include "passes/geometry/geometry_shared.h"

layout(push_constant, scalar) uniform push_block { gpu_geometry_push push; };

layout(location = 3) centroid out vec4 out_uv;
layout(location = 4) centroid out vec4 out_color;
layout(location = 5) flat out uvec3 out_ids; // material, item, 0
layout(location = 8) out vec2 out_weights;   // lines and points: none, shading finds them

invariant gl_Position;

void main() {
    uint item_index = push.visible.at[gl_InstanceIndex];
    gpu_item item = push.scene.scene.items.at[item_index];
    gpu_instance instance = push.scene.scene.instances.at[item.instance];
    gpu_attributes a = push.scene.scene.attributes.at[gl_VertexIndex];
    precise vec3 position = transform_point(instance, push.scene.scene.positions.at[gl_VertexIndex]);
    precise vec4 clip = push.view.view.world_to_clip * vec4(position, 1.0);
    gl_Position = clip;
    gl_PointSize = 1.0;
    out_uv = vec4(a.uv0, a.uv1);
    out_color = vec4(unpackUnorm2x16(a.color.x), unpackUnorm2x16(a.color.y));
    out_ids = uvec3(push.scene.scene.primitives.at[item.primitive].material, item_index, 0u);
    out_weights = vec2(-2.0);
}
