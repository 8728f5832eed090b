#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference_uvec2 : require
// The pages that pixels will look up, as bits, how many each face has, and how many were not there before.
#include "passes/shadow/pages.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform push_block { gpu_shadow_hold_push push; };

// Notes it once for each light, whichever of its faces comes first.
bool is_first(uint row, uint flag) {
    uint of_light = row < push.sun_rows ? row - row % SHADOW_SUN_ROWS : row;
    return (atomicOr(push.rows.at[of_light], flag) & flag) == 0u;
}

void main() {
    uint face = LINEAR_INVOCATION, row = face / SHADOW_FACES;
    if (face >= push.face_count) return;
    gpu_shadow_choice choice = push.choice.choice;
    uint flags = push.rows.at[row], bias = shadow_bias(choice.pressure, choice.cut, choice.least, flags & SHADOW_ROW_IMPORTANCE), count = 0u;
    bool is_asked = (flags & SHADOW_ROW_FACE << face % SHADOW_FACES) != 0u, is_coarser = false;
    if (face % SHADOW_FACES == 0u) push.biases.at[row] = uvec2(push.traced) != uvec2(0u) && push.traced.at[row] != 0u ? SHADOW_TRACED : bias;
    if (is_asked && bias == SHADOW_TRACED && (flags & SHADOW_ROW_IMPORTANCE) == SHADOW_SPARE) {
        is_coarser = true;
    } else if (is_asked && bias == SHADOW_TRACED) {
        if (is_first(row, SHADOW_ROW_TRACED)) atomicAdd(push.counts.counts.traced, 1u);
    } else if (is_asked) {
        uint words[SHADOW_FACE_WORDS], bits[SHADOW_FACE_WORDS];
        shadow_load_face(push.wanted, face, words);
        bits = words;
        for (uint i = 0u; i < bias; i++) shadow_coarsen_face(bits);
        for (uint i = 0u; i < SHADOW_FACE_WORDS; i++) {
            is_coarser = is_coarser || bits[i] != words[i];
            count += bitCount(bits[i]);
            push.held.at[face * SHADOW_FACE_WORDS + i] = bits[i];
            if (row < push.last_rows) bits[i] &= ~push.last_held.at[face * SHADOW_FACE_WORDS + i];
        }
        uvec4 fresh = shadow_count_face(bits);
        for (uint c = 0u; c < SHADOW_CLASSES; c++)
            if (fresh[c] > 0u) atomicAdd(push.rooms.at[SHADOW_ROOMS + c], fresh[c]);
    }
    push.sums.at[face] = count;
    if (is_coarser && is_first(row, SHADOW_ROW_COARSENED)) atomicAdd(push.counts.counts.coarsened, 1u);
}
