#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Lists the surfaces beyond the first of each pixel, pixel by pixel, and sizes the dispatch that shades them.
#include "common.glsl"
#include "view.glsl"
#include "passes/shade/edges_shared.h"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_edges_push push; };

void main() {
    uint pixel = LINEAR_INVOCATION, pixels = push.view.view.size.x * push.view.view.size.y;
    if (pixel == 0u) {
        uint groups = (push.sums.at[pixels] + 63u) / 64u, wide = min(groups, 32768u);
        push.dispatch.at[0] = wide;
        push.dispatch.at[1] = wide == 0u ? 0u : (groups + wide - 1u) / wide;
        push.dispatch.at[2] = 1u;
    }
    if (pixel >= pixels) return;
    uint first = push.sums.at[pixel], end = push.sums.at[pixel + 1u];
    for (uint i = first; i < end; i++) push.entries.at[i] = pixel | (i - first + 1u) << 28;
}
