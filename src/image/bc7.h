/* SPDX-License-Identifier: MIT */
/** What BC7's decoder and encoder share: modes and patterns (Khronos Data Format Specification 1.3, 20.1). */
#ifndef FNL_IMAGE_BC7_H
#define FNL_IMAGE_BC7_H

#include "image/blocks.h"

struct bc7_mode {
    uint8_t subsets, pattern_bits, rotation_bits, selection_bits, color_bits, alpha_bits, own_p, shared_p, index_bits, second_bits;
};
extern const struct bc7_mode bc7_modes[8];

/** Which of the subsets of a pattern a texel is in. */
uint32_t bc7_subset_of(uint32_t subsets, uint32_t pattern, uint32_t texel);
/** The texel of a subset whose index has one bit less: its highest bit is 0. */
uint32_t bc7_anchor_of(uint32_t subsets, uint32_t pattern, uint32_t subset);
/** Between two ends of 8 bits, by an index of 2 to 4 bits. */
uint8_t bc7_interpolate(uint32_t a, uint32_t b, uint32_t index, uint32_t bits);

#endif
