// SPDX-License-Identifier: MIT
// Reading the G-buffer. What its targets hold is in gbuffer_layouts.glsl.
#ifndef GBUFFER_GLSL
#define GBUFFER_GLSL

#include "view.glsl"
#include "gbuffer_layouts.glsl"

// How the targets are packed, where the pipeline is made for one way (gbuffer_specialise of gbuffer.h); else gpu_gbuffer.form says it.
layout(constant_id = GBUFFER_CONSTANT) const uint GBUFFER_GIVEN = 0xffffffffu;

uint gbuffer_form(gpu_gbuffer from) { return GBUFFER_GIVEN == 0xffffffffu ? from.form : GBUFFER_GIVEN; }

float gbuffer_depth(gpu_gbuffer from, ivec2 pixel) { return texelFetch(textures[from.depth], pixel, 0).r; }
// Of one sample, here and below, where the G-buffer is multisampled.
float gbuffer_depth(gpu_gbuffer from, ivec2 pixel, int at) { return texelFetch(textures_multisampled[from.depth], pixel, at).r; }

// True where a forward pass lights what is seen, because the layout cannot hold it: lighting leaves the pixel alone.
bool gbuffer_is_forward(gpu_gbuffer from, ivec2 pixel) {
    return (gbuffer_form(from) & GBUFFER_FORM_MASK) != 0u && texelFetch(textures[from.mask], pixel, 0).r > 0.0;
}
bool gbuffer_is_forward(gpu_gbuffer from, ivec2 pixel, int at) {
    return (gbuffer_form(from) & GBUFFER_FORM_MASK) != 0u && texelFetch(textures_multisampled[from.mask], pixel, at).r > 0.0;
}
// Which of the items that meet there at the same depth is seen, as far as 8 bits tell.
float gbuffer_mask_of(uint item) { return float(item % 255u + 1u) / 255.0; }
bool gbuffer_is_owner(gpu_gbuffer from, ivec2 pixel, uint item) {
    return round(texelFetch(textures[from.mask], pixel, 0).r * 255.0) == float(item % 255u + 1u);
}

bool gbuffer_is_owner(gpu_gbuffer from, ivec2 pixel, int at, uint item) {
    return round(texelFetch(textures_multisampled[from.mask], pixel, at).r * 255.0) == float(item % 255u + 1u);
}

// World-space position of what a pixel's centre shows.
vec3 gbuffer_position(view_block v, ivec2 pixel, float view_depth) {
    return (v.view.view_to_world * vec4(view_position_of(v, ndc_of_pixel(v, vec2(pixel) + 0.5), view_depth), 1.0)).xyz;
}

gbuffer_place gbuffer_place_at(view_block v, vec3 position) {
    mat3 world_to_view = mat3(v.view.world_to_view);
    return gbuffer_place(to_viewer(v, position), world_to_view, (v.view.world_to_view * vec4(position, 1.0)).xyz);
}

// Target `i` of a pixel, or of one of its samples.
vec4 gbuffer_fetch(gpu_gbuffer from, uint i, ivec2 pixel, int at) {
    return at < 0 ? texelFetch(textures[from.targets[i]], pixel, 0) : texelFetch(textures_multisampled[from.targets[i]], pixel, at);
}

// What is stored, as it is stored: equal values are equal bits. Targets that there are not are zero.
gbuffer gbuffer_stored(gpu_gbuffer from, ivec2 pixel, int at) {
    gbuffer g;
    uint count = gbuffer_target_count(gbuffer_form(from));
    for (uint i = 0u; i < GBUFFER_TARGETS; i++) {
        g.targets[i] = vec4(0.0);
        if (i < count) g.targets[i] = gbuffer_fetch(from, i, pixel, at);
    }
    return g;
}

// The material ID; 0 in layouts without one.
uint gbuffer_material(gpu_gbuffer from, ivec2 pixel) { return gbuffer_unpack_material(gbuffer_form(from), gbuffer_stored(from, pixel, -1)); }

