#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Forward shading of everything else: hidden fragments are not shaded, and so not counted, although counting has side effects.
layout(early_fragment_tests) in;
#include "passes/shade/forward.glsl"

layout(push_constant, scalar) uniform push_block { gpu_geometry_push push; };

layout(location = 0) out vec4 out_radiance;

void main() {
    float view_depth;
    out_radiance = forward_shade(push, view_depth);
}
