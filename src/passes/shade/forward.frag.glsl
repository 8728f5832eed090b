#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Forward shading. Cutouts that write depth themselves: their depth test has to wait for the holes.
// EARLY_DEPTH, everything else: hidden fragments are not shaded, and so not counted, although counting has side effects.
// EARLY_DEPTH and HOLES_ARE_CUT, cutouts whose depth is complete, with several samples a pixel: what is left of a fragment is no hole. Asked
// again at the middle of what is left, the texture might say otherwise, and the background would show.
#ifdef EARLY_DEPTH
layout(early_fragment_tests) in;
#endif
#include "passes/shade/forward.glsl"

layout(push_constant, scalar) uniform push_block { gpu_geometry_push push; };

layout(location = 0) out vec4 out_radiance;

void main() {
    float view_depth;
    out_radiance = forward_shade(push, view_depth);
}
