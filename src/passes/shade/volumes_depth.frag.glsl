#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The depth of what light volumes light; sky and what is lit forward keep the farthest.
#include "common.glsl"
#include "lights/iterate.glsl"
#include "gbuffer.glsl"
#include "passes/shade/edges.glsl"
#include "passes/shade/volumes.glsl"

layout(push_constant, scalar) uniform push_block { gpu_volume_push push; };

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    if (SAMPLES > 1u) { // of one surface of each pixel (surface_layers.h)
        uvec2 inside = min(uvec2(pixel), push.view.view.size - 1u); // helpers load too
        uint samples = surface_samples(push.words.at[inside.y * push.view.view.size.x + inside.x], push.layer);
        if (samples == 0u) discard;
        float depth = 0.0;
        for (uint i = 0u; i < SAMPLES; i++)
            if ((samples >> i & 1u) == 1u) depth += gbuffer_depth(push.gbuffer, pixel, int(i));
        gl_FragDepth = depth / float(bitCount(samples));
        return;
    }
    if (gbuffer_is_forward(push.gbuffer, pixel)) discard;
    gl_FragDepth = gbuffer_depth(push.gbuffer, pixel);
}
