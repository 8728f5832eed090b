#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Bounds of the tiles, and of each a mask of the 32 depth cells between its nearest and its farthest pixel that hold pixels (ES-46).
#include "common.glsl"
#include "passes/lights/cells_depths.glsl"

layout(constant_id = 1) const uint SAMPLES = 1u;

layout(push_constant, scalar) uniform push_block { gpu_cells_push push; };

#include "passes/lights/tile_depth.glsl"

shared uint occupied;

void main() {
    if (gl_LocalInvocationIndex == 0u) occupied = 0u;
    float near, far;
    bool used = tile_depths(near, far); // has barriers
    gpu_cell_bounds bounds = tile_piece(near, far, used);
    uvec2 first = tile_first(), end = tile_end();
    uint mask = 0u;
    for (uint y = first.y + gl_LocalInvocationID.y; y < end.y; y += gl_WorkGroupSize.y)
        for (uint x = first.x + gl_LocalInvocationID.x; x < end.x; x += gl_WorkGroupSize.x)
            for (uint s = 0u; s < SAMPLES; s++) {
                float depth, same;
                if (tile_surfaces(ivec2(x, y), int(s), depth, same)) mask |= 1u << depth_cell(bounds, view_depth_of(push.view, depth));
            }
    if (mask != 0u) atomicOr(occupied, mask);
    barrier();
    if (gl_LocalInvocationIndex != 0u) return;
    push.cells.at[tile_index()] = bounds;
    push.extra.at[tile_index()] = SAMPLES > 1u ? occupied | occupied << 1 | occupied >> 1 : occupied; // see TILE_SLACK
}
