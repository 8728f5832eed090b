#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The G-buffer of coarse shading: the default layout, what the criterion looks at, and a base colour for whole blocks. The
// variants are COARSE_IDS, COARSE_BOUNDS and neither. But for COARSE_IDS the alpha of the radiance target, which lighting overwrites, carries
// (|dz/dx| + |dz/dy|) / z of the view depth z; 0 for planes that face the viewer.
#include "common.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#include "material.glsl"
#include "decals_raster.glsl"
#include "gbuffer.glsl"
#include "passes/shade/hybrid_shared.h"

layout(push_constant, scalar) uniform push_block { gpu_gbuffer_push push; };

const float GRADIENT_NOISE = 1e-6; // what rounding makes of a plane that faces the viewer

layout(constant_id = GBUFFER_EXTRA_CONSTANT) const float LEVEL_BIAS = 1.0; // log2 of a block's side in pixels; < 0: no target for it

layout(location = 0) out vec4 out_radiance;
layout(location = 1) out vec4 out_color;
layout(location = 2) out vec4 out_normal;
layout(location = 3) out vec4 out_dielectric;
layout(location = 4) out vec4 out_geometric;
#ifdef COARSE_IDS
layout(location = 5) out uvec2 out_ids; // item + 1, triangle
layout(location = 6) out vec4 out_coarse_color;
#elif defined(COARSE_BOUNDS) // the normal in numbers of which ranges mean something
layout(location = 5) out float out_azimuth; // -pi .. pi round the y axis
layout(location = 6) out float out_height;  // its cosine with that axis
layout(location = 7) out vec4 out_coarse_color;
#else
layout(location = 5) out vec4 out_coarse_color;
#endif

// The base colour as a pixel of LEVEL_BIAS times the size sees it.
vec3 coarse_base_color(material_array materials, uint material) {
    gpu_texture t = materials.at[material].textures[TEXTURE_BASE_COLOR];
    vec3 color = (materials.at[material].base_color * in_color).rgb;
    if (t.image == GPU_TEXTURE_NONE) return color;
    return color * texture(sampler2D(textures[nonuniformEXT(t.image)], samplers[nonuniformEXT(t.sampler_index)]),
                           texture_uv(t, in_uv, 1.0), LEVEL_BIAS).rgb;
}

void main() {
    view_block v = push.geometry.view;
    material_array materials = push.geometry.scene.scene.materials;
    bool hole;
    surface s = material_surface(materials, in_ids.x, hole);
#ifndef COARSE_IDS
    float view_depth = -(v.view.world_to_view * vec4(in_position, 1.0)).z;
    float gradient = (abs(dFdxCoarse(view_depth)) + abs(dFdyCoarse(view_depth))) / max(view_depth, 1e-30);
#endif
    vec3 coarse_color = vec3(0.0), plain = s.base_color;
    if (LEVEL_BIAS >= 0.0) coarse_color = coarse_base_color(materials, in_ids.x);
    decals_on_gbuffer(s, v, push.geometry.scene);
    // What decals and unlit materials make of the colour holds for blocks too.
    if (s.base_color != plain || (materials.at[in_ids.x].flags & GPU_MATERIAL_UNLIT) != 0u) coarse_color = s.base_color;
    if (hole) discard;
    gpu_material_entry entry;
    gbuffer_place place; // octahedral normals need none
    const uint FORM = GBUFFER_FORM(GBUFFER_DEFAULT, NORMALS_OCTAHEDRAL) | GBUFFER_FORM_GEOMETRIC;
    gbuffer g = gbuffer_pack(FORM, s, place, 0u, entry, vec3(0.0), ivec2(gl_FragCoord.xy));
    out_radiance = vec4(min(s.emissive, vec3(v.view.frame.frame.hdr_max)), 1.0);
    out_color = g.targets[0];
    out_normal = g.targets[1];
    out_dielectric = g.targets[2];
    out_geometric = g.targets[3];
    if (LEVEL_BIAS >= 0.0) out_coarse_color = vec4(gbuffer_encode_color(coarse_color), 1.0);
#ifdef COARSE_IDS
    out_ids = uvec2(in_ids.y + 1u, uint(gl_PrimitiveID));
#else
    out_radiance.a = gradient > GRADIENT_NOISE ? gradient : 0.0;
#endif
#ifdef COARSE_BOUNDS
    out_azimuth = dot(s.normal.xz, s.normal.xz) > 0.0 ? atan(s.normal.z, s.normal.x) : 0.0;
    out_height = s.normal.y;
#endif
}
