#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Counts or notes a decal at the pixels whose surface its box holds.
#include "common.glsl"
#include "decals.glsl"
#include "gbuffer.glsl"
#include "passes/decals/decals_pass_shared.h"
#include "passes/decals/receivers.glsl"

layout(constant_id = 1) const uint FILLS = 0u;

layout(early_fragment_tests) in;
layout(push_constant, scalar) uniform push_block { gpu_decals_box_push push; };

layout(location = 0) flat in uint in_decal;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float depth = texelFetch(textures[push.depth], pixel, 0).r;
    if (depth <= 0.0) return; // sky
    vec3 position = gbuffer_position(push.view, pixel, view_depth_of(push.view, depth));
    decal_array decals = push.set.set.decals;
    uint receivers = receivers_bits(texelFetch(textures_uint[push.receivers], pixel, 0).xy);
    if (!decal_meets(decals, in_decal, receivers) || !decal_holds(decal_cube(decals, in_decal, position))) return;
    uint place = atomicAdd(push.counts.at[uint(pixel.y) * push.view.view.size.x + uint(pixel.x)], 1u);
    if (FILLS == 1u && place < push.capacity) push.fragments.at[place] = in_decal;
}
