#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// The pages in order, still without places, and how many there are before each word that has bits.
#include "passes/shadow/pages.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_shadow_list_push push; };

void main() {
    uint face = LINEAR_INVOCATION;
    if (face >= push.face_count) return;
    uint page = push.sums.at[face], end = push.sums.at[face + 1u], row = face / SHADOW_FACES;
    for (uint i = 0u; page < end && i < SHADOW_FACE_WORDS; i++) {
        uint word = face * SHADOW_FACE_WORDS + i, bits = push.held.at[word];
        push.before.at[word] = page;
        for (; bits != 0u; bits &= bits - 1u)
            push.pages.at[page++] = gpu_shadow_page(row, (word - row * SHADOW_ROW_WORDS) * 32u + uint(findLSB(bits)), SHADOW_NO_PLACE, 0u);
    }
}
