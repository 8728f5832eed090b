/* SPDX-License-Identifier: MIT */
/** Pairs of shading order and light lists for tests: every list gives the same picture as all lights. */
#ifndef FNL_TESTS_LIST_PAIRS_H
#define FNL_TESTS_LIST_PAIRS_H

#include "tests/render_harness.h"

enum { PAIRS_ALLOWED = 2 }; /* of 255, between two orders after tone mapping */

/** Names the pair, size and samples of a frame, for messages. */
const char *pair_name(const fnl_frame *frame);

/** Compares every `step`-th list of the frame's shading order with `all`, bit for bit, and hands out the picture of `all`. */
struct shot pairs_check_lists(struct stage *stage, fnl_frame frame, uint32_t step, uint32_t phase);

/**
 * Compares every list once with `all`, with the shading orders of so many turns; the next call goes on with other orders. Renders every order
 * with all lights too: with one sample a pixel the orders agree.
 */
void pairs_check_orders(struct stage *stage, fnl_frame frame, uint32_t turns);

/** Fails unless the calls before have seen every pair that can be compared, with one sample a pixel or with several. */
void pairs_check_tried(uint32_t msaa);

#endif
