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
 * Compares every list once with `all`, each with one of the shading orders; the next call takes other orders. With one sample a pixel it renders
 * every order with all lights too: the orders agree.
 */
void pairs_check_orders(struct stage *stage, fnl_frame frame);

/**
 * Fails unless the calls before have seen, with one sample a pixel or with several, each list with one in `part` of the orders that it can be
 * compared in, and each order with one in `part` of its lists. 1: every pair.
 */
void pairs_check_tried(uint32_t msaa, uint32_t part);

#endif
