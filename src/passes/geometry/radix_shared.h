/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_RADIX_SHARED_H
#define FNL_PASSES_RADIX_SHARED_H

#include "shared.h"

#define RADIX_BITS 4u
#define RADIX_DIGITS 16u
#define RADIX_THREADS 64u
#define RADIX_ITEMS 16u   /* that one thread takes */
#define RADIX_BLOCK 1024u /* that a work group takes */

struct gpu_radix_push {
    ADDRESS(uint_array) in_pairs;   /* key, value */
    ADDRESS(uint_array) out_pairs;
    ADDRESS(uint_array) counts;     /* digit * block_count + block */
    ADDRESS(const_uint_array) count; /* number of pairs, where counted is 1 */
    uint counted;
    uint capacity;                   /* … or that of pairs */
    uint block_count;
    uint shift;
};

#endif
