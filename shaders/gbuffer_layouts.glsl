// SPDX-License-Identifier: MIT
// From a surface to the values of a G-buffer's targets and back. The targets' formats are in src/passes/shade/gbuffer_layouts.c; what is
// written here is what each holds, in the order of its channels.
//
//   default     0 square root of the base colour, 3 x 10; 1    (with chroma: Y', Cb or Cr, RG8)
//               1 normal, 2 x 16; roughness; metalness and occlusion, 8 + 8 bits
//               2 square root of the dielectric F0; F90
//   siege       0 normal, 3 x 10; 2 bits for the bias of indirect light
//               1 base colour; material ID
//               2 metalness; smoothness; occlusion ("cavity"); the aliased value
//               3 motion: x and y in 12 bits each, z in 8
//   killzone2   0 normal, 2 half floats in four bytes
//               1 motion x, y; smoothness ("specular power"); square root of F0 ("specular intensity")
//               2 base colour; occlusion
//   engel       the same, but for the normal's format
//   frostbite2  0 normal, 3 x 8; smoothness
//               1 base colour; strength of the specular part ("specular albedo")
//               2 occlusion ("sky visibility"); environment map; the parameter; material ID
//   stalker     0 position in view space, half floats; material ID
//               1 normal, half floats; occlusion
//               2 base colour; smoothness
//   clear-sky   0 normal, 2 half floats; view depth; material ID and occlusion, 8 + 7 bits of a half float
//               1 base colour; smoothness
//   destiny     0 base colour; occlusion
//               1 normal, 3 x 8, its length carries the smoothness; material ID
//   layers      0, 1, 2 as default
//               3 normal of the coat, octahedral, 2 x 16; roughness and strength of the coat
//               4 strength of the anisotropy; angle of its direction around the normal, 0 .. pi
//
// Emission goes to the radiance target, which is the light accumulation or irradiance that the published layouts have besides.
#ifndef GBUFFER_LAYOUTS_GLSL
#define GBUFFER_LAYOUTS_GLSL

#include "surface.glsl"
#include "normal_encodings.glsl"
#include "gbuffer_shared.h"

struct gbuffer {
    vec4 targets[GBUFFER_TARGETS];
};

// Where a surface is seen: what encodings of normals in the viewer's frame, and stored positions, need.
struct gbuffer_place {
    vec3 to_view;       // unit, world space
    mat3 world_to_view;
    vec3 view_position;
};

uint gbuffer_layout_targets(uint form) {
    const uint counts[GBUFFER_LAYOUTS] = uint[](3u, 4u, 3u, 3u, 3u, 2u, 3u, 2u, 5u);
    return counts[GBUFFER_FORM_LAYOUT(form)];
}
uint gbuffer_target_count(uint form) {
    uint count = gbuffer_layout_targets(form);
    if (GBUFFER_FORM_NORMALS(form) == NORMALS_FLOAT) count++;
    if ((form & GBUFFER_FORM_GEOMETRIC) != 0u && GBUFFER_FORM_LAYOUT(form) != GBUFFER_LAYERS) count++;
    return count;
}

// ---- normals ----

// surface.geometric in two components of 0 .. 1.
vec2 geometric_encode(surface s) { return octahedral_encode(geometric_unit(s)) * 0.5 + 0.5; }
vec3 geometric_decode(vec2 stored) { return octahedral_decode(stored * 2.0 - 1.0); }

vec3 gbuffer_encode_normal(uint kind, vec3 n, gbuffer_place at) {
    if (kind == NORMALS_OCTAHEDRAL) return vec3(octahedral_encode(n) * 0.5 + 0.5, 0.0);
    if (kind == NORMALS_XY) return vec3(normal_encode_xy(at.world_to_view * n), 0.0);
    if (kind == NORMALS_SPHERICAL) return vec3(normal_encode_spherical(n), 0.0);
    if (kind == NORMALS_SPHERE_MAP) return vec3(normal_encode_sphere_map(n), 0.0);
    if (kind == NORMALS_STEREOGRAPHIC) return vec3(clamp(normal_encode_stereographic(at.world_to_view * n), 0.0, 1.0), 0.0);
    if (kind == NORMALS_VIEW) return vec3(normal_encode_view(n, at.to_view), 0.0);
    if (kind == NORMALS_BEST_FIT) return normal_encode_best_fit(n);
    return normal_encode_xyz(n);
}

