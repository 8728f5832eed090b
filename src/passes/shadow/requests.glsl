// SPDX-License-Identifier: MIT
// Asks for the pages of shadow maps that the shading of a point will look up.
#ifndef SHADOW_REQUESTS_GLSL
#define SHADOW_REQUESTS_GLSL

#include "constants_shared.h"
#include "lighting/visibility.glsl"
#include "shadows/oblong.glsl"

layout(constant_id = SHADOW_WEIGHS_ID) const uint SHADOW_WEIGHS = 0u; // 1: pixels are counted, too

// Behind the bits of all rows: how many pixels each light may reach.
void request_weigh(lighting_block l, uint_array wanted, uint row, uint pixels) {
    uint rows = l.scope.lights.directional_count * SHADOW_SUN_ROWS + l.scope.list.list.local_count;
    if (pixels > 0u) atomicAdd(wanted.at[rows * SHADOW_ROW_WORDS + row], pixels);
}

bool request_is_made(uint_array wanted, uint row, uint bit) {
    return (wanted.at[row * SHADOW_ROW_WORDS + bit / 32u] >> (bit % 32u) & 1u) != 0u;
}
void request_bit(uint_array wanted, uint row, uint bit) {
    uint word = row * SHADOW_ROW_WORDS + bit / 32u, mask = 1u << (bit % 32u);
    if ((wanted.at[word] & mask) == 0u) atomicOr(wanted.at[word], mask); // most were asked for before
}

// The pages of a face that hold a rectangle of it, at each of some levels: one step after the other, which costs least where there is but one.
struct request_walk {
    uvec2 low, high, at;
    uint levels, side, first; // left to do, the pages on a side of this one, and the bit of its first
};
request_walk request_walk_begin(uint face, uint finest, uint coarsest, vec2 low, vec2 high, float slack) {
    request_walk w;
    uvec2 unused;
    shadow_pages_round(finest, low, slack, w.low, unused);
    shadow_pages_round(finest, high, slack, unused, w.high);
    w.at = w.low;
    w.levels = coarsest - finest;
    w.side = shadow_side(finest);
    w.first = shadow_bit(face, finest, uvec2(0u));
    return w;
}
bool request_walk_ends(request_walk w) { return w.at == w.high && w.levels == 0u; }
uint request_walk_bit(request_walk w) { return w.first + w.at.y * w.side + w.at.x; }
bool request_walk_next(inout request_walk w) {
    bool ends_row = w.at.x == w.high.x, ends_level = ends_row && w.at.y == w.high.y;
    w.at = ends_row ? uvec2(w.low.x, w.at.y + 1u) : uvec2(w.at.x + 1u, w.at.y);
    if (!ends_level) return true;
    if (w.levels == 0u) return false;
    w.levels--;
    w.first += w.side * w.side;
    w.side = max(w.side >> 1, 1u);
    w.low >>= 1;
    w.high >>= 1;
    w.at = w.low;
    return true;
}

// `near`: metres within which shading may place the point.
void request_face(lighting_block l, uint_array wanted, uint light, uint row, gpu_shape shape, uint face, vec3 ray, vec3 position, float near) {
    vec4 clip = shadow_face_clip(shape, face, ray);
    vec2 ndc = clip.xy / clip.w;
    view_block v = l.scope.view;
    float slack = near / (shape.kind == GPU_SHAPE_BOX ? min(shape.size.x, shape.size.y) : clip.w);
    float across = shadow_across(shape, clip.w, pixel_width(v, length(v.view.eye - position)));
    float widest = shadow_maps_block(l.scope.shadows.maps).maps.widest;
    uint finest = shadow_level_for(across * (1.0 + slack + 1e-4), widest), coarsest = shadow_level_for(across / (1.0 + slack + 1e-4), widest);
    coarsest = shadow_coarsest_level(l, light, shape, face, clip, ray, coarsest);
    request_walk walk = request_walk_begin(face, finest, coarsest, ndc, ndc, slack);
    bool is_left = !request_walk_ends(walk) || !request_is_made(wanted, row, request_walk_bit(walk));
    for (; is_left; is_left = request_walk_next(walk)) request_bit(wanted, row, request_walk_bit(walk));
}

// All faces that the point may be seen in: more than one only at their edges. Rarely so: the loop leaves out the others.
void request_light(lighting_block l, uint_array wanted, uint light, uint row, gpu_shape shape, vec3 position, float near) {
    vec3 ray = position - shape.position, size = abs(ray);
    float least = max(size.x, max(size.y, size.z)) - 2.0 * near;
    bvec3 is_seen = shape.kind == GPU_SHAPE_BOX ? bvec3(true, false, false) : greaterThanEqual(size, vec3(max(least, 1e-30)));
    uint axes = uint(is_seen.x) | uint(is_seen.y) << 1 | uint(is_seen.z) << 2;
    for (; axes != 0u; axes &= axes - 1u) {
        uint axis = uint(findLSB(axes));
        uint face = shape.kind == GPU_SHAPE_BOX || ray[axis] >= 0.0 ? 2u * axis : 2u * axis + 1u;
        request_face(l, wanted, light, row, shape, face, ray, position, near);
    }
}

