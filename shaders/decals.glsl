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
    vec3 q, dx, dy; // in its cube
    vec3 side, up;  // world space
    float cosine;   // between the surface's normal and the way the decal is seen from
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

bool decal_holds(vec3 q) { return all(lessThanEqual(abs(q), vec3(0.5))); } // NaN: no

bool decal_meets(decal_array decals, uint index, uint receivers) {
    return (decals.at[index].flags >> GPU_DECAL_RECEIVERS_SHIFT & receivers) != 0u;
}

vec4 decal_texel(uint image, uint sampler_index, vec2 uv, vec2 dx, vec2 dy) {
    return textureGrad(sampler2D(textures[nonuniformEXT(image)], samplers[nonuniformEXT(sampler_index)]), uv, dx, dy);
}

// Of a stack of slices, between the two nearest; mips stop where a slice would be lost, and no texel is read across its rim.
vec4 decal_slices(uint image, uint sampler_index, decal_place p, vec2 uv, vec2 dx, vec2 dy, float slices) {
    vec2 size = vec2(textureSize(sampler2D(textures[nonuniformEXT(image)], samplers[nonuniformEXT(sampler_index)]), 0));
    size.y /= slices;
    float lod = 0.5 * log2(max(max(dot(dx * size, dx * size), dot(dy * size, dy * size)), 1e-12));
    lod = clamp(lod, 0.0, max(floor(log2(size.y)) - 1.0, 0.0));
    vec2 rim = min(0.5 * exp2(ceil(lod)) / size, vec2(0.5));
    uv = clamp(uv, rim, 1.0 - rim);
    float z = clamp((0.5 - p.q.z) * slices - 0.5, 0.0, slices - 1.0), low = floor(z), high = min(low + 1.0, slices - 1.0);
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

// A mapped normal upon a surface's present one. The picture's directions lie in the plane of the surface without its maps, and turn with
// the normal by the least rotation (Barre-Brisebois and Hill 2012): unlike a projection that has no pole that steep layers could come near.
vec3 decal_bend(vec3 normal, vec3 mapped, decal_place p, vec3 facing) {
    vec3 t = p.side - facing * dot(facing, p.side);
    float t2 = dot(t, t);
    if (t2 < 1e-12) return normal;
    t *= inversesqrt(t2);
    t -= (normal + facing) * (dot(normal, t) / max(1.0 + dot(normal, facing), 1e-3));
    vec3 b = cross(normal, t);
    if (dot(cross(facing, p.side), p.up) < 0.0) b = -b; // a mirrored picture
    vec3 bent = mapped.x * t + mapped.y * b + mapped.z * normal;
    float length2 = dot(bent, bent);
    return length2 > 1e-12 ? bent * inversesqrt(length2) : normal;
}

// What a decal shows at a place.
struct decal_look {
    vec4 color; // premultiplied, faded, cut
    vec3 emissive;
    vec3 mapped; // normal of its map
    float metallic, roughness;
};

// False where nothing of it is left.
bool decal_look_at(decal_array decals, uint index, uint sampler_index, decal_place p, out decal_look look) {
    uint flags = decals.at[index].flags;
    bool volume = (flags & GPU_DECAL_VOLUME) != 0u;
    float fade = 1.0;
    if (!volume) {
        fade = clamp(p.cosine * decals.at[index].fade_scale + decals.at[index].fade_offset, 0.0, 1.0);
        fade = fade * fade * (3.0 - 2.0 * fade);
        if (fade <= 0.0) return false;
    }
    vec2 uv = vec2(p.q.x + 0.5, 0.5 - p.q.y), dx = vec2(p.dx.x, -p.dx.y), dy = vec2(p.dy.x, -p.dy.y);
    vec4 factor = decals.at[index].color;
    float slices = decals.at[index].slices;
    look.color = vec4(factor.rgb * factor.a, factor.a);
    uint image = decals.at[index].color_image;
    if (image != GPU_DECAL_NO_IMAGE) {
        vec4 texel = volume ? decal_slices(image, sampler_index, p, uv, dx, dy, slices) : decal_texel(image, sampler_index, uv, dx, dy);
        if ((flags & GPU_DECAL_FIELD) != 0u) {
            // As wide as the distance changes from pixel to pixel: the cut is as soft as an edge.
            float cut = decals.at[index].cut, width = 0.0;
            if (!volume) width = 0.5 * (abs(decal_texel(image, sampler_index, uv + dx, dx, dy).a - texel.a) +
                                        abs(decal_texel(image, sampler_index, uv + dy, dx, dy).a - texel.a));
            width = max(width, 1.0 / 512.0);
            float inside = smoothstep(cut - width, cut + width, texel.a);
            texel = vec4(texel.rgb * inside, inside);
        }
        look.color *= texel; // both are premultiplied
    }
    look.color *= fade;
    look.roughness = decals.at[index].roughness;
    look.metallic = decals.at[index].metallic;
    image = decals.at[index].metallic_roughness_image;
    if (image != GPU_DECAL_NO_IMAGE && (flags & (GPU_DECAL_ROUGHNESS | GPU_DECAL_METALLIC)) != 0u) {
        vec4 texel = volume ? decal_slices(image, sampler_index, p, uv, dx, dy, slices) : decal_texel(image, sampler_index, uv, dx, dy);
        look.roughness *= texel.g;
        look.metallic *= texel.b;
    }
    look.emissive = vec3(0.0);
    if ((flags & GPU_DECAL_EMISSION) != 0u) {
        look.emissive = decals.at[index].emissive;
        image = decals.at[index].emissive_image;
        if (image != GPU_DECAL_NO_IMAGE) look.emissive *= decal_texel(image, sampler_index, uv, dx, dy).rgb;
    }
    look.mapped = vec3(0.0, 0.0, 1.0);
    if ((flags & GPU_DECAL_NORMAL) != 0u) {
        image = decals.at[index].normal_image;
        if (image != GPU_DECAL_NO_IMAGE) look.mapped = decal_texel(image, sampler_index, uv, dx, dy).xyz * 2.0 - 1.0;
        look.mapped.xy *= decals.at[index].normal_scale;
    }
    return true;
}

void decal_apply(inout surface s, decal_array decals, uint index, uint sampler_index, decal_place p, vec3 facing) {
    decal_look look;
    if (!decal_look_at(decals, index, sampler_index, p, look)) return;
    uint flags = decals.at[index].flags;
    float alpha = look.color.a;
    if ((flags & GPU_DECAL_COLOR) != 0u)
        s.base_color = decal_blend(flags >> GPU_DECAL_BLEND_SHIFT & 15u, s.base_color, look.color.rgb, alpha);
    if ((flags & GPU_DECAL_ROUGHNESS) != 0u) s.roughness = mix(s.roughness, look.roughness, alpha);
    if ((flags & GPU_DECAL_METALLIC) != 0u) s.metallic = mix(s.metallic, look.metallic, alpha);
    if ((flags & GPU_DECAL_EMISSION) != 0u) s.emissive = mix(s.emissive, look.emissive, alpha);
    if ((flags & GPU_DECAL_NORMAL) != 0u) {
        vec3 bent = decal_bend((flags & GPU_DECAL_FLATTEN) != 0u ? facing : s.normal, look.mapped, p, facing);
        vec3 mixed = mix(s.normal, bent, alpha);
        float length2 = dot(mixed, mixed);
        if (length2 > 1e-12) s.normal = mixed * inversesqrt(length2);
    }
}

decal_place decal_place_at(decal_array decals, uint index, vec3 q, decal_point p) {
    return decal_place(q, decal_cube_direction(decals, index, p.dx), decal_cube_direction(decals, index, p.dy), decals.at[index].side,
                       decals.at[index].up, dot(p.facing, decals.at[index].facing));
}

// In the space of a mesh before it deforms, with directions from how the picture lies on the surface. `bind_dx` and `bind_dy`: how the
// position there changes from pixel to pixel; `mirror` is -1 where the instance is mirrored.
decal_place decal_place_on_mesh(decal_array decals, uint index, vec3 q, decal_point p, vec3 bind_dx, vec3 bind_dy, float mirror) {
    decal_place place;
    vec3 bind_normal = cross(bind_dx, bind_dy) * (dot(cross(p.dx, p.dy), p.facing) < 0.0 ? -mirror : mirror);
    float length2 = dot(bind_normal, bind_normal);
    place.q = q;
    place.dx = decal_cube_direction(decals, index, bind_dx);
    place.dy = decal_cube_direction(decals, index, bind_dy);
    float turn = place.dx.x * place.dy.y - place.dy.x * place.dx.y < 0.0 ? -1.0 : 1.0;
    place.side = (p.dx * place.dy.y - p.dy * place.dx.y) * turn;
    place.up = (p.dy * place.dx.x - p.dx * place.dy.x) * turn;
    place.cosine = length2 > 1e-36 ? dot(bind_normal, decals.at[index].facing) * inversesqrt(length2) : 1.0;
    return place;
}

// One of the boxes and volumes, if it holds the point; whether it does.
bool decal_at_point(inout surface s, decal_block d, uint index, decal_point p) {
    decal_array decals = d.set.decals;
    vec3 q = decal_cube(decals, index, p.position);
    if (!decal_holds(q) || !decal_meets(decals, index, p.receivers)) return false;
    decal_place place = decal_place_at(decals, index, q, p);
    decal_apply(s, decals, index, d.set.sampler_index, place, p.facing);
    return true;
}

// All boxes and volumes of the list, in order.
void decals_apply(inout surface s, decal_block d, uvec2 pixel, float view_depth, decal_point p) {
    light_list_block list = d.set.list;
    light_cursor cursor = lights_begin_as(GPU_LIST_CLUSTERS, list, light_point(pixel, view_depth, p.position, s.normal, LIGHT_NO_ITEM));
    for (uint index; lights_next_as(GPU_LIST_CLUSTERS, list, cursor, index);) decal_at_point(s, d, index, p);
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
