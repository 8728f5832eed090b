#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Counts or notes a decal at the tiles that its box touches.
#include "common.glsl"
#include "decals.glsl"
#include "passes/decals/decals_pass_shared.h"

layout(constant_id = 1) const uint FILLS = 0u;

layout(push_constant, scalar) uniform push_block { gpu_decals_box_push push; };

layout(location = 0) flat in uint in_decal;
layout(location = 1) flat in vec2 in_depths;

void main() {
    uint tile = uint(gl_FragCoord.y) * push.tiles.x + uint(gl_FragCoord.x);
    vec2 depths = push.depths.at[tile];
    if (in_depths.y < depths.x || in_depths.x > depths.y) return; // sky: the least is more than the greatest
    uint place = atomicAdd(push.counts.at[tile], 1u);
    if (FILLS == 1u && place < push.capacity) push.entries.at[place] = in_decal;
}
