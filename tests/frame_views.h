/* SPDX-License-Identifier: MIT */
/** Frames with several views against as many frames with one. */
#ifndef FNL_TESTS_FRAME_VIEWS_H
#define FNL_TESTS_FRAME_VIEWS_H

#include "tests/render_harness.h"

enum { VIEWS_MOST = 6 };

/** Round what the stage's camera looks at: near and far, one orthographic and one off-axis, so that no two show or cull alike. */
void views_place(const struct stage *stage, fnl_camera cameras[VIEWS_MOST]);
/** Fails unless picture `view` of `all` has the bytes of `one`. */
void views_check_picture(const fnl_image *all, uint32_t view, const fnl_image *one, const char *what);
/** Renders the frame with the first `count` cameras, and then with each alone: pictures and the numbers of views are those of the frames. */
void views_check(struct stage *stage, const fnl_frame *frame, const fnl_camera *cameras, uint32_t count, const char *what);

#endif
