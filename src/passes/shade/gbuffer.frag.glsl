#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The G-buffer pass: material into targets, emission straight into the radiance target.
#include "common.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#include "gbuffer.glsl"
#define MATERIAL_LAYERS (GBUFFER_FORM_LAYOUT(GBUFFER_GIVEN) == GBUFFER_LAYERS)
#include "material.glsl"
#include "decals_raster.glsl"
#include "passes/shade/hybrid_shared.h"

layout(push_constant, scalar) uniform push_block { gpu_gbuffer_push push; };
#ifdef LAYERED
layout(location = 8) flat in uint in_layer;
#undef DRAWN_VIEW
#define DRAWN_VIEW(first) view_at(first, in_layer)
#endif
#define VIEW DRAWN_VIEW(push.geometry.view)

layout(location = 0) out vec4 out_radiance;
layout(location = 1) out vec4 out_0; // the targets, then the mask if there is one
layout(location = 2) out vec4 out_1;
layout(location = 3) out vec4 out_2;
layout(location = 4) out vec4 out_3;
layout(location = 5) out vec4 out_4;
layout(location = 6) out vec4 out_5;

// 1: depth is complete, and what is left of a fragment is no hole (forward.frag.glsl tells more).
layout(constant_id = HOLES_ARE_CUT_ID) const uint HOLES_ARE_CUT = 0u;

void main() {
    material_array materials = push.geometry.scene.scene.materials;
    bool hole;
    surface s = material_surface(materials, in_ids.x, hole);
    decals_on_gbuffer(s, VIEW, push.geometry.scene);
    if (HOLES_ARE_CUT == 0u && hole) discard;
    uint form = GBUFFER_GIVEN, count = gbuffer_target_count(form);
    bool is_forward = (materials.at[in_ids.x].forward_layouts >> GBUFFER_FORM_LAYOUT(form) & 1u) != 0u;
    if ((FEATURES & GPU_FEATURE_LIGHT_MASKS) != 0u) is_forward = is_forward || item_light_mask(push.geometry.scene, in_ids.y) != LIGHT_MASK_ALL;
    uint id = is_forward ? 0u : in_ids.x;
    gpu_material_entry entry;
    if (gbuffer_has_id(form)) entry = push.entries.at[id];
    // As readers see it: from depth, at the pixel's middle.
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 position = gbuffer_position(VIEW, pixel, view_depth_of(VIEW, gl_FragCoord.z));
    gbuffer g = gbuffer_pack(form, s, gbuffer_place_at(VIEW, position), id, entry, vec3(0.0), pixel);
    vec4 mask = vec4(is_forward ? gbuffer_mask_of(in_ids.y) : 0.0);
    out_radiance = vec4(min(s.emissive, vec3(VIEW.view.frame.frame.hdr_max)), 1.0);
    out_0 = g.targets[0];
    out_1 = g.targets[1];
    out_2 = count == 2u ? mask : g.targets[2];
    out_3 = count == 3u ? mask : g.targets[3];
    out_4 = count == 4u ? mask : g.targets[4];
    out_5 = mask;
}
