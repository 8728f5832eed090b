#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Level 2 of the pyramid of normals: octahedral ones cannot be averaged as they are, so each texel is the sum over 4 x 4 pixels. Sky counts
// for nothing.
#include "common.glsl"
#include "passes/lights/backface.glsl"

layout(local_size_x = 64) in; // one thread a texel
layout(push_constant, scalar) uniform push_block { gpu_cells_push push; };

void main() {
    uint index = LINEAR_INVOCATION;
    uvec2 size = push.view.view.size, blocks = (size + 3u) / 4u;
    if (index >= blocks.x * blocks.y) return;
    uvec2 first = uvec2(index % blocks.x, index / blocks.x) * 4u, end = min(first + 4u, size);
    vec3 sum = vec3(0.0);
    for (uint y = first.y; y < end.y; y++)
        for (uint x = first.x; x < end.x; x++)
            if (texelFetch(textures[push.depth], ivec2(x, y), 0).r > 0.0)
                sum += gbuffer_normal(BACKFACE.gbuffer, ivec2(x, y));
    BACKFACE.blocks.at[index] = sum;
}
