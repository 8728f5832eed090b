// SPDX-License-Identifier: MIT
// Shadows from the pages of maps_shared.h.
#ifndef SHADOWS_MAPS_GLSL
#define SHADOWS_MAPS_GLSL

#include "lights/iterate.glsl"
#include "shadows/suns.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer shadow_maps_block { gpu_shadow_maps maps; };

// How many pixels wide the face is where a point lies: `along` is the w of shadow_face_clip().
float shadow_across(light_list_block l, gpu_shape shape, float along, vec3 position) {
    view_block v = l.list.view;
    float pixel = pixel_width(v, length(v.view.eye - position));
    return 2.0 * (shape.kind == GPU_SHAPE_BOX ? max(shape.size.x, shape.size.y) : along) / pixel;
}

bool shadow_has_map(gpu_shape shape) { return shape.kind != GPU_SHAPE_CAPSULE; }

// The number of a page, where it is there and drawn.
bool shadow_find(gpu_shadow_maps maps, uint row, uint bit, out uint page) {
    uint word = row * SHADOW_ROW_WORDS + bit / 32u, bits = maps.held.at[word], below = (1u << (bit % 32u)) - 1u;
    page = 0u;
    if ((bits >> (bit % 32u) & 1u) == 0u) return false;
    page = maps.before.at[word] + uint(bitCount(bits & below));
    return (maps.pages.at[page].flags & SHADOW_PAGE_DRAW) == 0u;
}

// The finest page that is there and holds a point of a face, from at.level on.
bool shadow_find_from(gpu_shadow_maps maps, uint row, vec2 ndc, inout shadow_page at, out uint page) {
    for (; at.level < SHADOW_LEVELS; at.level++) {
        at.at = min(uvec2(max(ndc * 0.5 + 0.5, 0.0) * float(shadow_side(at.level))), uvec2(shadow_side(at.level) - 1u));
        if (shadow_find(maps, row, shadow_bit(at.face, at.level, at.at), page)) return true;
    }
    return false;
}

// The depths of the four texels round one of a page, and where it lies between them.
vec4 shadow_quad(gpu_shadow_maps maps, gpu_shadow_page page, shadow_page at, vec2 texel, out vec2 part) {
    vec2 low = clamp(texel - 0.5, vec2(0.0), vec2(float(shadow_page_size(at.level)) - 2.0));
    ivec2 first = ivec2(low) + ivec2(page.place & 0xffffu, page.place >> 16u) * int(SHADOW_UNIT);
    part = fract(low);
    return vec4(texelFetch(textures[maps.atlas], first, 0).r, texelFetch(textures[maps.atlas], first + ivec2(1, 0), 0).r,
                texelFetch(textures[maps.atlas], first + ivec2(0, 1), 0).r, texelFetch(textures[maps.atlas], first + ivec2(1, 1), 0).r);
}

// Whether the four texels round a point of a page hide it; `depth` is its own, reversed. They do where all are nearer, and where the nearest texel is,
// unless the point lies on the surface that the four show: on a plane depth is linear between texels, whatever its slope, while at the edge of
// what casts a shadow the point stays behind by more than a quarter of the step.
bool shadow_hides(gpu_shadow_maps maps, gpu_shadow_page page, shadow_page at, vec2 ndc, float depth) {
    vec2 part;
    vec4 d = shadow_quad(maps, page, at, shadow_page_texel(at, ndc), part);
    float least = min(min(d.x, d.y), min(d.z, d.w)), most = max(max(d.x, d.y), max(d.z, d.w));
    if (least > depth) return true;
    float nearest = part.y < 0.5 ? (part.x < 0.5 ? d.x : d.y) : (part.x < 0.5 ? d.z : d.w);
    return nearest > depth && mix(mix(d.x, d.y, part.x), mix(d.z, d.w, part.x), part.y) > depth + 0.25 * (most - least);
}

#include "shadows/filter.glsl"

