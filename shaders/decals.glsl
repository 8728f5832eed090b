// SPDX-License-Identifier: MIT
// What decals make of a surface: one function for all ways of finding them, so that all give the same picture.
#ifndef DECALS_GLSL
#define DECALS_GLSL

#extension GL_EXT_buffer_reference_uvec2 : require

#include "common.glsl"
#include "surface.glsl"
#include "lights/iterate.glsl"

layout(buffer_reference) buffer decal_array;

#include "decals_shared.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer decal_array { gpu_decal at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer decal_block { gpu_decal_set set; };

decal_block decals_of(view_block v) { return decal_block(v.view.decals); }

// Where a surface is, and how that changes from pixel to pixel.
struct decal_point {
    vec3 position, dx, dy; // world space, metres a pixel to the right and down
    vec3 facing;           // world space, unit: the surface's normal without its maps, on the viewer's side
    uint receivers;
};

// A decal's place on a surface.
struct decal_place {
    vec2 uv, uv_dx, uv_dy; // on its picture; per pixel to the right and down
    float height;          // in its cube, -0.5 .. 0.5
    float cosine;          // between the surface's normal and the way the decal is seen from
    bool on_mesh;
};

vec3 decal_cube(decal_array decals, uint index, vec3 p) {
    precise vec3 q = vec3(dot(decals.at[index].rows[0].xyz, p) + decals.at[index].rows[0].w,
                          dot(decals.at[index].rows[1].xyz, p) + decals.at[index].rows[1].w,
                          dot(decals.at[index].rows[2].xyz, p) + decals.at[index].rows[2].w);
    return q;
}

vec3 decal_cube_direction(decal_array decals, uint index, vec3 d) {
    return vec3(dot(decals.at[index].rows[0].xyz, d), dot(decals.at[index].rows[1].xyz, d), dot(decals.at[index].rows[2].xyz, d));
}

vec2 decal_uv(vec3 q) { return vec2(q.x + 0.5, 0.5 - q.y); }
vec2 decal_uv_direction(decal_array decals, uint index, vec3 d) { return decal_cube_direction(decals, index, d).xy * vec2(1.0, -1.0); }

bool decal_holds(vec3 q) { return all(lessThanEqual(abs(q), vec3(0.5))); } // NaN: no

bool decal_meets(decal_array decals, uint index, uint receivers) {
    return (decals.at[index].flags >> GPU_DECAL_RECEIVERS_SHIFT & receivers) != 0u;
}

vec4 decal_texel(uint image, uint sampler_index, vec2 uv, vec2 dx, vec2 dy) {
    return textureGrad(sampler2D(textures[nonuniformEXT(image)], samplers[nonuniformEXT(sampler_index)]), uv, dx, dy);
}

// Of a stack of slices, between the two nearest; mips stop where a slice would be lost, and no texel is read across its rim.
vec4 decal_slices(uint image, uint sampler_index, decal_place p, float slices) {
    vec2 size = vec2(textureSize(sampler2D(textures[nonuniformEXT(image)], samplers[nonuniformEXT(sampler_index)]), 0));
    size.y /= slices;
    float lod = 0.5 * log2(max(max(dot(p.uv_dx * size, p.uv_dx * size), dot(p.uv_dy * size, p.uv_dy * size)), 1e-12));
    lod = clamp(lod, 0.0, max(floor(log2(size.y)) - 1.0, 0.0));
    vec2 rim = min(0.5 * exp2(ceil(lod)) / size, vec2(0.5));
    vec2 uv = clamp(p.uv, rim, 1.0 - rim);
    float z = clamp((0.5 - p.height) * slices - 0.5, 0.0, slices - 1.0), low = floor(z), high = min(low + 1.0, slices - 1.0);
    vec4 a = textureLod(sampler2D(textures[nonuniformEXT(image)], samplers[nonuniformEXT(sampler_index)]),
                        vec2(uv.x, (low + uv.y) / slices), lod);
    vec4 b = textureLod(sampler2D(textures[nonuniformEXT(image)], samplers[nonuniformEXT(sampler_index)]),
                        vec2(uv.x, (high + uv.y) / slices), lod);
    return mix(a, b, z - low);
}

// A base colour under a premultiplied one.
vec3 decal_blend(uint blend, vec3 base, vec3 color, float alpha) {
    vec3 rest = base * (1.0 - alpha);
    if (blend == GPU_DECAL_BLEND_MULTIPLY) return rest + base * color;
    if (blend == GPU_DECAL_BLEND_ADD) return min(base + color, vec3(1.0));
    if (blend == GPU_DECAL_BLEND_SCREEN) return base + color * (1.0 - base);
    if (blend == GPU_DECAL_BLEND_OVERLAY)
        return rest + mix(vec3(alpha) - 2.0 * (1.0 - base) * (vec3(alpha) - color), 2.0 * base * color, lessThan(base, vec3(0.5)));
    return rest + color;
}