vec3 gbuffer_decode_normal(uint kind, vec3 e, gbuffer_place at) {
    if (kind == NORMALS_OCTAHEDRAL) return octahedral_decode(e.xy * 2.0 - 1.0);
    if (kind == NORMALS_XY) return transpose(at.world_to_view) * normal_decode_xy(e.xy);
    if (kind == NORMALS_SPHERICAL) return normal_decode_spherical(e.xy);
    if (kind == NORMALS_SPHERE_MAP) return normal_decode_sphere_map(e.xy);
    if (kind == NORMALS_STEREOGRAPHIC) return transpose(at.world_to_view) * normal_decode_stereographic(e.xy);
    if (kind == NORMALS_VIEW) return normal_decode_view(e.xy, at.to_view);
    if (kind == NORMALS_BEST_FIT) return normal_decode_best_fit(e);
    return normal_decode_xyz(e);
}

// Destiny's normal: a vector of length 1/2 + smoothness / 2 in 3 x 8 bits. Of the eight nearest codes that with the best direction is
// taken among those that keep the smoothness.
vec3 gbuffer_encode_smooth_normal(vec3 n, float smoothness) {
    vec3 v = n * (0.5 + 0.5 * smoothness), low = floor(v * 127.5 + 127.5), best = low;
    float best_cost = 1e9;
    for (uint i = 0u; i < 8u; i++) {
        vec3 code = min(low + vec3(uvec3(i, i >> 1, i >> 2) & 1u), vec3(255.0));
        vec3 off = (code - 127.5) / 127.5 - v;
        float along = abs(dot(off, n)), cost = dot(off, off) - along * along + (along > 0.7 / 255.0 ? 1.0 + along : 0.0);
        if (cost >= best_cost) continue;
        best_cost = cost;
        best = code;
    }
    return best / 255.0;
}
vec3 gbuffer_decode_smooth_normal(vec3 e, out float smoothness) {
    vec3 v = (e * 255.0 - 127.5) / 127.5; // never 0
    float along = length(v);
    smoothness = clamp(along * 2.0 - 1.0, 0.0, 1.0);
    return v / along;
}

// ---- several values in one ----

// Two in 8 bits each as one of 16 bits.
float gbuffer_join(float high, float low) {
    return (round(clamp(high, 0.0, 1.0) * 255.0) * 256.0 + round(clamp(low, 0.0, 1.0) * 255.0)) / 65535.0;
}
vec2 gbuffer_split(float joined) {
    uint bits = uint(round(joined * 65535.0));
    return vec2(bits >> 8, bits & 255u) / 255.0;
}

// One in 16 bits as two of 8.
vec2 gbuffer_bytes(float value) {
    uint bits = uint(round(clamp(value, 0.0, 1.0) * 65535.0));
    return vec2(bits >> 8, bits & 255u) / 255.0;
}
float gbuffer_unbytes(float high, float low) { return (round(high * 255.0) * 256.0 + round(low * 255.0)) / 65535.0; }

// 8 bits of ID and 7 of occlusion as a half float that is neither subnormal nor infinite (Lobanchikov and Gruen 2009).
float gbuffer_pack_id(uint id, float occlusion) {
    uint bits = (id & 255u) | uint(round(clamp(occlusion, 0.0, 1.0) * 127.0)) << 8;
    uint half_bits = bits >> 14 << 15 | ((bits >> 10 & 15u) + 1u) << 10 | (bits & 1023u);
    return unpackHalf2x16(half_bits).x;
}
uint gbuffer_unpack_id(float stored, out float occlusion) {
    uint half_bits = packHalf2x16(vec2(stored, 0.0)) & 0xffffu;
    uint bits = half_bits >> 15 << 14 | ((half_bits >> 10 & 31u) - 1u & 15u) << 10 | (half_bits & 1023u);
    occlusion = float(bits >> 8 & 127u) / 127.0;
    return bits & 255u;
}