// What part of a light reaches a point, by the map of a row: without a filter 0 or 1; or -1 where no map tells. Pages of at.level are looked up, and of
// coarser levels where there are none: pixels asked for the first, what is beside them may have to look farther.
float row_visibility(light_list_block l, uint light, gpu_shadow_maps maps, uint row, gpu_shape shape, shadow_page at, vec3 position, vec3 normal,
                     float slack) {
    vec3 ray = position - shape.position;
    vec4 clip = shadow_face_clip(shape, at.face, ray);
    vec2 ndc = clip.xy / clip.w;
    uint page;
    if (!shadow_find_from(maps, row, ndc, at, page)) return -1.0;
    float texel = 2.0 / shadow_width(at.level);
    bool hidden;
    if (shape.kind == GPU_SHAPE_BOX) { // what is beyond the last that casts has the least depth
        float before = slack + 0.5 * texel * max(shape.size.x, shape.size.y);
        hidden = shadow_hides(maps, maps.pages.at[page], at, ndc, max(clip.z + 0.5 * before / shape.size.z, 0.0));
    } else {
        float along = clip.w - slack - 0.5 * texel * clip.w;
        hidden = along > 0.0 && shadow_hides(maps, maps.pages.at[page], at, ndc, SHADOW_NEAR / along);
    }
    if (!LIST_FILTERED) return hidden ? 0.0 : 1.0;
    return shadow_filtered(l, light, maps, row, shape, at, page, shadow_receiver_of(shape, at.face, clip, ray, normal), position, slack, hidden);
}

// The same of a light. `slack`: metres by which positions may be wrong; besides, what is nearer by less than half a texel's width casts no shadow, or
// there would be lines in corners, whose depth lies between texels.
float map_visibility(light_list_block l, uint light, vec3 position, vec3 normal, float slack) {
    gpu_shadow_maps maps = shadow_maps_block(l.list.shadow_maps).maps;
    gpu_shape shape = l.list.lights.at[light].shape;
    uint row = light + maps.first_row;
    uint bias = shadow_has_map(shape) ? maps.biases.at[row] : SHADOW_TRACED;
    if (bias == SHADOW_TRACED) return -1.0;
    vec3 ray = position - shape.position;
    shadow_page at;
    at.face = shadow_face_of(shape.kind, ray);
    float along = shadow_face_clip(shape, at.face, ray).w;
    at.level = min(shadow_level_for(shadow_across(l, shape, along, position)) + bias, SHADOW_LEVELS - 1u);
    return row_visibility(l, light, maps, row, shape, at, position, normal, slack);
}

// The row of a directional light in which a point is looked up, from a grid on: the finest that has it; or false.
bool shadow_sun_find(gpu_shadow_maps maps, uint light, vec3 position, inout int grid, out uint row) {
    gpu_shadow_sun sun = maps.suns.at[light];
    vec2 place = vec2(dot(position, sun.side), dot(position, sun.up));
    for (; grid <= sun.coarsest; grid++) {
        ivec2 block = ivec2(floor(place / shadow_sun_page(grid))) >> 4, first = shadow_sun_first(sun, grid);
        if (any(lessThan(block, first)) || any(greaterThanEqual(block, first + SHADOW_SUN_SIDE))) continue;
        row = shadow_sun_row(light, grid, block);
        if (maps.biases.at[row] != SHADOW_TRACED) return true;
    }
    return false;
}

// map_visibility() of a directional light.
float sun_map_visibility(light_list_block l, uint light, vec3 position, vec3 normal, float slack) {
    view_block v = l.list.view;
    gpu_shadow_maps maps = shadow_maps_block(l.list.shadow_maps).maps;
    int grid = shadow_sun_grid(maps.suns.at[light], pixel_width(v, length(v.view.eye - position)));
    uint row;
    for (; shadow_sun_find(maps, light, position, grid, row); grid++) {
        shadow_page at;
        at.face = 0u;
        at.level = maps.biases.at[row];
        float open = row_visibility(l, light, maps, row, maps.shapes.at[row], at, position, normal, slack);
        if (open >= 0.0) return open;
    }
    return -1.0;
}

#endif
