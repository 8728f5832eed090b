#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Invocations of the fragment shader for visible surfaces. Surfaces are shaded by squares of 2x2 pixels, so a triangle that shows in one to
// four of them costs four invocations. Helpers cannot write; each visible fragment takes an equal part of the four.
#include "common.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#include "material.glsl"
#include "passes/geometry/geometry_shared.h"
#include "passes/lights/backface.glsl"
#include "passes/debug/debug_shared.h"

layout(early_fragment_tests) in; // hidden fragments are helpers at most
layout(push_constant, scalar) uniform push_block { gpu_geometry_push push; };

// What the neighbour in the square holds, of numbers that are 0 or 1. Their difference says it whichever of the two is first.
float across(float own) { return abs(own - abs(dFdxFine(own))); }
float down(float own) { return abs(own - abs(dFdyFine(own))); }

void main() {
    float own = gl_HelperInvocation ? 0.0 : 1.0, beside = across(own);
    float any = max(own, beside), both = own * beside;
    uint visible = uint(own + beside + down(any) + down(both) + 0.5);
    if (gl_HelperInvocation) return;
    uvec2 pixel = uvec2(gl_FragCoord.xy);
    atomicAdd(push.counters.at[pixel.y * push.view.view.size.x + pixel.x], 4u * GPU_OVERSHADING_UNIT / max(visible, 1u));
}
