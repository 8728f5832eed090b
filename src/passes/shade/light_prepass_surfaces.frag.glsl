#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The first pass over the geometry: what the lights need to know of it.
#include "common.glsl"
#include "material.glsl"
#include "decals_raster.glsl"
#include "passes/shade/light_prepass.glsl"

layout(constant_id = SURFACE_HOLES_ARE_CUT_ID) const uint HOLES_ARE_CUT = 0u; // by a prepass with several samples a pixel: see gbuffer.frag.glsl

layout(push_constant, scalar) uniform push_block { gpu_geometry_push push; };

layout(location = 0) out vec4 out_normal;
layout(location = 1) out vec4 out_1; // reflectance, or the geometric normal without reflectance
layout(location = 2) out vec4 out_2;

void main() {
    material_array materials = push.scene.scene.materials;
    bool hole;
    surface s = material_surface(materials, in_ids.x, hole);
    decals_on_surface(s, push.view, push.scene);
    if (HOLES_ARE_CUT == 0u && hole) discard;
    vec4 reflectance, geometric = vec4(geometric_encode(s), 0.0, 0.0);
    out_normal = light_surface_pack(s, reflectance);
    out_1 = LIGHT_BUFFER == LIGHT_BUFFER_TWO ? reflectance : geometric;
    out_2 = geometric;
}
