// SPDX-License-Identifier: MIT
// Places of up to RADIX_BLOCK items of one work group by one digit, in their order: what every stable radix sort here is made of. Needs no
// subgroups: each thread counts the digits of consecutive items, and the counts of all threads are summed.
#ifndef RADIX_GLSL
#define RADIX_GLSL

#include "passes/geometry/radix_shared.h"

// Halves of words for two digits, even and odd: few words, for shared memory limits how many groups run at a time. Word
// [digit / 2 * threads + thread]: first items of the thread with the digit, then how many lie before them in the block.
const uint RADIX_LIMIT = 32768u; // items between radix_clear() and radix_sum(): their numbers fit into halves
const uint RADIX_RUN = RADIX_DIGITS / 2u, RADIX_RUNS = RADIX_THREADS / RADIX_RUN; // words of a row that a thread sums, and how many in a row
shared uint radix_counts[RADIX_DIGITS / 2u * RADIX_THREADS];

uint radix_digit(uint key, uint shift) { return key >> shift & (RADIX_DIGITS - 1u); }
uint radix_half(uint word, uint digit) { return word >> (digit & 1u) * 16u & 0xffffu; }

void radix_clear() {
    for (uint d = 0u; d < RADIX_DIGITS / 2u; d++) radix_counts[d * RADIX_THREADS + gl_LocalInvocationIndex] = 0u;
}

// The next place of the calling thread for a digit, in the block.
uint radix_take(uint digit) {
    uint at = digit / 2u * RADIX_THREADS + gl_LocalInvocationIndex, word = radix_counts[at];
    radix_counts[at] = word + (1u << (digit & 1u) * 16u);
    return radix_half(word, digit);
}

void radix_count(uint digit) { radix_take(digit); }

// Sums the runs; after it, and before radix_spread(), radix_total() of any digit is known. For all threads of the group. The sum of a run stands in
// its first word, before which there is nothing.
void radix_sum() {
    barrier();
    uint first = gl_LocalInvocationIndex * RADIX_RUN, sum = radix_counts[first];
    for (uint i = 1u; i < RADIX_RUN; i++) {
        uint count = radix_counts[first + i];
        radix_counts[first + i] = sum;
        sum += count;
    }
    radix_counts[first] = sum;
    barrier();
}

uint radix_total(uint digit) {
    uint sum = 0u;
    for (uint i = 0u; i < RADIX_RUNS; i++) sum += radix_counts[(digit / 2u * RADIX_RUNS + i) * RADIX_RUN];
    return radix_half(sum, digit);
}

// Makes radix_take() right. For all threads of the group, after radix_sum().
void radix_spread() {
    uint thread = gl_LocalInvocationIndex, before = 0u;
    for (uint q = thread / RADIX_RUNS * RADIX_RUNS; q < thread; q++) before += radix_counts[q * RADIX_RUN];
    barrier();
    radix_counts[thread * RADIX_RUN] = before;
    for (uint i = 1u; i < RADIX_RUN; i++) radix_counts[thread * RADIX_RUN + i] += before;
    barrier();
}

#endif
