#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The depth of one surface of each pixel, in the middle of the samples that show it.
#include "common.glsl"
#include "gbuffer.glsl"
#include "passes/shade/edges.glsl"
#include "passes/shade/surface_layers_shared.h"

layout(push_constant, scalar) uniform push_block { gpu_surface_layers_push push; };

void main() {
    // Helpers beyond the edge of the picture load too, and addresses have no bounds.
    uvec2 size = push.view.view.size, at = min(uvec2(gl_FragCoord.xy), size - 1u);
    uint samples = surface_samples(push.surfaces.at[at.y * size.x + at.x], push.layer);
    if (samples == 0u) discard;
    float depth = 0.0;
    for (uint i = 0u; i < SAMPLES; i++)
        if ((samples >> i & 1u) == 1u) depth += texelFetch(textures_multisampled[push.depth], ivec2(at), int(i)).r;
    gl_FragDepth = depth / float(bitCount(samples));
}