// Motion of -1 .. 1 a component: x and y in 12 bits, z in 8.
vec4 gbuffer_pack_motion(vec3 motion) {
    uvec2 xy = uvec2(round(clamp(motion.xy * 0.5 + 0.5, 0.0, 1.0) * 4094.0)); // 0 is held exactly
    return vec4(vec3(xy.x >> 4, (xy.x & 15u) << 4 | xy.y >> 8, xy.y & 255u) / 255.0, round(clamp(motion.z * 0.5 + 0.5, 0.0, 1.0) * 254.0) / 255.0);
}
vec3 gbuffer_unpack_motion(vec4 stored) {
    uvec4 bytes = uvec4(round(stored * 255.0));
    return vec3(vec2(bytes.x << 4 | bytes.y >> 4, (bytes.y & 15u) << 8 | bytes.z) / 4094.0, float(bytes.w) / 254.0) * 2.0 - 1.0;
}

// ---- base colour of the default layout ----

// Its square root in 10 bits comes back within 0.14 % of a grey of 0.5. 8 bits of sRGB, which the published layouts have, turn 0.5 into 0.503.
// Rounded here, because drivers may not round to the nearest code (Mesa's CPU driver is off by up to a whole one).
vec3 gbuffer_encode_color(vec3 color) { return round(sqrt(clamp(color, 0.0, 1.0)) * 1023.0) * (1.0 / 1023.0); }
vec3 gbuffer_decode_color(vec3 stored) { return stored * stored; }

// ---- base colour as Y'CbCr (ITU-R BT.601, full range) ----

vec3 gbuffer_from_luma(vec3 ycc) { // codes 0 .. 255 to sRGB-encoded 0 .. 1
    vec2 c = ycc.yz - 128.0;
    return vec3(ycc.x + 1.402 * c.y, ycc.x - 0.344136 * c.x - 0.714136 * c.y, ycc.x + 1.772 * c.x) / 255.0;
}
// Of the roundings the one whose colour is nearest: single rounding may be off by two steps of blue.
vec3 gbuffer_to_luma(vec3 encoded) {
    vec3 rgb = encoded * 255.0, best = vec3(0.0);
    float y = dot(rgb, vec3(0.299, 0.587, 0.114)), best_error = 1e9;
    for (uint i = 0u; i < 8u; i++) {
        float luma = floor(y) + float(i & 1u);
        vec2 chroma = floor((rgb.br - luma) / vec2(1.772, 1.402) + 128.0) + vec2(uvec2(i >> 1, i >> 2) & 1u);
        vec3 code = clamp(vec3(luma, chroma), 0.0, 255.0);
        float error = max_component(abs(clamp(gbuffer_from_luma(code), 0.0, 1.0) * 255.0 - rgb));
        if (error >= best_error) continue;
        best_error = error;
        best = code;
    }
    return best;
}

// Which of Cb (0) and Cr (1) a pixel keeps.
uint gbuffer_chroma_of(ivec2 pixel) { return uint(pixel.x + pixel.y) & 1u; }

// ---- clearcoat and anisotropy ----

// A direction at right angles to a normal, to measure angles around it from; it jumps nowhere but at the poles of x.
vec3 gbuffer_around(vec3 n) { return abs(n.x) > 0.9 ? normalize(cross(n, vec3(0.0, 1.0, 0.0))) : normalize(cross(n, vec3(1.0, 0.0, 0.0))); }

// `normal`: as it is read again. Highlights are stretched both ways along a direction, so that half a turn holds all.
vec2 gbuffer_pack_anisotropy(surface_layers l, vec3 normal) {
    if (l.anisotropy <= 0.0) return vec2(0.0);
    vec3 zero = gbuffer_around(normal);
    float angle = atan(dot(l.tangent, cross(normal, zero)), dot(l.tangent, zero));
    return vec2(l.anisotropy, (angle < 0.0 ? angle + PI : angle) / PI);
}
vec3 gbuffer_unpack_tangent(float stored, vec3 normal) {
    vec3 zero = gbuffer_around(normal);
    return zero * cos(stored * PI) + cross(normal, zero) * sin(stored * PI);
}

// Nothing of what the layout has no room for.
surface_layers gbuffer_unpack_layers(vec4 coat, vec2 anisotropy, vec3 normal) {
    surface_layers l = no_layers();
    l.clearcoat_normal = octahedral_decode(coat.xy * 2.0 - 1.0);
    l.clearcoat_roughness = coat.z;
    l.clearcoat = coat.w;
    l.anisotropy = anisotropy.x;
    l.tangent = gbuffer_unpack_tangent(anisotropy.y, normal);
    return l;
}

