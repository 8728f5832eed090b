#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The level of the pyramid of normals whose texels are tiles, from level 2.
#include "common.glsl"
#include "passes/lights/backface.glsl"

layout(local_size_x = 64) in; // one thread a tile
layout(push_constant, scalar) uniform push_block { gpu_cells_push push; };

void main() {
    uint cell = LINEAR_INVOCATION;
    if (cell >= push.list.list.tiles_x * push.list.list.tiles_y) return;
    uvec2 blocks = (push.view.view.size + 3u) / 4u, each = uvec2(push.list.list.tile_size / 4u);
    uvec2 first = uvec2(cell % push.list.list.tiles_x, cell / push.list.list.tiles_x) * each, end = min(first + each, blocks);
    vec3 sum = vec3(0.0);
    for (uint y = first.y; y < end.y; y++)
        for (uint x = first.x; x < end.x; x++) sum += BACKFACE.blocks.at[y * blocks.x + x];
    BACKFACE.axes.at[cell] = sum;
}
