#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The depth of what light volumes light; sky and what is lit forward keep the farthest.
#include "common.glsl"
#include "lights/iterate.glsl"
#include "gbuffer.glsl"
#include "passes/shade/volumes.glsl"

layout(push_constant, scalar) uniform push_block { gpu_volume_push push; };

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    if (gbuffer_is_forward(push.gbuffer, pixel)) discard;
    gl_FragDepth = gbuffer_depth(push.gbuffer, pixel);
}