// ---- surfaces ----

// `id`: the material's. Its entry is that of gpu_gbuffer.entries.
gbuffer gbuffer_pack(uint form, surface s, gbuffer_place at, uint id, gpu_material_entry entry, vec3 motion, ivec2 pixel) {
    gbuffer g;
    for (uint i = 0u; i < GBUFFER_TARGETS; i++) g.targets[i] = vec4(0.0);
    uint layout_kind = GBUFFER_FORM_LAYOUT(form), normals = GBUFFER_FORM_NORMALS(form);
    vec3 e = normals == NORMALS_FLOAT ? vec3(0.0) : gbuffer_encode_normal(normals, s.normal, at), signed_e = e * 2.0 - 1.0;
    float smoothness = 1.0 - s.roughness, id8 = float(id & 255u) / 255.0;
    vec2 smooth_bytes = gbuffer_bytes(smoothness);
    vec3 f0_root = sqrt(s.dielectric_f0);
    vec4 motion_bytes = gbuffer_pack_motion(motion);
    vec2 motion8 = round(clamp(motion.xy * 0.5 + 0.5, 0.0, 1.0) * 254.0) / 255.0;
    switch (layout_kind) {
    case GBUFFER_DEFAULT:
    case GBUFFER_LAYERS:
        g.targets[0] = vec4(gbuffer_encode_color(s.base_color), 1.0);
        if ((form & GBUFFER_FORM_CHROMA) != 0u) {
            vec3 ycc = gbuffer_to_luma(srgb_encode(clamp(s.base_color, 0.0, 1.0))) / 255.0;
            g.targets[0] = vec4(ycc.x, gbuffer_chroma_of(pixel) == 0u ? ycc.y : ycc.z, 0.0, 1.0);
        }
        g.targets[1] = vec4(e.xy, s.roughness, gbuffer_join(s.metallic, s.occlusion));
        g.targets[2] = vec4(f0_root, s.dielectric_f90);
        if (layout_kind == GBUFFER_LAYERS && s.layered) {
            g.targets[3] = vec4(octahedral_encode(s.layers.clearcoat_normal) * 0.5 + 0.5, s.layers.clearcoat_roughness, s.layers.clearcoat);
            vec3 read = gbuffer_decode_normal(normals, round(e * 65535.0) / 65535.0, at);
            g.targets[4] = vec4(gbuffer_pack_anisotropy(s.layers, read), 0.0, 0.0);
        }
        break;
    case GBUFFER_SIEGE:
        g.targets[0] = vec4(e, 0.0);
        g.targets[1] = vec4(s.base_color, id8);
        g.targets[2] = vec4(s.metallic, smoothness, s.occlusion, s.dielectric_f90);
        if ((entry.second & GBUFFER_SECOND_STRENGTH) == 0u) g.targets[2].yw = smooth_bytes;
        g.targets[3] = motion_bytes;
        break;
    case GBUFFER_KILLZONE2:
    case GBUFFER_ENGEL:
        g.targets[0] = layout_kind == GBUFFER_ENGEL ? vec4(signed_e.xy, 0.0, 0.0) : unpackUnorm4x8(packHalf2x16(signed_e.xy));
        g.targets[1] = vec4(motion8, smoothness, f0_root.x);
        g.targets[2] = vec4(s.base_color, s.occlusion);
        break;
    case GBUFFER_FROSTBITE2:
        g.targets[0] = vec4(e, smoothness);
        g.targets[1] = vec4(s.base_color, s.dielectric_f90);
        g.targets[2] = vec4(s.occlusion, 0.0, s.metallic, id8);
        if ((entry.second & GBUFFER_SECOND_METALLIC) == 0u) {
            g.targets[0].a = smooth_bytes.x;
            g.targets[2].z = smooth_bytes.y;
        }
        break;
    case GBUFFER_STALKER:
        g.targets[0] = vec4(clamp(at.view_position, -HALF_MAX, HALF_MAX), float(id));
        g.targets[1] = vec4(signed_e, s.occlusion);
        g.targets[2] = vec4(s.base_color, smoothness);
        break;
    case GBUFFER_CLEAR_SKY:
        g.targets[0] = vec4(signed_e.xy, min(-at.view_position.z, HALF_MAX), gbuffer_pack_id(id, s.occlusion));
        g.targets[1] = vec4(s.base_color, smoothness);
        break;
    case GBUFFER_DESTINY:
        g.targets[0] = vec4(s.base_color, s.occlusion);
        g.targets[1] = vec4(gbuffer_encode_smooth_normal(s.normal, smoothness), id8);
        break;
    }
    if (normals == NORMALS_FLOAT) g.targets[gbuffer_layout_targets(form)] = vec4(s.normal, 0.0);
    if ((form & GBUFFER_FORM_GEOMETRIC) != 0u) {
        uint last = gbuffer_target_count(form) - 1u;
        if (layout_kind == GBUFFER_LAYERS) g.targets[last].zw = geometric_encode(s);
        else g.targets[last].xy = geometric_encode(s);
    }
    return g;
}

