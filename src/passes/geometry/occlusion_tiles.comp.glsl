#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The farthest depth in each square of 8 x 8 pixels.
#include "common.glsl"
#include "passes/geometry/hierarchy.glsl"
#include "passes/geometry/occlusion_shared.h"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_occlusion_push push; };

shared float farthest[64];

void main() {
    uint thread = gl_LocalInvocationIndex;
    uvec2 tile = gl_WorkGroupID.xy;
    ivec2 pixel = ivec2(min(tile * HIERARCHY_TILE + uvec2(thread % 8u, thread / 8u), push.view.view.size - 1u));
    float depth = 1.0;
    if (push.samples > 1u)
        for (uint i = 0u; i < push.samples; i++) depth = min(depth, texelFetch(textures_multisampled[push.depth], pixel, int(i)).r);
    else
        depth = texelFetch(textures[push.depth], pixel, 0).r;
    farthest[thread] = depth;
    for (uint step = 32u; step > 0u; step /= 2u) {
        barrier();
        if (thread < step) farthest[thread] = min(farthest[thread], farthest[thread + step]);
    }
    if (thread > 0u) return;
    push.hierarchy.at[tile.y * push.width + tile.x] = farthest[0];
    imageStore(images[push.tiles], ivec2(tile), vec4(farthest[0]));
}
