#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Gives samples the radiance of their triangle: one fragment for each slot of a pixel.
#include "passes/dais/dais_pixel.glsl"

layout(push_constant, scalar) uniform push_block { gpu_dais_shade_push push; };
layout(location = 0) flat in uint in_slot;
layout(location = 0) out vec4 out_radiance;

void main() {
    // Helpers beyond the edge of the picture load too, and addresses have no bounds.
    uvec2 size = push.view.view.size, at = min(uvec2(gl_FragCoord.xy), size - 1u);
    uint mask = surface_samples(push.slots.at[at.y * size.x + at.x], in_slot);
    gl_SampleMask[0] = int(mask);
    out_radiance = vec4(0.0);
    if (mask != 0u) out_radiance = vec4(result_at(push.results, in_slot * size.x * size.y + at.y * size.x + at.x), 1.0);
}
