/* SPDX-License-Identifier: MIT */
/** The view from the middle of the head that shows what is far away (fnl_stereo_options.mono_distance). docs/techniques/stereo.md tells more. */
#ifndef FNL_RENDER_MONO_H
#define FNL_RENDER_MONO_H

#include "render/frame_state.h"

/** The frame of a display's mono view: its camera and size, without eye-only options. A display without a mono view gets a 1 x 1 copy. */
void mono_frame(const fnl_frame *frame, const struct view_group *group, fnl_frame *out);

/** Begins the depth that a view is drawn into: of an eye (each of several at once) with the plane, of the mono view with what both eyes cover. */
void mono_begin_depth(struct frame_state *f);
/** After a view was drawn: takes that out again, for all that reads depth. */
void mono_open(struct frame_state *f);
/** Puts the mono view, which is finished, behind what the eye has. */
void mono_composite(struct frame_state *f);

#endif
