#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// How many pages of each class the faces would have at each bias.
#include "passes/shadow/pages.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_shadow_count_push push; };

void main() {
    uint face = LINEAR_INVOCATION;
    if (face >= push.face_count) return;
    uint words[SHADOW_FACE_WORDS], any_bits = 0u;
    shadow_load_face(push.wanted, face, words);
    for (uint i = 0u; i < SHADOW_FACE_WORDS; i++) any_bits |= words[i];
    if (any_bits == 0u) return;
    uint importance = atomicOr(push.rows.at[face / SHADOW_FACES], SHADOW_ROW_FACE << face % SHADOW_FACES) & SHADOW_ROW_IMPORTANCE;
    for (uint bias = 0u; bias < SHADOW_BIASES; bias++) {
        if (bias > 0u) shadow_coarsen_face(words);
        uvec4 counts = shadow_count_face(words);
        for (uint c = 0u; c < SHADOW_CLASSES; c++)
            if (counts[c] > 0u) atomicAdd(push.tallies.at[(importance * SHADOW_BIASES + bias) * SHADOW_CLASSES + c], counts[c]);
    }
}
