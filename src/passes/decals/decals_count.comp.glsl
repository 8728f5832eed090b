#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// How many decals hold what a pixel shows.
#include "common.glsl"
#include "decals.glsl"
#include "passes/decals/decals_pass_shared.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform push_block { gpu_decals_count_push push; };

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, push.view.view.size))) return;
    float view_depth = texelFetch(textures[push.normal], ivec2(pixel), 0).w;
    uint count = 0u;
    if (view_depth > 0.0)
        count = decals_count(decals_of(push.view), pixel, view_depth, texelFetch(textures[push.position], ivec2(pixel), 0).xyz);
    push.counts.at[pixel.y * push.view.view.size.x + pixel.x] = count;
}
