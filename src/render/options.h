/* SPDX-License-Identifier: MIT */
/** The options of a frame, a row each (options.c): their ranges, and who heeds them. Combinations are checked beside what refuses them. */
#ifndef FNL_RENDER_OPTIONS_H
#define FNL_RENDER_OPTIONS_H

#include "base/check.h"
#include "fanal/renderer.h"

/** Whether all options of two frames are the same; what has no row, as cameras and outputs, is not compared. */
bool options_equal(const fnl_frame *a, const fnl_frame *b);
/** Each option in its own range. */
fnl_result options_check(const struct call *call, const fnl_frame *frame);

#endif
