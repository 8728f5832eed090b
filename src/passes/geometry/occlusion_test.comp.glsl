#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Stands in for occlusion_levels.comp.glsl: all levels above the first are far, and hide nothing.
#include "common.glsl"
#include "passes/geometry/hierarchy.glsl"
#include "passes/geometry/occlusion_shared.h"

layout(local_size_x = 256) in;
layout(push_constant, scalar) uniform push_block { gpu_occlusion_push push; };

void main() {
    uvec2 size = uvec2(push.width, push.height);
    uint first = size.x * size.y, end = first;
    while (size.x > 1u || size.y > 1u) {
        size = (size + 1u) / 2u;
        end += size.x * size.y;
    }
    for (uint i = gl_LocalInvocationIndex; i < end; i += 256u)
        if (i >= first || !(push.hierarchy.at[i] <= 1.0)) push.hierarchy.at[i] = 0.0;
}
