#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Gives each sample the radiance of its triangle: one fragment for each that a pixel may show.
#include "common.glsl"
#include "scene.glsl"
#include "view.glsl"
#include "passes/visibility/visible.glsl"

layout(push_constant, scalar) uniform push_block { gpu_visible_push push; };
layout(location = 0) flat in uint in_slot;
layout(location = 0) out vec4 out_radiance;

void main() {
    // Helpers beyond the edge of the picture load too, and addresses have no bounds.
    uvec2 size = push.view.view.size, at = min(uvec2(gl_FragCoord.xy), size - 1u);
    uint samples = surface_samples(push.words.at[at.y * size.x + at.x], in_slot);
    gl_SampleMask[0] = int(samples); // none: the pixel does not show so many
    out_radiance = vec4(0.0);
    if (samples != 0u) out_radiance = vec4(result_at(push.results, push.sums.at[place_of_pixel(at, size)] + in_slot), 1.0);
}
