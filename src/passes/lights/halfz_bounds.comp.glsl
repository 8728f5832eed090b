#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Bounds of the two halves of each tile (ES-45). They meet in the middle between the nearest and the farthest pixel, and each reaches only
// as far into the gap as its own pixels do. A pixel that rounding may send to either half counts for both.
#include "common.glsl"
#include "passes/lights/cells.glsl"

layout(constant_id = 1) const uint SAMPLES = 1u;

layout(push_constant, scalar) uniform push_block { gpu_cells_push push; };

#include "passes/lights/tile_depth.glsl"

shared uint near_half_far, far_half_near;

void main() {
    if (gl_LocalInvocationIndex == 0u) {
        near_half_far = 0xffffffffu;
        far_half_near = 0u;
    }
    float near, far;
    bool used = tile_depths(near, far); // has barriers
    float split = 0.5 * (near + far);
    uvec2 first = tile_first(), end = tile_end();
    uint own_far = 0xffffffffu, own_near = 0u;
    for (uint y = first.y + gl_LocalInvocationID.y; y < end.y; y += gl_WorkGroupSize.y)
        for (uint x = first.x + gl_LocalInvocationID.x; x < end.x; x += gl_WorkGroupSize.x)
            for (uint s = 0u; s < SAMPLES; s++) {
                float depth, same;
                if (!tile_surfaces(ivec2(x, y), int(s), depth, same)) continue;
                float view_depth = view_depth_of(push.view, depth);
                if (view_depth <= split * (1.0 + CELL_SLACK)) own_far = min(own_far, floatBitsToUint(depth));
                if (view_depth >= split * (1.0 - CELL_SLACK)) own_near = max(own_near, floatBitsToUint(depth));
            }
    if (own_far != 0xffffffffu) atomicMin(near_half_far, own_far);
    if (own_near != 0u) atomicMax(far_half_near, own_near);
    barrier();
    if (gl_LocalInvocationIndex != 0u) return;
    uint tile = tile_index(), tile_count = push.list.list.tiles_x * push.list.list.tiles_y;
    bool near_used = used && near_half_far != 0xffffffffu, far_used = used && far_half_near != 0u;
    float near_end = view_depth_of(push.view, uintBitsToFloat(near_half_far)) * (1.0 + TILE_SLACK);
    float far_start = view_depth_of(push.view, uintBitsToFloat(far_half_near)) * (1.0 - TILE_SLACK);
    push.cells.at[tile] = tile_piece(near, near_end, near_used);
    push.cells.at[tile_count + tile] = tile_piece(far_start, far, far_used);
    push.extra.at[tile] = floatBitsToUint(split);
}
