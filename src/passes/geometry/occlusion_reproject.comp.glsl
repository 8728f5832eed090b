#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Where the tiles of the last frame's depth lie in this one. The farthest that lands on a tile counts; where nothing does is a hole, which is far.
#include "common.glsl"
#include "passes/geometry/hierarchy.glsl"
#include "passes/geometry/occlusion_shared.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_occlusion_push push; };

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer depth_bits { uint at[]; };

void main() {
    uvec2 tile = gl_GlobalInvocationID.xy, tiles = uvec2(push.width, push.height);
    if (any(greaterThanEqual(tile, tiles))) return;
    float stored = texelFetch(textures[push.depth], ivec2(tile), 0).r;
    if (!(stored > 0.0)) return; // the sky leaves holes
    float view_depth = view_depth_of(push.previous, stored), depth = 1.0;
    vec2 low = vec2(1e9), high = vec2(-1e9);
    for (uint i = 0u; i < 4u; i++) {
        vec2 corner = (vec2(tile) + vec2(i & 1u, i >> 1)) * float(HIERARCHY_TILE);
        vec3 seen = view_position_of(push.previous, ndc_of_pixel(push.previous, corner), view_depth);
        vec4 clip = push.view.view.world_to_clip * vec4((push.previous.view.view_to_world * vec4(seen, 1.0)).xyz, 1.0);
        if (!(clip.w > 0.0 && clip.z > 0.0 && clip.z <= clip.w)) return;
        vec2 pixel = hierarchy_pixel(push.view, clip.xy / clip.w);
        low = min(low, pixel);
        high = max(high, pixel);
        depth = min(depth, clip.z / clip.w);
    }
    low = (low + 0.25) / float(HIERARCHY_TILE); // what it meets by a hair counts not
    high = (high - 0.25) / float(HIERARCHY_TILE);
    if (any(lessThan(high, vec2(0.0))) || any(greaterThanEqual(low, vec2(tiles))) || any(greaterThan(high - low, vec2(16.0)))) return;
    uvec2 first = uvec2(max(low, vec2(0.0))), last = min(uvec2(max(high, vec2(0.0))), tiles - 1u);
    for (uint y = first.y; y <= last.y; y++)
        for (uint x = first.x; x <= last.x; x++)
            atomicMin(depth_bits(push.hierarchy).at[y * tiles.x + x], floatBitsToUint(depth)); // the bits of positive numbers ascend with them
}
