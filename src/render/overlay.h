/* SPDX-License-Identifier: MIT */
/** What is drawn over the picture (fnl_frame.overlay). */
#ifndef FNL_RENDER_OVERLAY_H
#define FNL_RENDER_OVERLAY_H

#include "render/frame_state.h"

/** Sends the image where it is another one; outside of frames. */
fnl_result overlay_prepare(fnl_renderer *r, const fnl_frame *frame);
/** Draws it over f->color. */
void overlay_draw(struct frame_state *f);

#endif
