#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// What decals ask of a visible surface and the G-buffer does not know: its receiver bits, the normal of its face, and that of its vertices.
#include "common.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#include "material.glsl"
#include "passes/geometry/geometry_shared.h"
#include "passes/decals/receivers.glsl"

layout(push_constant, scalar) uniform push_block { gpu_geometry_push push; };

layout(location = 0) out uvec2 out_receivers;

void main() {
    vec3 to_view = to_viewer(push.view, in_position), face = cross(dFdx(in_position), dFdy(in_position));
    float face2 = dot(face, face), length2 = dot(in_normal, in_normal);
    vec3 normal = length2 > 1e-30 && length2 < 1e30 ? in_normal * inversesqrt(length2) : vec3(0.0, 1.0, 0.0);
    if (dot(normal, to_view) < 0.0) normal = -normal;
    face = face2 > 1e-36 ? face * inversesqrt(face2) : normal;
    if (dot(face, to_view) < 0.0) face = -face;
    out_receivers = receivers_pack(push.scene.scene.items.at[in_ids.y].receivers & 255u, face, normal);
}
