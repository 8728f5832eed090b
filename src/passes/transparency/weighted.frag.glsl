#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Shades a blended fragment and gives it a weight that falls with its distance.
#include "passes/shade/forward.glsl"
#include "passes/transparency/linked.glsl"
#include "passes/transparency/transparency_draw_shared.h"

layout(early_fragment_tests) in;
layout(push_constant, scalar) uniform push_block { gpu_weighted_push push; };

// Both are added up, so no device has to blend its targets in different ways.
layout(location = 0) out vec4 out_sum;
layout(location = 1) out vec4 out_density; // red: minus the logarithm of what is left open

// A power of the distance: two surfaces share a pixel by the ratio of their distances alone, at 10 cm as at 10 km. The square is nearest
// to the truth over stacks of 2 to 8 surfaces of alpha 0.1 to 0.6 (docs/techniques/transparency.md). 16-bit sums hold a part of the range.
float weight(float view_depth) {
    float nearness = 1.0 / clamp(view_depth, 1e-3, 1e6);
    float square = nearness * nearness;
    return push.half_sums == 1u ? clamp(square, 1.0 / 512.0, 8.0) : square;
}

void main() {
    float view_depth;
    vec4 color = forward_shade(push.geometry, view_depth);
    float most = push.half_sums == 1u ? HALF_MAX / 64.0 : 1e26; // many of these still add up to a number
    out_sum = vec4(min(color.rgb, vec3(most)), color.a) * weight(view_depth);
    out_density = vec4(-log(max(1.0 - color.a, 1e-7)));
}
