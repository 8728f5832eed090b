// SPDX-License-Identifier: MIT
// Shadows from the pages of maps_shared.h.
#ifndef SHADOWS_MAPS_GLSL
#define SHADOWS_MAPS_GLSL

#include "lights/iterate.glsl"
#include "shadows/oblong.glsl"
#include "shadows/cubemap.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer shadow_maps_block { gpu_shadow_maps maps; };

// A point of a surface, and what the shadows of all lights need to know of it. Found once for all of them: shaders read it from memory.
struct shadowed_point {
    vec3 position, normal;
    float slack; // metres by which the position may be wrong
    float pixel; // metres across
    gpu_shadow_maps maps;
    gpu_probes probes;
    uint probe; // that holds it, or probes.count
    vec3 place; // in its space
    uint other; // that holds it too, or probes.count
    float part; // of the light of the first
};

// How many pixels wide the face is where a point lies, if one is so many metres wide there: `along` is the w of shadow_face_clip().
float shadow_across(gpu_shape shape, float along, float pixel) {
    return 2.0 * (shape.kind == GPU_SHAPE_BOX ? max(shape.size.x, shape.size.y) : along) / pixel;
}

bool shadow_has_map(gpu_shape shape) { return shape.kind != GPU_SHAPE_CAPSULE && !(LIGHTING_AREA_LIGHTS && shape_is_area(shape.kind)); }

// Where in the atlas a page lies, if it is there and drawn.
bool shadow_find(gpu_shadow_maps maps, uint row, uint bit, out uint place) {
    uint word = row * SHADOW_ROW_WORDS + bit / 32u, bits = maps.held.at[word], below = (1u << (bit % 32u)) - 1u;
    place = 0u;
    if ((bits >> (bit % 32u) & 1u) == 0u) return false;
    gpu_shadow_page page = maps.pages.at[maps.before.at[word] + uint(bitCount(bits & below))];
    place = page.place;
    return (page.flags & SHADOW_PAGE_DRAW) == 0u;
}

// The finest page that is there and holds a point of a face, from at.level on. Nearly always that is the first.
bool shadow_find_from(gpu_shadow_maps maps, uint row, vec2 ndc, inout shadow_page at, out uint place) {
    at.at = shadow_page_at(at.level, ndc);
    if (shadow_find(maps, row, shadow_bit(at.face, at.level, at.at), place)) return true;
    for (at.level++; at.level < SHADOW_LEVELS; at.level++) {
        at.at = shadow_page_at(at.level, ndc);
        if (shadow_find(maps, row, shadow_bit(at.face, at.level, at.at), place)) return true;
    }
    return false;
}

// The four texels round a point of a page, and where it lies between them.
struct shadow_quad {
    vec4 depths; // (0, 1), (1, 1), (1, 0), (0, 0)
    vec2 part;
    float nearest;
    vec2 corner; // where the four texels meet, in texels of the atlas
};

shadow_quad shadow_quad_at(gpu_shadow_maps maps, uint place, shadow_page at, vec2 texel) {
    vec2 low = clamp(texel - 0.5, vec2(0.0), vec2(float(shadow_page_size(at.level)) - 2.0));
    shadow_quad q;
    vec2 first = floor(low);
    q.part = low - first;
    q.corner = first + vec2(place & 0xffffu, place >> 16u) * float(SHADOW_UNIT) + 1.0;
    q.depths = textureGather(sampler2D(textures[maps.atlas], samplers[maps.point]), q.corner * maps.texel);
    vec2 column = q.part.x < 0.5 ? q.depths.wx : q.depths.zy;
    q.nearest = q.part.y < 0.5 ? column.x : column.y;
    return q;
}

// x: the least depth of the four, y: the greatest.
vec2 shadow_quad_range(shadow_quad q) {
    return vec2(min(min(q.depths.x, q.depths.y), min(q.depths.z, q.depths.w)), max(max(q.depths.x, q.depths.y), max(q.depths.z, q.depths.w)));
}

// The depth at the point itself.
float shadow_quad_depth(shadow_quad q) {
    vec2 row = mix(q.depths.wx, q.depths.zy, q.part.x);
    return mix(row.x, row.y, q.part.y);
}

#include "shadows/filter.glsl"