// World space: where the right side and the top of the picture are.
void decal_sides(decal_array decals, uint index, decal_place place, decal_point p, out vec3 side, out vec3 up) {
    side = decals.at[index].side;
    up = decals.at[index].up;
    if (place.on_mesh) { // from how the picture lies on the surface
        float turn = place.uv_dx.x * place.uv_dy.y - place.uv_dy.x * place.uv_dx.y > 0.0 ? -1.0 : 1.0;
        side = (p.dy * place.uv_dx.y - p.dx * place.uv_dy.y) * turn;
        up = (p.dy * place.uv_dx.x - p.dx * place.uv_dy.x) * turn;
    }
}

// A mapped normal upon a surface's present one. The picture's directions lie in the plane of the surface without its maps, and turn with
// the normal by the least rotation (Barre-Brisebois and Hill 2012): unlike a projection that has no pole that steep layers could come near.
vec3 decal_bend(vec3 normal, vec3 mapped, vec3 side, vec3 up, vec3 facing) {
    vec3 t = side - facing * dot(facing, side);
    float t2 = dot(t, t);
    if (t2 < 1e-12) return normal;
    t *= inversesqrt(t2);
    t -= (normal + facing) * (dot(normal, t) / max(1.0 + dot(normal, facing), 1e-3));
    vec3 b = cross(normal, t);
    if (dot(cross(facing, side), up) < 0.0) b = -b; // a mirrored picture
    vec3 bent = mapped.x * t + mapped.y * b + mapped.z * normal;
    float length2 = dot(bent, bent);
    return length2 > 1e-12 ? bent * inversesqrt(length2) : normal;
}

// What a decal shows at a place, piece by piece: pieces that wait for each other would take registers.

// 0: nothing.
float decal_fade(decal_array decals, uint index, decal_place p) {
    if ((decals.at[index].flags & GPU_DECAL_VOLUME) != 0u) return 1.0;
    float fade = clamp(p.cosine * decals.at[index].fade_scale + decals.at[index].fade_offset, 0.0, 1.0);
    return fade * fade * (3.0 - 2.0 * fade);
}

vec4 decal_picture(decal_array decals, uint index, uint image, uint sampler_index, decal_place p) {
    if ((decals.at[index].flags & GPU_DECAL_VOLUME) != 0u) return decal_slices(image, sampler_index, p, decals.at[index].slices);
    return decal_texel(image, sampler_index, p.uv, p.uv_dx, p.uv_dy);
}

// Premultiplied, faded, cut.
vec4 decal_color(decal_array decals, uint index, uint sampler_index, decal_place p, float fade) {
    uint flags = decals.at[index].flags, image = decals.at[index].color_image;
    vec4 texel = vec4(1.0);
    if (image != GPU_DECAL_NO_IMAGE) {
        texel = decal_picture(decals, index, image, sampler_index, p);
        if ((flags & GPU_DECAL_FIELD) != 0u) {
            // As wide as the distance changes from pixel to pixel: the cut is as soft as an edge.
            float cut = decals.at[index].cut, width = 0.0;
            if ((flags & GPU_DECAL_VOLUME) == 0u)
                width = 0.5 * (abs(decal_texel(image, sampler_index, p.uv + p.uv_dx, p.uv_dx, p.uv_dy).a - texel.a) +
                               abs(decal_texel(image, sampler_index, p.uv + p.uv_dy, p.uv_dx, p.uv_dy).a - texel.a));
            width = max(width, 1.0 / 512.0);
            float inside = smoothstep(cut - width, cut + width, texel.a);
            texel = vec4(texel.rgb * inside, inside);
        }
    }
    vec4 factor = decals.at[index].color;
    return vec4(factor.rgb * factor.a, factor.a) * texel * fade; // both are premultiplied
}

// Roughness and metalness.
vec2 decal_roughness_metallic(decal_array decals, uint index, uint sampler_index, decal_place p) {
    vec2 result = vec2(decals.at[index].roughness, decals.at[index].metallic);
    uint image = decals.at[index].metallic_roughness_image;
    if (image != GPU_DECAL_NO_IMAGE && (decals.at[index].flags & (GPU_DECAL_ROUGHNESS | GPU_DECAL_METALLIC)) != 0u)
        result *= decal_picture(decals, index, image, sampler_index, p).gb;
    return result;
}

// With GPU_DECAL_EMISSION.
vec3 decal_emissive(decal_array decals, uint index, uint sampler_index, decal_place p) {
    vec3 emissive = decals.at[index].emissive;
    uint image = decals.at[index].emissive_image;
    return image != GPU_DECAL_NO_IMAGE ? emissive * decal_texel(image, sampler_index, p.uv, p.uv_dx, p.uv_dy).rgb : emissive;
}

