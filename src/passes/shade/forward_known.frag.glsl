#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Forward shading of cutouts whose depth is complete, with several samples a pixel: what is left of a fragment is no hole. Asked again at
// the middle of what is left, the texture might say otherwise, and the background would show.
#define HOLES_ARE_CUT
layout(early_fragment_tests) in;
#include "passes/shade/forward.glsl"

layout(push_constant, scalar) uniform push_block { gpu_geometry_push push; };

layout(location = 0) out vec4 out_radiance;

void main() {
    float view_depth;
    out_radiance = forward_shade(push, view_depth);
}
