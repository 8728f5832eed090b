#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// All levels above the first, by one work group. Tiles of the first that nothing has landed on are far.
#include "common.glsl"
#include "passes/geometry/hierarchy.glsl"
#include "passes/geometry/occlusion_shared.h"

layout(local_size_x = 256) in;
layout(push_constant, scalar) uniform push_block { gpu_occlusion_push push; };

void main() {
    uvec2 size = uvec2(push.width, push.height);
    for (uint i = gl_LocalInvocationIndex; i < size.x * size.y; i += 256u)
        if (!(push.hierarchy.at[i] <= 1.0)) push.hierarchy.at[i] = 0.0;
    uint from = 0u;
    while (size.x > 1u || size.y > 1u) {
        memoryBarrierBuffer();
        barrier();
        uvec2 half_size = (size + 1u) / 2u;
        uint to = from + size.x * size.y;
        for (uint i = gl_LocalInvocationIndex; i < half_size.x * half_size.y; i += 256u) {
            uvec2 a = uvec2(i % half_size.x, i / half_size.x) * 2u, b = min(a + 1u, size - 1u);
            push.hierarchy.at[to + i] = min(min(push.hierarchy.at[from + a.y * size.x + a.x], push.hierarchy.at[from + a.y * size.x + b.x]),
                                            min(push.hierarchy.at[from + b.y * size.x + a.x], push.hierarchy.at[from + b.y * size.x + b.x]));
        }
        from = to;
        size = half_size;
    }
}
