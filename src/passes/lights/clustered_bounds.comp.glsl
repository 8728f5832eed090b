#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Bounds of the clusters: tiles times slices of view depth (ES-50). Slice 0 begins at the viewer and the last one never ends.
#include "common.glsl"
#include "passes/lights/cells.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_cells_push push; };

const float FAR_AWAY = 1e9;

void main() {
    uint cell = LINEAR_INVOCATION;
    if (cell >= push.cell_count) return;
    gpu_light_list list = push.list.list;
    uint tile_x = cell % list.tiles_x, tile_y = cell / list.tiles_x % list.tiles_y, slice = cell / (list.tiles_x * list.tiles_y);
    float near = slice == 0u ? 0.0 : slice_start(push.list, slice) * (1.0 - CELL_SLACK);
    float far = slice + 1u == list.slices ? FAR_AWAY : slice_start(push.list, slice + 1u) * (1.0 + CELL_SLACK);
    vec2 first = vec2(tile_x, tile_y) * float(list.tile_size), end = min(first + float(list.tile_size), vec2(push.view.view.size));
    vec2 a = ndc_of_pixel(push.view, first), b = ndc_of_pixel(push.view, end);
    push.cells.at[cell] = cell_bounds(push.view, vec2(a.x, b.y), vec2(b.x, a.y), near, far);
}
