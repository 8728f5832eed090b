#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Which pages of a sun are in use, and the rows of their blocks; a work group for each sun. A block tries one row after the other, as its name says. In each round
// the greatest name gets what several want. So the result depends on the names alone, and most blocks have the same row from frame to frame.
#include "shadows/oblong.glsl"
#include "passes/shadow/oblong_shared.h"

layout(local_size_x = SHADOW_SUN_OBLONGS) in;
layout(push_constant, scalar) uniform push_block { gpu_shadow_oblong_push push; };

const uint OWN = OBLONG_FOUND / SHADOW_SUN_OBLONGS; // pages that a thread takes
shared uint rows[SHADOW_SUN_OBLONGS], claims[SHADOW_SUN_OBLONGS], used[SHADOW_SUN_OBLONGS * 8u];

// 0: it is not in use.
uint name_at(uint sun, uint i) {
    uint at = 2u * (sun * OBLONG_FOUND + i * SHADOW_SUN_OBLONGS + gl_LocalInvocationIndex);
    return push.found.at[at + 1u] >= push.least ? push.found.at[at] : 0u;
}

void main() {
    uint thread = gl_LocalInvocationIndex, sun = gl_WorkGroupID.x, left = 0u; // a bit for each of the thread's pages
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
