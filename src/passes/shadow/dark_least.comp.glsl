#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The least depths of a page that was drawn.
#include "common.glsl"
#include "shadows/faces.glsl"
#include "passes/shadow/pages.glsl"
#include "passes/shadow/dark_shared.h"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_shadow_least_push push; };

const uint BLOCKS = SHADOW_PAGE / SHADOW_DARK_BLOCK, WIDE = SHADOW_DARK_WIDE / SHADOW_DARK_BLOCK;
shared uint least[BLOCKS * BLOCKS];

void main() {
    gpu_shadow_page page = push.pages.at[push.drawn.at[gl_WorkGroupID.x]];
    uint size = shadow_page_size(shadow_page_of(page.bit).level), thread = gl_LocalInvocationIndex;
    uvec2 first = uvec2(page.place & 0xffffu, page.place >> 16u) * SHADOW_UNIT;
    uint blocks = size / SHADOW_DARK_BLOCK, across = push.side / SHADOW_DARK_BLOCK;
    for (uint i = thread; i < blocks * blocks; i += 64u) {
        uvec2 block = uvec2(i % blocks, i / blocks);
        float depth = 1.0;
        for (uint k = 0u; k < SHADOW_DARK_BLOCK * SHADOW_DARK_BLOCK; k++) {
            uvec2 texel = first + block * SHADOW_DARK_BLOCK + uvec2(k % SHADOW_DARK_BLOCK, k / SHADOW_DARK_BLOCK);
            depth = min(depth, texelFetch(textures[push.atlas], ivec2(texel), 0).r);
        }
        least[i] = floatBitsToUint(depth);
        uvec2 at = first / SHADOW_DARK_BLOCK + block;
        push.least.at[at.y * across + at.x] = least[i];
    }
    barrier();
    uint squares = size / SHADOW_DARK_WIDE;
    for (uint i = thread; i < squares * squares; i += 64u) {
        uvec2 square = uvec2(i % squares, i / squares), at = first / SHADOW_DARK_WIDE + square;
        uint depth = 0xffffffffu;
        for (uint k = 0u; k < WIDE * WIDE; k++) {
            uvec2 block = square * WIDE + uvec2(k % WIDE, k / WIDE);
            depth = min(depth, least[block.y * blocks + block.x]);
        }
        push.least.at[across * across + at.y * (push.side / SHADOW_DARK_WIDE) + at.x] = depth;
    }
}
