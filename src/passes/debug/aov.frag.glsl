#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// What the camera sees, as numbers: the first surface of each pixel at full precision.
#include "common.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#include "material.glsl"
#include "decals_raster.glsl"
#include "passes/geometry/geometry_shared.h"

layout(push_constant, scalar) uniform push_block { gpu_geometry_push push; };

layout(location = 0) out vec4 out_albedo;   // base colour, roughness
layout(location = 1) out vec4 out_normal;   // world space normal, view depth
layout(location = 2) out vec4 out_position; // world space position, item id + 1

void main() {
    material_array materials = push.scene.scene.materials;
    surface s = material_surface(materials, in_ids.x);
    decals_on_surface(s, push.view, push.scene);
    vec4 base = material_base_color(materials, in_ids.x);
    if (material_cut(materials, in_ids.x, base.a)) discard;
    bool unlit = (materials.at[in_ids.x].flags & GPU_MATERIAL_UNLIT) != 0u; // then the surface is black
    out_albedo = vec4(unlit ? base.rgb : s.base_color, s.roughness);
    out_normal = vec4(s.normal, view_depth_of(push.view, gl_FragCoord.z));
    out_position = vec4(s.position, float(in_ids.y + 1u));
}
