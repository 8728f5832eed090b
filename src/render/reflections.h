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
/** Makes the place of the view's set known to it; before the view is sent. */
fnl_result reflections_begin(struct frame_state *f);
/** The list over the boxes, and what passes that shade use. After the view was sent, before anything is drawn. */
void reflections_add_list(struct frame_state *f);
/** In a frame that captures: what the view has seen becomes a face. */
void reflections_take_face(struct frame_state *f);
/** The counters of a view. */
void reflections_note(struct frame_state *f);

#endif
