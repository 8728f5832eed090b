/* SPDX-License-Identifier: MIT */
/** What the tests of the order mobile share. */
#ifndef FNL_TESTS_MOBILE_CASES_H
#define FNL_TESTS_MOBILE_CASES_H

#include "tests/render_harness.h"

#include <math.h>

/** Glass, cutouts and 48 lights. */
#define MOBILE_SCENE "builtin:glass?lights=48"

/** The stage's frame in the order mobile, with the picture as its only output. */
fnl_frame mobile_frame(const struct stage *stage);
/** Fails unless both pictures have the same bytes. */
void assert_same(const fnl_image *a, const fnl_image *b, const char *what);
/** Of channels of two RGBA8 pictures, 0 .. 255. */
double mean_difference(const fnl_image *a, const fnl_image *b);
/** A built-in scene whose materials are `edit`ed. */
struct stage edited_stage(const char *source, void (*edit)(struct scene_material *material, uint32_t index));

#endif
