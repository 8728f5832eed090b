#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Metalness of the first surface of each pixel, and the diffuse colour that it leaves.
#include "common.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#include "material.glsl"
#include "decals_raster.glsl"
#include "passes/geometry/geometry_shared.h"

layout(push_constant, scalar) uniform push_block { gpu_geometry_push push; };

layout(location = 0) out vec2 out_metal; // metalness, luminance of the diffuse colour

void main() {
    material_array materials = push.scene.scene.materials;
    bool hole;
    surface s = material_surface(materials, in_ids.x, hole);
    decals_on_surface(s, push.view, push.scene);
    if (hole) discard;
    out_metal = vec2(s.metallic, luminance(s.base_color) * (1.0 - s.metallic));
}
