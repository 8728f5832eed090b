#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
#ifdef DAIS_QUADS
#extension GL_KHR_shader_subgroup_quad : require
#endif
// References into a render target of as many samples as the picture has. Shading samples are each pixel's own; with DAIS_QUADS
// squares of four pixels share them.
#include "passes/dais/dais_store.glsl"

layout(location = 0) out uint out_reference;
layout(location = 1) out uint out_sample;

void main() {
    uint reference = fragment_reference();
    out_reference = reference;
    out_sample = SHARED_SAMPLES == 1u ? shading_sample(reference) : 0u;
}
