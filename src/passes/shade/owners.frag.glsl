#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Notes the item that a pixel shows, and a corner of its triangle: two triangles of one item may lie in one plane too.
#include "common.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#include "material.glsl"
#include "passes/geometry/geometry_shared.h"

layout(early_fragment_tests) in;
layout(push_constant, scalar) uniform push_block { gpu_geometry_push push; };
layout(location = 6) flat in uint in_corner;
layout(location = 0) out uvec2 out_item;

void main() {
    material_array materials = push.scene.scene.materials;
    if (material_culled(materials, in_ids.x) || material_cut(materials, in_ids.x, material_base_color(materials, in_ids.x).a)) discard;
    out_item = uvec2(in_ids.y, in_corner);
}
