#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Takes a pixel's id and depth from its sample.
#include "common.glsl"
#include "scene.glsl"
#include "passes/visibility/grid_shared.h"

layout(push_constant, scalar) uniform push_block { gpu_grid_push push; };
layout(location = 0) out uint out_id;
layout(location = 1) out uint out_high;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy), at = pixel >> 1;
    int place = (pixel.y & 1) * 2 + (pixel.x & 1);
    out_id = packUnorm4x8(texelFetch(textures_multisampled[push.ids], at, place));
    out_high = push.ids_high == GPU_TEXTURE_NONE ? 0u : packUnorm4x8(texelFetch(textures_multisampled[push.ids_high], at, place));
    gl_FragDepth = texelFetch(textures_multisampled[push.depth], at, place).r;
}
