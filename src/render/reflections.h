/* SPDX-License-Identifier: MIT */
/**
 * Reflection probes (docs/techniques/reflection-probes.md). Each renderer keeps what they have seen. A probe is captured by frames of six views that a
 * renderer of its own makes before the frame that shows it; its maps are made as those of an environment are. Boxes ride in exact lists of each view.
 */
#ifndef FNL_RENDER_REFLECTIONS_H
#define FNL_RENDER_REFLECTIONS_H

#include "reflections_shared.h"
#include "render/frame_state.h"

/** Before a frame is made: captures what is due. Not inside of a frame. */
fnl_result reflections_capture(fnl_renderer *r, const fnl_frame *frame);
#endif
