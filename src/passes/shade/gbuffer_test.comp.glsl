#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// For the test: sends surfaces through a layout and the rounding of its targets.
#include "common.glsl"
#include "view.glsl"
#include "gbuffer_layouts.glsl"

layout(buffer_reference) buffer case_array;

#include "passes/shade/gbuffer_test_shared.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer case_array { gpu_gbuffer_case at[]; };

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_gbuffer_test_push push; };

vec3 srgb_decode(vec3 c) { return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), greaterThan(c, vec3(0.04045))); }

vec4 rounded(vec4 v, uint format) {
    if (format == ROUND_FLOAT) return v;
    if (format == ROUND_HALF) return vec4(unpackHalf2x16(packHalf2x16(v.xy)), unpackHalf2x16(packHalf2x16(v.zw)));
    v = clamp(v, 0.0, 1.0);
    vec4 most = format == ROUND_UNORM16 ? vec4(65535.0) : format == ROUND_UNORM10 ? vec4(1023.0, 1023.0, 1023.0, 3.0) : vec4(255.0);
    if (format == ROUND_SRGB8) return vec4(srgb_decode(round(srgb_encode(v.rgb) * 255.0) / 255.0), round(v.a * 255.0) / 255.0);
    return round(v * most) / most;
}

void main() {
    uint index = LINEAR_INVOCATION;
    if (index >= push.count) return;
    gpu_gbuffer_case c = push.cases.at[index];
    surface s;
    s.position = vec3(0.0);
    s.normal = s.geometric = c.normal;
    s.base_color = c.base_color;
    s.alpha = 1.0;
    s.metallic = c.metallic;
    s.roughness = c.roughness;
    s.occlusion = c.occlusion;
    s.emissive = vec3(0.0);
    s.dielectric_f0 = c.dielectric_f0;
    s.dielectric_f90 = c.dielectric_f90;
    s.layered = c.coat > 0.0 || c.anisotropy > 0.0;
    s.layers.clearcoat_normal = c.coat_normal;
    s.layers.clearcoat = c.coat;
    s.layers.clearcoat_roughness = c.coat_roughness;
    s.layers.tangent = c.tangent;
    s.layers.anisotropy = c.anisotropy;
    gbuffer_place at = gbuffer_place(normalize(-c.position), mat3(1.0), c.position);
    gpu_material_entry entry = push.entries.at[c.id];
    gbuffer g = gbuffer_pack(push.form, s, at, c.id, entry, c.motion, ivec2(index & 1u, 0));
    for (uint i = 0u; i < GBUFFER_TARGETS; i++) g.targets[i] = rounded(g.targets[i], push.formats >> 4u * i & 15u);
    s = gbuffer_unpack(push.form, g, at, entry, vec3(0.0), vec3(0.0));
    uint layout_kind = GBUFFER_FORM_LAYOUT(push.form);
    gpu_gbuffer_case r;
    r.normal = s.normal;
    r.roughness = s.roughness;
    r.base_color = s.base_color;
    if ((push.form & GBUFFER_FORM_CHROMA) != 0u)
        r.base_color = clamp(gbuffer_from_luma(gbuffer_to_luma(srgb_encode(c.base_color))), 0.0, 1.0);
    r.metallic = s.metallic;
    r.dielectric_f0 = s.dielectric_f0;
    r.dielectric_f90 = s.dielectric_f90;
    r.motion = gbuffer_unpack_motion_of(push.form, g);
    r.occlusion = s.occlusion;
    r.position = layout_kind == GBUFFER_STALKER ? g.targets[0].xyz : layout_kind == GBUFFER_CLEAR_SKY ? vec3(0.0, 0.0, -g.targets[0].z) : c.position;
    r.id = gbuffer_unpack_material(push.form, g);
    r.coat = r.anisotropy = r.coat_roughness = 0.0;
    r.coat_normal = r.tangent = vec3(0.0);
    if (s.layered) {
        r.coat_normal = s.layers.clearcoat_normal;
        r.coat = s.layers.clearcoat;
        r.coat_roughness = s.layers.clearcoat_roughness;
        r.tangent = s.layers.tangent;
        r.anisotropy = s.layers.anisotropy;
    }
    push.results.at[index] = r;
}
