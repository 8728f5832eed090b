#version 460
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// Moves the pairs of each block to their places; equal digits keep their order.
#include "common.glsl"
#include "passes/geometry/radix.glsl"

layout(local_size_x = RADIX_THREADS) in;
layout(push_constant, scalar) uniform push_block { gpu_radix_push push; };

void main() {
    uint block = LINEAR_GROUP;
    if (block >= push.block_count) return; // the whole group
    uint count = push.counted == 1u ? min(push.count.at[0], push.capacity) : push.capacity;
    uint first = block * RADIX_BLOCK + gl_LocalInvocationIndex * RADIX_ITEMS, end = min(first + RADIX_ITEMS, count);
    radix_clear();
    for (uint i = first; i < end; i++) radix_count(radix_digit(push.in_pairs.at[i * 2u], push.shift));
    radix_sum();
    radix_spread();
    for (uint i = first; i < end; i++) {
        uint key = push.in_pairs.at[i * 2u], value = push.in_pairs.at[i * 2u + 1u], digit = radix_digit(key, push.shift);
        uint place = push.counts.at[digit * push.block_count + block] + radix_take(digit);
        push.out_pairs.at[place * 2u] = key;
        push.out_pairs.at[place * 2u + 1u] = value;
    }
}
