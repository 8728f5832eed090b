// SPDX-License-Identifier: MIT
// The one loop over the lights of a pixel. Shading never knows which list it got:
//
//     light_cursor cursor = lights_begin(list, pixel, view_depth);
//     FOR_EACH_LIGHT(list, cursor, light) { sum += ...list.list.lights.at[light]...; }
//
// The kind of list is the specialisation constant LIST_KIND. Every kind gives the lights in ascending order, so the sums are
// equal to the bit.
#ifndef LIGHTS_ITERATE_GLSL
#define LIGHTS_ITERATE_GLSL

#include "common.glsl"

layout(buffer_reference) buffer light_array;
layout(buffer_reference) buffer cell_array;

#include "lights/lights_shared.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer light_array { gpu_light at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer cell_array { gpu_cell at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer light_list_block { gpu_light_list list; };

layout(constant_id = 0) const uint LIST_KIND = GPU_LIST_ALL;

struct light_cursor {
    uint next, end; // positions
    bool direct;    // a position is a light, not an index into ids
};

uint slice_of(light_list_block l, float view_depth) {
    float slice = log2(view_depth) * l.list.slice_scale + l.list.slice_bias;
    return uint(clamp(slice, 0.0, float(l.list.slices - 1u)));
}

uint cell_of(light_list_block l, uvec2 pixel, float view_depth) {
    uvec2 tile = min(pixel / l.list.tile_size, uvec2(l.list.tiles_x, l.list.tiles_y) - 1u);
    uint slice = LIST_KIND == GPU_LIST_CLUSTERS ? slice_of(l, view_depth) : 0u;
    return (slice * l.list.tiles_y + tile.y) * l.list.tiles_x + tile.x;
}

light_cursor lights_begin(light_list_block l, uvec2 pixel, float view_depth) {
    if (LIST_KIND == GPU_LIST_ALL) return light_cursor(0u, l.list.local_count, true);
    gpu_cell cell = l.list.cells.at[cell_of(l, pixel, view_depth)];
    if (cell.count == GPU_CELL_ALL) return light_cursor(0u, l.list.local_count, true);
    return light_cursor(cell.offset, cell.offset + cell.count, false);
}

// How many lights the loop will visit.
uint lights_count(light_cursor cursor) { return cursor.end - cursor.next; }

// Index into list.lights of the light under the cursor.
uint lights_get(light_list_block l, light_cursor cursor) {
    uint id = cursor.next;
    if (!cursor.direct) id = l.list.ids.at[id];
    return l.list.directional_count + id;
}

#define FOR_EACH_LIGHT(list, cursor, light)                                                                             \
    for (uint light; cursor.next < cursor.end && (light = lights_get(list, cursor), true); cursor.next++)

#endif
