#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Surfaces at the resolution of light. Blended ones take one texel in four and leave the others to what is behind.
#include "common.glsl"
#include "material.glsl"
#include "decals_raster.glsl"
#include "passes/shade/light_prepass.glsl"
#include "passes/shade/inferred_shared.h"

layout(constant_id = STIPPLED_ID) const uint STIPPLED = 0u;

layout(push_constant, scalar) uniform push_block { gpu_geometry_push push; };

layout(location = 0) out vec4 out_normal;
layout(location = 1) out uint out_item;
layout(location = 2) out vec4 out_geometric; // where there is such a target

void main() {
    material_array materials = push.scene.scene.materials;
    bool hole;
    surface s = material_surface(materials, in_ids.x, hole);
    decals_on_surface(s, push.view, push.scene);
    if (material_culled(materials, in_ids.x) || hole) discard;
    uvec2 texel = uvec2(gl_FragCoord.xy);
    if (STIPPLED == 1u && ((texel.y & 1u) * 2u + (texel.x & 1u)) != INFERRED_PLACE(in_ids.y)) discard;
    vec4 reflectance;
    out_normal = light_surface_pack(s, reflectance);
    out_geometric = vec4(geometric_encode(s), 0.0, 0.0);
    out_item = in_ids.y + 1u;
}
