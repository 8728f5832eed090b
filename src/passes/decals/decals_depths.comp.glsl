#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Between which view depths the surfaces of a tile are.
#include "common.glsl"
#include "decals.glsl"
#include "passes/decals/decals_pass_shared.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_decals_box_push push; };

void main() {
    uvec2 tile = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(tile, push.tiles))) return;
    vec2 depths = vec2(1e38, -1e38);
    uvec2 end = min((tile + 1u) * DECAL_TILE, push.view.view.size);
    for (uint y = tile.y * DECAL_TILE; y < end.y; y++)
        for (uint x = tile.x * DECAL_TILE; x < end.x; x++) {
            float depth = texelFetch(textures[push.depth], ivec2(x, y), 0).r;
            if (depth <= 0.0) continue; // sky
            float view_depth = view_depth_of(push.view, depth);
            depths = vec2(min(depths.x, view_depth), max(depths.y, view_depth));
        }
    push.depths.at[tile.y * push.tiles.x + tile.x] = depths;
}
