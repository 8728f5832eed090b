#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Forward shading of cutouts that write depth themselves: their depth test has to wait for the holes.
#include "passes/shade/forward.glsl"

layout(push_constant, scalar) uniform push_block { gpu_geometry_push push; };

layout(location = 0) out vec4 out_radiance;

void main() {
    float view_depth;
    out_radiance = forward_shade(push, view_depth);
}