uint request_row(lighting_block l, uint light) { return light + shadow_maps_block(l.scope.shadows.maps).maps.first_row; }

// The shape as far as pages depend on it: without code for boxes where there are none.
gpu_shape request_shape(lighting_block l, uint light) {
    gpu_shape shape = l.scope.lights.lights.at[light].shape;
    if (LIGHTING_SIMPLE) shape.kind = GPU_SHAPE_SPHERE;
    return shape;
}

void request_of_light(lighting_block l, uint_array wanted, uint light, vec3 position, float near) {
    gpu_shape shape = request_shape(l, light);
    if (!light_casts(lights_of(l), light) || !shadow_has_map(shape) || !light_reaches(lights_of(l), light, position)) return;
    request_light(l, wanted, light, request_row(l, light), shape, position, near);
}

// Requests pages of a sun. If the point has an oblong page: that page, and a square page of a coarser grid in case
// there is no room. Otherwise: a page of the grid that suits the point. Coarser grids are also used if the blocks of
// the grid do not contain the whole point.
void request_sun(lighting_block l, uint_array wanted, uint light, vec3 position, float near) {
    gpu_shadow_maps maps = shadow_maps_block(l.scope.shadows.maps).maps;
    gpu_shadow_sun sun = maps.suns.at[light];
    view_block v = l.scope.view;
    float seen_from = length(v.view.eye - position), pixel = pixel_width(v, seen_from), part = near / seen_from + 1e-4;
    vec2 at = vec2(dot(position, sun.side), dot(position, sun.up));
    shadow_oblong oblong;
    uint oblong_row;
    if (shadow_oblong_at(maps, v, light, position, pixel, oblong, oblong_row)) {
        request_bit(wanted, oblong_row, shadow_bit(0u, 0u, uvec2(oblong.page) % 16u));
        pixel *= 4.0;
    }
    int coarsest = shadow_sun_grid(sun, pixel * (1.0 + part));
    for (int grid = shadow_sun_grid(sun, pixel / (1.0 + part)); grid <= sun.coarsest; grid++) {
        float page = shadow_sun_page(grid);
        ivec2 first = shadow_sun_first(sun, grid) * 16, end = first + SHADOW_SUN_SIDE * 16;
        ivec2 low = ivec2(floor((at - near) / page)), high = ivec2(floor((at + near) / page));
        bool is_whole = all(greaterThanEqual(low, first)) && all(lessThan(high, end));
        low = max(low, first);
        high = min(high, end - 1);
        for (int y = low.y; y <= high.y; y++)
            for (int x = low.x; x <= high.x; x++) {
                ivec2 block = ivec2(x, y) >> 4;
                uint row = shadow_sun_row(light, grid, block), last = 0u;
                if (LIGHTING_FILTERED) {
                    gpu_shape shape = shadow_sun_shape(sun, grid, block);
                    vec3 ray = position - shape.position;
                    last = shadow_coarsest_level(l, light, shape, 0u, shadow_face_clip(shape, 0u, ray), ray, 0u);
                }
                for (uint level = 0u; level <= last; level++)
                    request_bit(wanted, row, shadow_bit(0u, level, uvec2(x, y) % 16u / (16u / shadow_side(level))));
            }
        if (is_whole && grid >= coarsest) return;
    }
}

// Of all directional lights.
void request_suns(lighting_block l, uint_array wanted, vec3 position, float near) {
    for (uint i = 0u; i < l.scope.lights.directional_count; i++)
        if (light_casts(lights_of(l), i) && any(greaterThan(l.scope.lights.lights.at[i].color, vec3(0.0)))) request_sun(l, wanted, i, position, near);
}

void request_pages(lighting_block l, uint_array wanted, light_point point) {
    float near = shadow_slack(l, point.position);
    request_suns(l, wanted, point.position, near);
    light_cursor cursor = lights_begin(list_of(l), point);
    FOR_EACH_LIGHT(list_of(l), cursor, light) {
        if (SHADOW_WEIGHS != 0u && light_casts(lights_of(l), light) && shadow_has_map(request_shape(l, light)) && light_reaches(lights_of(l), light, point.position))
            request_weigh(l, wanted, request_row(l, light), 1u);
        request_of_light(l, wanted, light, point.position, near);
    }
}

#endif
