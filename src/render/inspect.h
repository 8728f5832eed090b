/* SPDX-License-Identifier: MIT */
/** The pixel that a frame is asked for (fnl_frame.pixel). */
#ifndef FNL_RENDER_INSPECT_H
#define FNL_RENDER_INSPECT_H

#include "render/frame_state.h"

/** Before a frame that asks: where its answer goes, and what has to be known later of the lights as they are now. */
fnl_result inspect_prepare(fnl_renderer *r, const fnl_frame *frame);
#endif
