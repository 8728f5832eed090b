#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Depth of cutouts: only the holes matter. CASTERS: of what casts shadows; clear glass is a hole there.
#include "common.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#include "material.glsl"
#include "passes/geometry/geometry_shared.h"

layout(push_constant, scalar) uniform push_block { gpu_geometry_push push; };

void main() {
    material_array materials = push.scene.scene.materials;
    if (material_cut(materials, in_ids.x, material_base_color(materials, in_ids.x).a)) discard;
#ifdef CASTERS
    if (material_clear(materials, in_ids.x)) discard;
#endif
}
