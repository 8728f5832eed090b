#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Leaves the stencil alone where there is sky, and where a forward pass lights.
#include "common.glsl"
#include "gbuffer.glsl"
#include "lights/iterate.glsl"
#include "passes/shade/deferred_screen_shared.h"

layout(push_constant, scalar) uniform push_block { gpu_deferred_screen_push push; };

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    if (gbuffer_depth(push.gbuffer, pixel) <= 0.0 || gbuffer_is_forward(push.gbuffer, pixel)) discard;
}
