#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Counts the blended fragments of every pixel that are not hidden. Sums of ones are the same in whatever order they come.
#include "common.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#include "material.glsl"
#include "passes/geometry/geometry_shared.h"

layout(early_fragment_tests) in;
layout(push_constant, scalar) uniform push_block { gpu_geometry_push push; };

void main() {
    material_array materials = push.scene.scene.materials;
    if (material_culled(materials, in_ids.x)) discard;
    uvec2 pixel = uvec2(gl_FragCoord.xy);
    atomicAdd(push.counters.at[pixel.y * push.view.view.size.x + pixel.x], 1u);
}
