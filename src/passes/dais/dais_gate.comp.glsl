#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The draws of the forward pass: none where nothing is left to it.
#include "passes/dais/dais.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_dais_gate_push push; };

void main() {
    uint word = LINEAR_INVOCATION;
    if (word >= push.word_count) return;
    bool needed = push.counts.at[DAIS_OVERFLOW] != 0u || word % push.stride != push.place;
    push.to.at[word] = needed ? push.from.at[word] : 0u;
}
