#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Light that changes slowly, for each shading sample: what its surface gets from all around. It takes the reference's place.
#include "passes/dais/dais_surface.glsl"
#include "shade.glsl"
#include "passes/dais/log_luv.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_dais_shade_push push; };

void main() {
    uint number = LINEAR_INVOCATION, end = min(push.counts.at[DAIS_SAMPLES] + 1u, push.sample_capacity);
    if (number == 0u || number >= end) return;
    uint reference = push.samples.at[2u * number], place = push.samples.at[2u * number + 1u];
    dais_interpolate(push.view, push.pool, reference, vec2(place & 0xffffu, place >> 16) + 0.5);
    material_array materials = push.scene.scene.materials;
    surface s = material_surface(materials, in_ids.x);
    push.samples.at[2u * number] = log_luv_encode(ambient_diffuse(push.view, s.normal));
}