// The world-space normal alone.
vec3 gbuffer_normal(gpu_gbuffer from, ivec2 pixel) {
    uint form = gbuffer_form(from);
    gbuffer_place at;
    if (gbuffer_normal_is_placed(form))
        at = gbuffer_place_at(from.view, gbuffer_position(from.view, pixel, view_depth_of(from.view, gbuffer_depth(from, pixel))));
    return gbuffer_unpack_normal(form, gbuffer_fetch(from, gbuffer_normal_target(form), pixel, -1), at);
}

// ---- base colour from luma and one half of the chroma ----

float gbuffer_depth_at(gpu_gbuffer from, ivec2 pixel, int at) {
    return at < 0 ? gbuffer_depth(from, pixel) : gbuffer_depth(from, pixel, at);
}

// The half that the pixel lacks comes from its four neighbours: from those on the same surface, as far as depth tells, and of these more from
// the ones of like luma. None on it: no chroma in that direction. After Mavridis and Papaioannou (2012), who look at luma alone.
vec3 gbuffer_color(gpu_gbuffer from, ivec2 pixel, int at, vec2 own) {
    const ivec2 sides[4] = ivec2[](ivec2(-1, 0), ivec2(1, 0), ivec2(0, -1), ivec2(0, 1));
    ivec2 size = ivec2(from.view.view.size);
    float depth = view_depth_of(from.view, gbuffer_depth_at(from, pixel, at)), away[4], nearest = 1e30;
    vec2 stored[4];
    for (uint i = 0u; i < 4u; i++) {
        ivec2 p = pixel + sides[i];
        away[i] = 1e30;
        if (any(lessThan(p, ivec2(0))) || any(greaterThanEqual(p, size))) continue;
        float d = gbuffer_depth_at(from, p, at);
        if (d <= 0.0) continue; // sky
        away[i] = abs(view_depth_of(from.view, d) - depth) / depth;
        stored[i] = gbuffer_fetch(from, 0u, p, at).rg;
        nearest = min(nearest, away[i]);
    }
    float limit = min(2.0 * nearest + 0.002, 0.05), sum = 0.0, weights = 0.0;
    for (uint i = 0u; i < 4u; i++) {
        if (away[i] > limit) continue;
        float weight = exp2(-40.0 * abs(stored[i].x - own.x)) + 1e-6;
        sum += weight * stored[i].y;
        weights += weight;
    }
    float other = weights > 0.0 ? sum / weights * 255.0 : 128.0;
    vec3 ycc = gbuffer_chroma_of(pixel) == 0u ? vec3(own * 255.0, other) : vec3(own.x * 255.0, other, own.y * 255.0);
    vec3 encoded = clamp(gbuffer_from_luma(ycc), 0.0, 1.0);
    return mix(encoded / 12.92, pow((encoded + 0.055) / 1.055, vec3(2.4)), greaterThan(encoded, vec3(0.04045)));
}

// ---- surfaces ----

surface gbuffer_surface_at(gpu_gbuffer from, ivec2 pixel, int at, vec3 position, vec3 emissive) {
    uint form = gbuffer_form(from);
    gbuffer g = gbuffer_stored(from, pixel, at);
    gpu_material_entry entry;
    if (gbuffer_has_id(form)) entry = from.entries.at[gbuffer_unpack_material(form, g)];
    gbuffer_place place;
    if (gbuffer_normal_is_placed(form)) { // where it was packed: samples of a pixel are, at its middle
        vec3 packed_at = position;
        if (at >= 0) packed_at = gbuffer_position(from.view, pixel, view_depth_of(from.view, gbuffer_depth(from, pixel, at)));
        place = gbuffer_place_at(from.view, packed_at);
    }
    surface s = gbuffer_unpack(form, g, place, entry, position, emissive);
    if ((form & GBUFFER_FORM_CHROMA) != 0u) s.base_color = gbuffer_color(from, pixel, at, g.targets[0].rg);
    return s;
}

// The surface at a pixel whose depth is not that of the sky.
surface gbuffer_surface(gpu_gbuffer from, ivec2 pixel, vec3 position, vec3 emissive) {
    return gbuffer_surface_at(from, pixel, -1, position, emissive);
}
surface gbuffer_surface(gpu_gbuffer from, ivec2 pixel, int at, vec3 position, vec3 emissive) {
    return gbuffer_surface_at(from, pixel, at, position, emissive);
}

#endif
