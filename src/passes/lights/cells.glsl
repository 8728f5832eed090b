// SPDX-License-Identifier: MIT
// Geometry of cells, shared by the steps of the tiled and clustered lists.
#ifndef CELLS_GLSL
#define CELLS_GLSL

#include "view.glsl"
#include "lights/shapes.glsl"

layout(buffer_reference) buffer bound_array;
layout(buffer_reference) buffer reach_array;

#include "passes/lights/cells_shared.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer bound_array { gpu_bound at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer reach_array { gpu_reach at[]; };

// Tests are widened by this much, relatively, so that rounding never loses a light.
const float CELL_SLACK = 1e-4;

// View depth where a slice begins.
float slice_start(light_list_block l, uint slice) {
    float start = (float(slice) - l.list.slice_bias) / l.list.slice_scale;
    return l.list.linear == 1u ? start : exp2(start);
}

// Bounds of the part of the view between two corners of the screen (NDC, +Y up, low.x < high.x, low.y < high.y) and two view depths.
gpu_cell_bounds cell_bounds(view_block v, vec2 low, vec2 high, float near, float far) {
    gpu_cell_bounds b;
    vec3 a0 = view_position_of(v, low, near), a1 = view_position_of(v, high, near);
    vec3 b0 = view_position_of(v, low, far), b1 = view_position_of(v, high, far);
    b.low = min(min(a0, a1), min(b0, b1));
    b.high = max(max(a0, a1), max(b0, b1));
    // Side planes contain the view rays of their edge: x = edge * depth (perspective) or x = edge (orthographic).
    vec2 edge_low = low * v.view.ndc_scale + v.view.ndc_offset, edge_high = high * v.view.ndc_scale + v.view.ndc_offset;
    if (v.view.orthographic > 0.5) {
        b.planes[0] = vec4(1.0, 0.0, 0.0, -edge_low.x);
        b.planes[1] = vec4(-1.0, 0.0, 0.0, edge_high.x);
        b.planes[2] = vec4(0.0, 1.0, 0.0, -edge_low.y);
        b.planes[3] = vec4(0.0, -1.0, 0.0, edge_high.y);
    } else {
        b.planes[0] = vec4(normalize(vec3(1.0, 0.0, edge_low.x)), 0.0);
        b.planes[1] = vec4(normalize(vec3(-1.0, 0.0, -edge_high.x)), 0.0);
        b.planes[2] = vec4(normalize(vec3(0.0, 1.0, edge_low.y)), 0.0);
        b.planes[3] = vec4(normalize(vec3(0.0, -1.0, -edge_high.y)), 0.0);
    }
    return b;
}

const float CLUSTER_FAR = 1e9;

// Of a cluster of the header's grid. Slice 0 begins at the viewer and the last one never ends.
gpu_cell_bounds cluster_bounds(view_block v, light_list_block l, uint cell) {
    gpu_light_list list = l.list;
    uint tile_x = cell % list.tiles_x, tile_y = cell / list.tiles_x % list.tiles_y, slice = cell / (list.tiles_x * list.tiles_y);
    float near = slice == 0u ? 0.0 : slice_start(l, slice) * (1.0 - CELL_SLACK);
    float far = slice + 1u == list.slices ? CLUSTER_FAR : slice_start(l, slice + 1u) * (1.0 + CELL_SLACK);
    vec2 first = vec2(tile_x, tile_y) * float(list.tile_size), end = min(first + float(list.tile_size), vec2(v.view.size));
    vec2 a = ndc_of_pixel(v, first), b = ndc_of_pixel(v, end);
    return cell_bounds(v, vec2(a.x, b.y), vec2(b.x, a.y), near, far);
}

float cell_radius(gpu_bound light) { return light.radius * (1.0 + CELL_SLACK) + CELL_SLACK * (1e-2 + length(light.center) * 1e-2); }

// No light touches such a cell, by any of the tests.
bool cell_is_empty(gpu_cell_bounds b) { return b.low.z > b.high.z; }

// Sphere against planes, then against the box (RTR 4, 20.3). Keeps the light when anything is NaN.
bool cell_touches(gpu_cell_bounds b, gpu_bound light) {
    float radius = cell_radius(light);
    for (int i = 0; i < 4; i++)
        if (dot(b.planes[i].xyz, light.center) + b.planes[i].w < -radius) return false;
    vec3 outside = max(max(b.low - light.center, light.center - b.high), vec3(0.0));
    return !(dot(outside, outside) > radius * radius) && !(b.low.z > b.high.z);
}

#include "passes/lights/cells_reach.glsl"

#endif
