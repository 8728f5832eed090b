#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The nearest surface of a few pixels, with all that shading needs to know of it. With INSPECT_LAYERS its layers.
#include "common.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#ifdef INSPECT_LAYERS
#define MATERIAL_LAYERS true
#endif
#include "material.glsl"
#include "decals_raster.glsl"
#include "passes/geometry/geometry_shared.h"
#include "passes/debug/inspect.glsl"

layout(push_constant, scalar) uniform push_block { gpu_geometry_push push; };

#ifdef INSPECT_LAYERS
layout(location = 0) out vec4 out_layers[SURFACE_LAYERS_VECTORS];
#else
layout(location = 0) out vec4 out_position;   // item + 1
layout(location = 1) out vec4 out_normal;     // view depth
layout(location = 2) out vec4 out_base_color; // roughness
layout(location = 3) out vec4 out_f0;         // f90
layout(location = 4) out vec4 out_emissive;   // metallic
layout(location = 5) out vec4 out_rest;       // occlusion, flags, light mask
layout(location = 6) out vec4 out_geometric;
#endif

void main() {
    material_array materials = push.scene.scene.materials;
    bool hole;
    surface s = material_surface(materials, in_ids.x, hole);
    decals_on_surface(s, push.view, push.scene);
    if (hole) discard;
    uint flags = materials.at[in_ids.x].flags;
#ifdef INSPECT_LAYERS
    for (int i = 0; i < SURFACE_LAYERS_VECTORS; i++) out_layers[i] = vec4(0.0);
    if (s.layered) out_layers = layers_pack(s.layers);
#else
    out_position = vec4(s.position, float(in_ids.y + 1u));
    out_geometric = vec4(s.geometric, 0.0);
    out_normal = vec4(s.normal, view_depth_of(push.view, gl_FragCoord.z));
    out_base_color = vec4(s.base_color, s.roughness);
    out_f0 = vec4(s.dielectric_f0, s.dielectric_f90);
    out_emissive = vec4(s.emissive, s.metallic);
    uint told = ((flags & GPU_MATERIAL_LAYERED) != 0u ? INSPECT_LAYERED : 0u) | ((flags & GPU_MATERIAL_UNLIT) != 0u ? INSPECT_UNLIT : 0u);
    out_rest = vec4(s.occlusion, float(told), float(item_light_mask(push.scene, in_ids.y)), 0.0);
#endif
}
