/* SPDX-License-Identifier: MIT */
/** Shadows in a frame: what finds them, and the maps of each view. */
#ifndef FNL_RENDER_SHADOWS_H
#define FNL_RENDER_SHADOWS_H

#include "render/frame_state.h"

/** Says what FNL_SHADOWS_AUTO is; before the frame is checked. */
void shadows_settle(const fnl_renderer *r, fnl_frame *frame);
/** Whether the times of the frame's passes are wanted. */
bool shadows_timed(const fnl_frame *frame);
/** What lasts longer than the frame, for one more view. */
fnl_result shadows_prepare_view(fnl_renderer *r, const fnl_frame *frame, struct renderer_view *view);
#endif