// The code of the normal, 0 .. 1 a component, from the target that holds it.
uint gbuffer_normal_target(uint form) {
    if (GBUFFER_FORM_NORMALS(form) == NORMALS_FLOAT) return gbuffer_layout_targets(form);
    const uint SECOND = 1u << GBUFFER_DEFAULT | 1u << GBUFFER_STALKER | 1u << GBUFFER_DESTINY | 1u << GBUFFER_LAYERS; // of these layouts target 1, else target 0
    return SECOND >> GBUFFER_FORM_LAYOUT(form) & 1u;
}
vec3 gbuffer_unpack_normal(uint form, vec4 stored, gbuffer_place at) {
    uint layout_kind = GBUFFER_FORM_LAYOUT(form), normals = GBUFFER_FORM_NORMALS(form);
    if (normals == NORMALS_FLOAT) return stored.xyz;
    if (layout_kind == GBUFFER_DESTINY) {
        float smoothness;
        return gbuffer_decode_smooth_normal(stored.xyz, smoothness);
    }
    vec3 e = stored.xyz;
    if (layout_kind == GBUFFER_KILLZONE2) e = vec3(unpackHalf2x16(packUnorm4x8(stored)), 0.0);
    if (layout_kind == GBUFFER_KILLZONE2 || layout_kind == GBUFFER_ENGEL || layout_kind == GBUFFER_STALKER || layout_kind == GBUFFER_CLEAR_SKY)
        e = e * 0.5 + 0.5;
    return gbuffer_decode_normal(normals, e, at);
}
// Whether that takes gbuffer_place.
bool gbuffer_normal_is_placed(uint form) {
    uint normals = GBUFFER_FORM_NORMALS(form);
    return normals == NORMALS_XY || normals == NORMALS_VIEW || normals == NORMALS_STEREOGRAPHIC;
}

bool gbuffer_has_id(uint form) {
    uint layout_kind = GBUFFER_FORM_LAYOUT(form);
    return layout_kind == GBUFFER_SIEGE || layout_kind == GBUFFER_FROSTBITE2 || layout_kind == GBUFFER_STALKER ||
           layout_kind == GBUFFER_CLEAR_SKY || layout_kind == GBUFFER_DESTINY;
}
uint gbuffer_unpack_material(uint form, gbuffer g) {
    float occlusion;
    switch (GBUFFER_FORM_LAYOUT(form)) {
    case GBUFFER_SIEGE: return uint(round(g.targets[1].a * 255.0));
    case GBUFFER_FROSTBITE2: return uint(round(g.targets[2].a * 255.0));
    case GBUFFER_STALKER: return uint(g.targets[0].a);
    case GBUFFER_CLEAR_SKY: return gbuffer_unpack_id(g.targets[0].a, occlusion);
    case GBUFFER_DESTINY: return uint(round(g.targets[1].a * 255.0));
    }
    return 0u;
}

vec3 gbuffer_unpack_motion_of(uint form, gbuffer g) {
    uint layout_kind = GBUFFER_FORM_LAYOUT(form);
    if (layout_kind == GBUFFER_SIEGE) return gbuffer_unpack_motion(g.targets[3]);
    if (layout_kind == GBUFFER_KILLZONE2 || layout_kind == GBUFFER_ENGEL) return vec3(g.targets[1].xy * 255.0 / 127.0 - 1.0, 0.0);
    return vec3(0.0);
}