// Whether the four texels round a point of a page hide it; `depth` is its own, reversed, `slope` what the depth of its plane grows by per unit of ndc. They
// do where all are nearer, and where the nearest texel is, unless the point lies on the surface that the texels show. It does where the depth between the
// four is its own: on a plane depth is linear between texels, whatever its slope, while at the edge of what casts a shadow the point stays behind by more
// than a quarter of the step. And it does where its own plane is as near at that texel: in a corner the four show two planes.
bool shadow_hides(gpu_shadow_maps maps, uint place, shadow_page at, vec2 ndc, float depth, vec2 slope) {
    vec2 texel = shadow_page_texel(at, ndc);
    shadow_quad q = shadow_quad_at(maps, place, at, texel);
    vec2 range = shadow_quad_range(q), back = step(vec2(0.5), q.part) - q.part; // in texels, to the middle of the nearest
    float tolerance = 0.25 * (range.y - range.x), there = depth + dot(slope, back) * (2.0 / shadow_width(at.level));
    bool is_nearer = q.nearest > depth, are_all = range.x > depth, is_off = shadow_quad_depth(q) > depth + tolerance;
    if (!is_nearer || are_all) return is_nearer;
    if (!is_off || !(q.nearest > there + tolerance)) return false;
    // The nearest texel may show a plane that ends in a crease before the point, or that continues behind the point.
    // The two texels beyond give the slope of that plane.
    ivec2 outward = ivec2(sign(back)), nearest = ivec2(q.corner) - 1 + ivec2(step(vec2(0.5), q.part));
    vec2 beyond = vec2(texelFetch(textures[maps.atlas], nearest + ivec2(outward.x, 0), 0).r, texelFetch(textures[maps.atlas], nearest + ivec2(0, outward.y), 0).r);
    return q.nearest + dot(q.nearest - beyond, abs(back)) > depth;
}

// What part of a light reaches a point, by the map of a row: without a filter 0 or 1; or -1 where no map tells. Pages of at.level are looked up, and of
// coarser levels where there are none: pixels asked for the first, what is beside them may have to look farther.
float row_visibility(lighting_block l, uint light, shadowed_point p, uint row, gpu_shape shape, shadow_page at) {
    vec3 ray = p.position - shape.position;
    vec4 clip = shadow_face_clip(shape, at.face, ray);
    vec2 ndc = clip.xy / clip.w;
    uint place;
    if (!shadow_find_from(p.maps, row, ndc, at, place)) return -1.0;
    float texel = 2.0 / shadow_width(at.level), depth;
    if (shape.kind == GPU_SHAPE_BOX) { // what is beyond the last that casts has the least depth
        float before = p.slack + 0.5 * texel * max(shape.size.x, shape.size.y);
        depth = max(clip.z + 0.5 * before / shape.size.z, 0.0);
    } else {
        float along = clip.w - p.slack - 0.5 * texel * clip.w;
        depth = along > 0.0 ? SHADOW_NEAR / along : 2.0; // nothing is nearer
    }
    bool hidden = shadow_hides(p.maps, place, at, ndc, depth, shadow_plane_slope(shape, at.face, ray, p.normal, 1e-3));
    if (!LIGHTING_FILTERED) return hidden ? 0.0 : 1.0;
    return shadow_filtered(l, light, p, row, shape, at, place, shadow_receiver_of(shape, at.face, clip, ray, p.normal), hidden);
}

// The same of a light. What is nearer by less than half a texel's width casts no shadow, or there would be lines in corners, whose depth lies
// between texels.
float map_visibility(lighting_block l, uint light, shadowed_point p) {
    gpu_shape shape = l.scope.lights.lights.at[light].shape;
    if (LIGHTING_SIMPLE) shape.kind = GPU_SHAPE_SPHERE; // or a cone, whose map is alike: no code for other shapes
    uint row = light + p.maps.first_row;
    uint bias = shadow_has_map(shape) ? p.maps.biases.at[row] : SHADOW_TRACED;
    if (bias == SHADOW_TRACED) return -1.0;
    vec3 ray = p.position - shape.position;
    shadow_page at;
    at.face = shadow_face_of(shape.kind, ray);
    float along = shadow_face_clip(shape, at.face, ray).w;
    at.level = min(shadow_level_for(shadow_across(shape, along, p.pixel), p.maps.widest) + bias, SHADOW_LEVELS - 1u);
    return row_visibility(l, light, p, row, shape, at);
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
float sun_map_visibility(lighting_block l, uint light, shadowed_point p) {
    int grid = shadow_sun_grid(p.maps.suns.at[light], p.pixel);
    uint row;
    shadow_oblong oblong;
    view_block v = l.scope.view;
    bool is_oblong = shadow_oblong_at(p.maps, v, light, p.position, p.pixel, oblong, row) && p.maps.biases.at[row] != SHADOW_TRACED;
    if (is_oblong) grid--; // the oblong page comes before the square grids
    for (; is_oblong || shadow_sun_find(p.maps, light, p.position, grid, row); grid++) {
        is_oblong = false;
        shadow_page at;
        at.face = 0u;
        at.level = p.maps.biases.at[row];
        gpu_shape shape = p.maps.shapes.at[row];
        shape.kind = GPU_SHAPE_BOX; // as it is: no code for other shapes
        float open = row_visibility(l, light, p, row, shape, at);
        if (open >= 0.0) return open;
    }
    return -1.0;
}

#endif
