// SPDX-License-Identifier: MIT
// Places of up to RADIX_BLOCK items of one work group by one digit, in their order: what every stable radix sort here is made of. Needs no
// subgroups: each thread counts the digits of consecutive items, and the counts of all threads are summed.
#ifndef RADIX_GLSL
#define RADIX_GLSL

#include "passes/geometry/radix_shared.h"

// counts[digit * threads + thread]: first items of the thread with the digit, then how many lie before them in the block.
shared uint radix_counts[RADIX_DIGITS * RADIX_THREADS];
shared uint radix_quarters[RADIX_THREADS]; // of each digit's row

uint radix_digit(uint key, uint shift) { return key >> shift & (RADIX_DIGITS - 1u); }

void radix_clear() {
    for (uint d = 0u; d < RADIX_DIGITS; d++) radix_counts[d * RADIX_THREADS + gl_LocalInvocationIndex] = 0u;
}

void radix_count(uint digit) { radix_counts[digit * RADIX_THREADS + gl_LocalInvocationIndex]++; }

// The next place of the calling thread for a digit, in the block.
uint radix_take(uint digit) { return radix_counts[digit * RADIX_THREADS + gl_LocalInvocationIndex]++; }

// Sums the quarter rows; after it, radix_total() of any digit is known. For all threads of the group.
void radix_sum() {
    barrier();
    uint thread = gl_LocalInvocationIndex, first = thread * RADIX_DIGITS, sum = 0u;
    for (uint i = 0u; i < RADIX_DIGITS; i++) {
        uint count = radix_counts[first + i];
        radix_counts[first + i] = sum;
        sum += count;
    }
    radix_quarters[thread] = sum;
    barrier();
}

uint radix_total(uint digit) {
    uint q = digit * 4u;
    return radix_quarters[q] + radix_quarters[q + 1u] + radix_quarters[q + 2u] + radix_quarters[q + 3u];
}

// Makes radix_take() right. For all threads of the group, after radix_sum().
void radix_spread() {
    uint thread = gl_LocalInvocationIndex, before = 0u;
    for (uint q = thread & ~3u; q < thread; q++) before += radix_quarters[q];
    for (uint i = 0u; i < RADIX_DIGITS; i++) radix_counts[thread * RADIX_DIGITS + i] += before;
    barrier();
}

#endif
