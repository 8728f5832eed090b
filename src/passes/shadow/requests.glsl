// SPDX-License-Identifier: MIT
// Asks for the pages of shadow maps that the shading of a point will look up.
#ifndef SHADOW_REQUESTS_GLSL
#define SHADOW_REQUESTS_GLSL

#include "lights/illuminate.glsl"
#include "shadows/suns.glsl"

void request_bit(uint_array wanted, uint row, uint bit) {
    uint word = row * SHADOW_ROW_WORDS + bit / 32u, mask = 1u << (bit % 32u);
    if ((wanted.at[word] & mask) == 0u) atomicOr(wanted.at[word], mask); // most were asked for before
}

// `near`: metres within which shading may place the point.
void request_face(light_list_block l, uint_array wanted, uint light, uint row, gpu_shape shape, uint face, vec3 ray, vec3 position, float near) {
    vec4 clip = shadow_face_clip(shape, face, ray);
    vec2 ndc = clip.xy / clip.w;
    float slack = near / (shape.kind == GPU_SHAPE_BOX ? min(shape.size.x, shape.size.y) : clip.w), across = shadow_across(l, shape, clip.w, position);
    uint finest = shadow_level_for(across * (1.0 + slack + 1e-4)), coarsest = shadow_level_for(across / (1.0 + slack + 1e-4));
    coarsest = shadow_coarsest_level(l, light, shape, face, clip, ray, coarsest);
    for (uint level = finest; level <= coarsest; level++) {
        uvec2 low, high;
        shadow_pages_round(level, ndc, slack, low, high);
        for (uint y = low.y; y <= high.y; y++)
            for (uint x = low.x; x <= high.x; x++) request_bit(wanted, row, shadow_bit(face, level, uvec2(x, y)));
    }
}

// All faces that the point may be seen in: more than one only at their edges.
void request_light(light_list_block l, uint_array wanted, uint light, uint row, gpu_shape shape, vec3 position, float near) {
    vec3 ray = position - shape.position, size = abs(ray);
    if (shape.kind == GPU_SHAPE_BOX) {
        request_face(l, wanted, light, row, shape, 0u, ray, position, near);
        return;
    }
    float least = max(size.x, max(size.y, size.z)) - 2.0 * near;
    for (uint axis = 0u; axis < 3u; axis++)
        if (size[axis] >= least && size[axis] > 0.0)
            request_face(l, wanted, light, row, shape, 2u * axis + (ray[axis] < 0.0 ? 1u : 0u), ray, position, near);
}

// Of the grid that suits the point, or where its blocks do not hold all of the point, of coarser ones besides.
void request_sun(light_list_block l, uint_array wanted, uint light, gpu_shadow_sun sun, vec3 position, float pixel, float seen_from, float near) {
    vec2 at = vec2(dot(position, sun.side), dot(position, sun.up));
    float part = near / seen_from + 1e-4;
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
                if (l.list.view.view.frame.frame.shadow_filter == GPU_SHADOW_FILTER_PCSS) {
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

void request_pages(light_list_block l, uint_array wanted, light_point point) {
    view_block v = l.list.view;
    float seen_from = length(v.view.eye - point.position), near = shadow_slack(l, point.position);
    gpu_shadow_maps maps = shadow_maps_block(l.list.shadow_maps).maps;
    for (uint i = 0u; i < l.list.directional_count; i++)
        if (light_casts(l, i) && any(greaterThan(l.list.lights.at[i].color, vec3(0.0))))
            request_sun(l, wanted, i, maps.suns.at[i], point.position, pixel_width(v, seen_from), seen_from, near);
    light_cursor cursor = lights_begin(l, point);
    FOR_EACH_LIGHT(l, cursor, light) {
        gpu_shape shape = l.list.lights.at[light].shape;
        if (!light_casts(l, light) || !shadow_has_map(shape) || !light_reaches(l, light, point.position)) continue;
        request_light(l, wanted, light, light + maps.first_row, shape, point.position, near);
    }
}

#endif
