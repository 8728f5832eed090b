#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
#ifndef DAIS_EACH_SAMPLE
#extension GL_ARB_post_depth_coverage : require
#endif
#ifdef DAIS_QUADS
#extension GL_KHR_shader_subgroup_quad : require
#endif
// References into a list for each pixel. A triangle that covers the whole pixel stands in the head itself; others take an element each.
// Variants: DAIS_EACH_SAMPLE, where the device does not tell coverage after the depth test (an element for each sample, merged when they are
// shaded); DAIS_QUADS, squares of four pixels share shading samples.
#ifndef DAIS_EACH_SAMPLE
layout(post_depth_coverage) in;
#endif
#include "passes/dais/dais_store.glsl"

layout(constant_id = SAMPLES_ID) const uint SAMPLES = 1u;

void append(uint pixel, uint reference, uint mask, uint shading) {
    uint number = atomicAdd(push.counts.at[DAIS_NODES], 1u) + 1u;
    if (number >= push.node_capacity) {
        atomicAdd(push.counts.at[DAIS_OVERFLOW], 1u);
        atomicExchange(push.heads.at[pixel], DAIS_NO_LIST); // what others add before it does not matter
        return;
    }
    uint base = number * DAIS_NODE;
    push.nodes.at[base + 1u] = reference;
    push.nodes.at[base + 2u] = mask;
    push.nodes.at[base + 3u] = shading;
    push.nodes.at[base] = atomicExchange(push.heads.at[pixel], number);
}

void main() {
#ifdef DAIS_EACH_SAMPLE
    uint mask = 1u << gl_SampleID;
    bool full = SAMPLES == 1u;
#else
    uint mask = uint(gl_SampleMaskIn[0]);
    bool full = mask == (1u << SAMPLES) - 1u;
#endif
    uint reference = fragment_reference();
    uint shading = SHARED_SAMPLES == 1u ? shading_sample(reference) : 0u;
    if (!gl_HelperInvocation && mask != 0u) {
        uvec2 size = push.geometry.view.view.size, at = min(uvec2(gl_FragCoord.xy), size - 1u);
        uint pixel = at.y * size.x + at.x;
        // One of several that lie in one plane takes the head; the others are told from it by what was drawn last.
        bool alone = false;
        if (full) alone = atomicCompSwap(push.heads.at[pixel], 0u, DAIS_FULL | reference) == 0u;
        if (alone && SHARED_SAMPLES == 1u) push.heads.at[size.x * size.y + pixel] = shading;
        if (!alone) append(pixel, reference, mask, shading);
    }
}
