#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Bounds of the tiles: the frustum of the tile between the nearest and the farthest pixel (ES-43), or as far as the flags say.
#include "common.glsl"
#include "passes/lights/cells.glsl"

layout(constant_id = 1) const uint SAMPLES = 1u;

layout(local_size_x = 8, local_size_y = 8) in; // one group a tile
layout(push_constant, scalar) uniform push_block { gpu_cells_push push; };

// Depth is reversed and not negative, so its bits order like the numbers: the greatest bits are the nearest.
shared uint nearest, farthest, sky_seen;

const float FAR_AWAY = 1e9;

void main() {
    if (gl_LocalInvocationIndex == 0u) {
        nearest = 0u;
        farthest = 0xffffffffu;
        sky_seen = 0u;
    }
    barrier();
    uint tile_size = push.list.list.tile_size;
    uvec2 first = gl_WorkGroupID.xy * tile_size, end = min(first + tile_size, push.view.view.size);
    if (push.depth != GPU_NO_DEPTH) {
        uint near_bits = 0u, far_bits = 0xffffffffu;
        for (uint y = first.y + gl_LocalInvocationID.y; y < end.y; y += 8u)
            for (uint x = first.x + gl_LocalInvocationID.x; x < end.x; x += 8u)
                for (uint s = 0u; s < SAMPLES; s++) {
                    float depth = SAMPLES > 1u ? texelFetch(textures_multisampled[push.depth], ivec2(x, y), int(s)).r
                                               : texelFetch(textures[push.depth], ivec2(x, y), 0).r;
                    if (depth <= 0.0) { // sky
                        sky_seen = 1u;
                        continue;
                    }
                    near_bits = max(near_bits, floatBitsToUint(depth));
                    far_bits = min(far_bits, floatBitsToUint(depth));
                }
        if (near_bits != 0u) {
            atomicMax(nearest, near_bits);
            atomicMin(farthest, far_bits);
        }
    }
    barrier();
    if (gl_LocalInvocationIndex != 0u) return;

    bool has_depth = push.depth != GPU_NO_DEPTH, sky = has_depth && nearest == 0u;
    float near = 0.0, far = FAR_AWAY;
    if (has_depth && !sky && (push.flags & CELLS_MIN_DEPTH) != 0u) near = view_depth_of(push.view, uintBitsToFloat(nearest)) * (1.0 - CELL_SLACK);
    if (has_depth && !sky && (push.flags & CELLS_MAX_DEPTH) != 0u) far = view_depth_of(push.view, uintBitsToFloat(farthest)) * (1.0 + CELL_SLACK);
    // Where nothing bounds the near side, transparent surfaces look lights up; before sky they may stand at any depth.
    if (sky_seen == 1u && (push.flags & CELLS_MIN_DEPTH) == 0u) far = FAR_AWAY;
    vec2 a = ndc_of_pixel(push.view, vec2(first)), b = ndc_of_pixel(push.view, vec2(end));
    gpu_cell_bounds bounds = cell_bounds(push.view, vec2(a.x, b.y), vec2(b.x, a.y), near, far);
    if (sky && (push.flags & CELLS_MIN_DEPTH) != 0u) {
        bounds.low.z = 1.0; // nothing to light: an empty cell
        bounds.high.z = -1.0;
    }
    push.cells.at[gl_WorkGroupID.y * push.list.list.tiles_x + gl_WorkGroupID.x] = bounds;
}