// Base colours kept as chroma are left to gbuffer_surface(), which sees the neighbours.
surface gbuffer_unpack(uint form, gbuffer g, gbuffer_place at, gpu_material_entry entry, vec3 position, vec3 emissive) {
    surface s;
    s.light_mask = LIGHT_MASK_ALL;
    s.layered = false;
    s.position = position;
    s.normal = gbuffer_unpack_normal(form, g.targets[gbuffer_normal_target(form)], at);
    s.geometric = vec3(0.0);
    if ((form & GBUFFER_FORM_GEOMETRIC) != 0u) {
        vec4 stored = g.targets[gbuffer_target_count(form) - 1u];
        s.geometric = geometric_decode(GBUFFER_FORM_LAYOUT(form) == GBUFFER_LAYERS ? stored.zw : stored.xy);
    }
    s.alpha = 1.0;
    s.emissive = emissive;
    s.base_color = g.targets[0].rgb;
    s.metallic = entry.metallic;
    s.roughness = 0.0;
    s.occlusion = 1.0;
    s.dielectric_f0 = entry.dielectric_f0;
    s.dielectric_f90 = entry.dielectric_f90;
    float smoothness = 0.0;
    switch (GBUFFER_FORM_LAYOUT(form)) {
    case GBUFFER_DEFAULT:
    case GBUFFER_LAYERS:
        s.base_color = gbuffer_decode_color(g.targets[0].rgb);
        vec2 parts = gbuffer_split(g.targets[1].w);
        s.metallic = parts.x;
        s.roughness = g.targets[1].z;
        s.occlusion = parts.y;
        s.dielectric_f0 = g.targets[2].rgb * g.targets[2].rgb;
        s.dielectric_f90 = g.targets[2].a;
        if (GBUFFER_FORM_LAYOUT(form) == GBUFFER_LAYERS && (g.targets[3].w > 0.0 || g.targets[4].x > 0.0)) {
            s.layered = true;
            s.layers = gbuffer_unpack_layers(g.targets[3], g.targets[4].xy, s.normal);
        }
        return s;
    case GBUFFER_SIEGE:
        s.base_color = g.targets[1].rgb;
        s.metallic = g.targets[2].x;
        s.occlusion = g.targets[2].z;
        bool has_strength = (entry.second & GBUFFER_SECOND_STRENGTH) != 0u;
        smoothness = has_strength ? g.targets[2].y : gbuffer_unbytes(g.targets[2].y, g.targets[2].w);
        if (has_strength) s.dielectric_f90 = g.targets[2].w;
        break;
    case GBUFFER_KILLZONE2:
    case GBUFFER_ENGEL:
        s.base_color = g.targets[2].rgb;
        s.metallic = 0.0;
        s.occlusion = g.targets[2].a;
        smoothness = g.targets[1].z;
        s.dielectric_f0 = vec3(g.targets[1].w * g.targets[1].w);
        s.dielectric_f90 = g.targets[1].w > 0.0 ? 1.0 : 0.0;
        s.roughness = 1.0 - smoothness;
        return s;
    case GBUFFER_FROSTBITE2:
        s.base_color = g.targets[1].rgb;
        s.dielectric_f90 = g.targets[1].a;
        s.occlusion = g.targets[2].x;
        bool has_metal = (entry.second & GBUFFER_SECOND_METALLIC) != 0u;
        smoothness = has_metal ? g.targets[0].a : gbuffer_unbytes(g.targets[0].a, g.targets[2].z);
        if (has_metal) s.metallic = g.targets[2].z;
        break;
    case GBUFFER_STALKER:
        s.base_color = g.targets[2].rgb;
        smoothness = g.targets[2].a;
        s.occlusion = g.targets[1].a;
        break;
    case GBUFFER_CLEAR_SKY:
        s.base_color = g.targets[1].rgb;
        smoothness = g.targets[1].a;
        gbuffer_unpack_id(g.targets[0].a, s.occlusion);
        break;
    case GBUFFER_DESTINY:
        s.occlusion = g.targets[0].a;
        gbuffer_decode_smooth_normal(g.targets[1].xyz, smoothness);
        break;
    }
    s.roughness = 1.0 - smoothness;
    s.dielectric_f0 *= s.dielectric_f90;
    return s;
}

#endif
