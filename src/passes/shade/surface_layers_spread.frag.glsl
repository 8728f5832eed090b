#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Gives each sample what the layer of its surface holds.
#include "common.glsl"
#include "gbuffer.glsl"
#include "passes/shade/edges.glsl"
#include "passes/shade/surface_layers_shared.h"

layout(push_constant, scalar) uniform push_block { gpu_surface_layers_push push; };
layout(location = 0) flat in uint in_slot;
layout(location = 0) out vec4 out_radiance;

void main() {
    uvec2 size = push.view.view.size, at = min(uvec2(gl_FragCoord.xy), size - 1u);
    uint samples = surface_samples(push.surfaces.at[at.y * size.x + at.x], in_slot);
    gl_SampleMask[0] = int(samples); // none: sky, or the pixel has fewer surfaces
    if (samples == 0u) discard;
    out_radiance = vec4(texelFetch(textures[nonuniformEXT(push.layers[in_slot])], ivec2(at), 0).rgb, 0.0);
}