// A surface's normal under the decal's; without GPU_DECAL_NORMAL as if its picture were flat.
vec3 decal_normal(decal_array decals, uint index, uint sampler_index, decal_place place, decal_point p, vec3 normal) {
    vec3 mapped = vec3(0.0, 0.0, 1.0), side, up;
    if ((decals.at[index].flags & GPU_DECAL_NORMAL) != 0u) {
        uint image = decals.at[index].normal_image;
        if (image != GPU_DECAL_NO_IMAGE) mapped = decal_texel(image, sampler_index, place.uv, place.uv_dx, place.uv_dy).xyz * 2.0 - 1.0;
        mapped.xy *= decals.at[index].normal_scale;
    }
    decal_sides(decals, index, place, p, side, up);
    return decal_bend(normal, mapped, side, up, p.facing);
}

void decal_apply(inout surface s, decal_array decals, uint index, uint sampler_index, decal_place place, decal_point p) {
    float fade = decal_fade(decals, index, place);
    if (fade <= 0.0) return;
    uint flags = decals.at[index].flags;
    vec4 color = decal_color(decals, index, sampler_index, place, fade);
    float alpha = color.a;
    if ((flags & GPU_DECAL_COLOR) != 0u) s.base_color = decal_blend(flags >> GPU_DECAL_BLEND_SHIFT & 15u, s.base_color, color.rgb, alpha);
    if ((flags & (GPU_DECAL_ROUGHNESS | GPU_DECAL_METALLIC)) != 0u) {
        vec2 look = decal_roughness_metallic(decals, index, sampler_index, place);
        if ((flags & GPU_DECAL_ROUGHNESS) != 0u) s.roughness = mix(s.roughness, look.x, alpha);
        if ((flags & GPU_DECAL_METALLIC) != 0u) s.metallic = mix(s.metallic, look.y, alpha);
    }
    if ((flags & GPU_DECAL_EMISSION) != 0u)
        s.emissive = mix(s.emissive, decal_emissive(decals, index, sampler_index, place), alpha);
    if ((flags & GPU_DECAL_NORMAL) != 0u) {
        vec3 bent = decal_normal(decals, index, sampler_index, place, p, (flags & GPU_DECAL_FLATTEN) != 0u ? p.facing : s.normal);
        vec3 mixed = mix(s.normal, bent, alpha);
        float length2 = dot(mixed, mixed);
        if (length2 > 1e-12) s.normal = mixed * inversesqrt(length2);
    }
}

decal_place decal_place_at(decal_array decals, uint index, vec3 q, decal_point p) {
    return decal_place(decal_uv(q), decal_uv_direction(decals, index, p.dx), decal_uv_direction(decals, index, p.dy), q.z,
                       dot(p.facing, decals.at[index].facing), false);
}

// In the space of a mesh before it deforms. `bind_dx` and `bind_dy`: how the position there changes from pixel to pixel; `mirror` is -1 where
// the instance is mirrored.
decal_place decal_place_on_mesh(decal_array decals, uint index, vec3 q, decal_point p, vec3 bind_dx, vec3 bind_dy, float mirror) {
    decal_place place;
    vec3 bind_normal = cross(bind_dx, bind_dy) * (dot(cross(p.dx, p.dy), p.facing) < 0.0 ? -mirror : mirror);
    float length2 = dot(bind_normal, bind_normal);
    place.uv = decal_uv(q);
    place.uv_dx = decal_uv_direction(decals, index, bind_dx);
    place.uv_dy = decal_uv_direction(decals, index, bind_dy);
    place.height = q.z;
    place.cosine = length2 > 1e-36 ? dot(bind_normal, decals.at[index].facing) * inversesqrt(length2) : 1.0;
    place.on_mesh = true;
    return place;
}

// One of the boxes and volumes, if it holds the point; whether it does.
bool decal_at_point(inout surface s, decal_block d, uint index, decal_point p) {
    decal_array decals = d.set.decals;
    vec3 q = decal_cube(decals, index, p.position);
    if (!decal_holds(q) || !decal_meets(decals, index, p.receivers)) return false;
    decal_place place = decal_place_at(decals, index, q, p);
    decal_apply(s, decals, index, d.set.sampler_index, place, p);
    return true;
}

// All boxes and volumes of the list, in order.
void decals_apply(inout surface s, decal_block d, uvec2 pixel, float view_depth, decal_point p) {
    light_list_block list = d.set.list;
    light_cursor cursor = lights_begin_as(GPU_LIST_CLUSTERS, list, light_point(pixel, view_depth, p.position, s.normal, LIGHT_NO_ITEM));
    for (uint index; p.receivers != 0u && lights_next_as(GPU_LIST_CLUSTERS, list, cursor, index);) decal_at_point(s, d, index, p);
}

// How many of the list hold the point.
uint decals_count(decal_block d, uvec2 pixel, float view_depth, vec3 position) {
    light_list_block list = d.set.list;
    light_cursor cursor = lights_begin_as(GPU_LIST_CLUSTERS, list, light_point(pixel, view_depth, position, vec3(0.0), LIGHT_NO_ITEM));
    decal_array decals = d.set.decals;
    uint count = 0u;
    for (uint index; lights_next_as(GPU_LIST_CLUSTERS, list, cursor, index);)
        if (decal_holds(decal_cube(decals, index, position))) count++;
    return count;
}

#endif
