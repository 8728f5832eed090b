#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Depth ranges of the tiles, and the positions that masks are tested at where they are asked for.
#include "common.glsl"
#include "passes/lights/fine_steps.glsl"
#include "passes/lights/fine_pixels.glsl"

layout(local_size_x = 8, local_size_y = 8) in; // one group a tile

shared uint nearest[2], farthest[2], sky_seen[2]; // of opaque and of blended surfaces

void main() {
    if (gl_LocalInvocationIndex < 2u) {
        nearest[gl_LocalInvocationIndex] = 0xffffffffu;
        farthest[gl_LocalInvocationIndex] = 0u;
        sky_seen[gl_LocalInvocationIndex] = 0u;
    }
    barrier();
    uint tile_size = push.list.list.tile_size, tile = gl_WorkGroupID.y * push.list.list.tiles_x + gl_WorkGroupID.x;
    uvec2 first = gl_WorkGroupID.xy * tile_size, end = min(first + tile_size, push.view.view.size);
    float near = FINE_FAR, far = -1.0, blend_near = FINE_FAR, blend_far = -1.0;
    for (uint y = first.y + gl_LocalInvocationID.y; y < end.y; y += 8u)
        for (uint x = first.x + gl_LocalInvocationID.x; x < end.x; x += 8u) {
            uvec2 pixel = uvec2(x, y);
            float view_depth, front, behind;
            bool sky, solid = fine_pixel_depth(pixel, view_depth, sky);
            if (sky) sky_seen[0] = 1u;
            if (solid) {
                near = min(near, view_depth);
                far = max(far, view_depth);
            }
            if (push.front != GPU_NO_DEPTH && fine_blended(pixel, front, behind)) {
                float front_depth = view_depth_of(push.view, front);
                blend_near = min(blend_near, front_depth);
                blend_far = max(blend_far, behind > 0.0 ? view_depth_of(push.view, behind) : front_depth);
                if (behind <= 0.0) sky_seen[1] = 1u;
            }
            if (push.list.list.positions != 0u) {
                uint at = push.list.list.positions + fine_pixel_of(push.list, tile, pixel - first) * 3u;
                vec3 p = solid ? fine_position(pixel, view_depth) : vec3(uintBitsToFloat(0x7fc00000u));
                for (uint i = 0u; i < 3u; i++) push.extra.at[at + i] = floatBitsToUint(p[i]);
            }
        }
    // Bits of numbers that are not negative order like the numbers.
    if (far >= 0.0) {
        atomicMin(nearest[0], floatBitsToUint(max(near, 0.0)));
        atomicMax(farthest[0], floatBitsToUint(far));
    }
    if (blend_far >= 0.0) {
        atomicMin(nearest[1], floatBitsToUint(max(blend_near, 0.0)));
        atomicMax(farthest[1], floatBitsToUint(blend_far));
    }
    barrier();
    uint i = gl_LocalInvocationIndex;
    if (i >= (push.front != GPU_NO_DEPTH ? 2u : 1u)) return;
    bool empty = nearest[i] == 0xffffffffu;
    push.ranges.at[i * fine_tile_count() + tile] =
        gpu_fine_range(empty ? 1.0 : uintBitsToFloat(nearest[i]), empty ? -1.0 : uintBitsToFloat(farthest[i]), sky_seen[i]);
}
