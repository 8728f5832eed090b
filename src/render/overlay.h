/* SPDX-License-Identifier: MIT */
/** What is drawn over the picture (fnl_frame.overlay). */
#ifndef FNL_RENDER_OVERLAY_H
#define FNL_RENDER_OVERLAY_H

#include "render/frame_state.h"

/** FNL_ERROR_INVALID where a draw reaches outside of the arrays, or the image cannot be one. */
fnl_result overlay_check(const struct call *call, const fnl_frame *frame);
/** Sends the image where it is another one; outside of frames. */
fnl_result overlay_prepare(fnl_renderer *r, const fnl_frame *frame);
/** Draws it over f->color. */
void overlay_draw(struct frame_state *f);
void overlay_finish(fnl_renderer *r);

#endif
