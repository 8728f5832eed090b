#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Counts the surfaces of each pixel that nothing opaque hides, and finds the most.
#include "common.glsl"
#include "view.glsl"
#include "lights/iterate.glsl"
#include "material.glsl"
#include "passes/transmission/transmission_shared.h"

layout(early_fragment_tests) in;
layout(push_constant, scalar) uniform push_block { gpu_transmission_count_push push; };

void main() {
    material_array materials = push.geometry.scene.scene.materials;
    if ((materials.at[in_ids.x].flags & GPU_MATERIAL_MASK) != 0u && material_cut(materials, in_ids.x, material_base_color(materials, in_ids.x).a)) discard;
    uvec2 pixel = uvec2(gl_FragCoord.xy);
    uint before = atomicAdd(push.geometry.counters.at[pixel.y * push.geometry.view.view.size.x + pixel.x], 1u);
    atomicAdd(push.totals.at[0], 1u);
    atomicMax(push.totals.at[1], before + 1u);
}
