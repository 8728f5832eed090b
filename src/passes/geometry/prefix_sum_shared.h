/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_PREFIX_SUM_SHARED_H
#define FNL_PASSES_PREFIX_SUM_SHARED_H

#include "shared.h"

#define PREFIX_SUM_BLOCK 1024u

#ifdef GL_core_profile
// Sums end at 2^32 - 1 instead of wrapping; that is as associative as addition is.
uint add_saturated(uint a, uint b) { return a + min(b, ~a); }
#endif

struct gpu_prefix_sum_push {
    ADDRESS(uint_array) values; /* replaced by their exclusive sums */
    ADDRESS(uint_array) blocks; /* one sum per block, or 0 */
    uint count;
};

#endif
