#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The G-buffer pass: material into targets, emission straight into the radiance target.
#include "common.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#include "material.glsl"
#include "gbuffer.glsl"
#include "passes/geometry/geometry_shared.h"

layout(push_constant, scalar) uniform push_block { gpu_geometry_push push; };

layout(location = 0) out vec4 out_radiance;
layout(location = 1) out vec4 out_0;
layout(location = 2) out vec4 out_1;
layout(location = 3) out vec4 out_2;

void main() {
    material_array materials = push.scene.scene.materials;
    surface s = material_surface(materials, in_ids.x);
    if (material_cut(materials, in_ids.x, material_base_color(materials, in_ids.x).a)) discard;
    gbuffer g = gbuffer_pack(s);
    out_radiance = vec4(min(s.emissive, vec3(push.view.view.hdr_max)), 1.0);
    out_0 = g.targets[0];
    out_1 = g.targets[1];
    out_2 = g.targets[2];
}
