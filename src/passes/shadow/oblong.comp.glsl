#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Selects the pages of a sun that are in use, and the rows of their blocks; one work group per sun. A block tries one
// row per round; its key determines which. If several blocks try the same row, the greatest key gets the row. The
// result depends only on the keys, and most blocks have the same row from frame to frame.
#include "shadows/oblong.glsl"
#include "passes/shadow/oblong_shared.h"

layout(local_size_x = SHADOW_SUN_OBLONGS) in;
layout(push_constant, scalar) uniform push_block { gpu_shadow_oblong_push push; };

const uint OWN = OBLONG_FOUND / SHADOW_SUN_OBLONGS; // pages per thread
shared uint rows[SHADOW_SUN_OBLONGS], claims[SHADOW_SUN_OBLONGS], used[SHADOW_SUN_OBLONGS * 8u];

// The name of a page; 0: not in use.
uint name_at(uint sun, uint i) {
    uint at = 2u * (sun * OBLONG_FOUND + i * SHADOW_SUN_OBLONGS + gl_LocalInvocationIndex);
    return push.found.at[at + 1u] >= push.least ? push.found.at[at] : 0u;
}

void main() {
    uint thread = gl_LocalInvocationIndex, sun = gl_WorkGroupID.x, left = 0u; // bits: own pages without a row
    for (uint i = 0u; i < OWN; i++)
        if (name_at(sun, i) != 0u) left |= 1u << i;
    rows[thread] = 0u;
    for (uint i = 0u; i < 8u; i++) used[thread * 8u + i] = 0u;
    for (uint round = 0u; round < OBLONG_ROUNDS; round++) {
        claims[thread] = 0u;
        barrier();
        for (uint bits = left; bits != 0u; bits &= bits - 1u) {
            uint key = name_at(sun, uint(findLSB(bits))) >> 8, slot = shadow_oblong_slot(key, round);
            if (rows[slot] == 0u) atomicMax(claims[slot], key);
        }
        barrier();
        if (claims[thread] != 0u) rows[thread] = claims[thread];
        barrier();
        for (uint bits = left; bits != 0u; bits &= bits - 1u) {
            uint i = uint(findLSB(bits)), name = name_at(sun, i), slot = shadow_oblong_slot(name >> 8, round);
            if (rows[slot] != name >> 8) continue;
            atomicOr(used[slot * 8u + (name & 255u) / 32u], 1u << name % 32u);
            left &= ~(1u << i);
        }
        barrier();
    }
    uint first = (sun * SHADOW_SUN_OBLONGS + thread) * SHADOW_OBLONG_WORDS;
    push.keys.at[first] = rows[thread];
    for (uint i = 0u; i < 8u; i++) push.keys.at[first + 1u + i] = used[thread * 8u + i];
}
