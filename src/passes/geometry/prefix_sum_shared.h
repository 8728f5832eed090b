/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_PREFIX_SUM_SHARED_H
#define FNL_PASSES_PREFIX_SUM_SHARED_H

#include "shared.h"

#define PREFIX_SUM_BLOCK 1024u

struct gpu_prefix_sum_push {
    ADDRESS(uint_array) values; /* replaced by their exclusive sums */
    ADDRESS(uint_array) blocks; /* one sum per block, or 0 */
    uint count;
};

#endif
