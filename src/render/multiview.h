/* SPDX-License-Identifier: MIT */
/** Drawing several views at once (fnl_frame.multiview, fnl_stereo_options.path). docs/techniques/views.md tells more. */
#ifndef FNL_RENDER_MULTIVIEW_H
#define FNL_RENDER_MULTIVIEW_H

#include "render/frame_state.h"

/** The plan of a frame of this renderer, on its device. The scene is prepared, nothing is auto but stereo.path and multiview. */
void multiview_plan(const fnl_renderer *r, const fnl_frame *frame, struct view_plan *out);
/** The log says once of each renderer that the device lacks what the frame asks for, and that `path` is used. */
void multiview_tell(fnl_renderer *r, const fnl_frame *frame, fnl_stereo_path path);
/** Draws what needs no lists for the views of a group at once. They have begun; each takes its layer. */
void multiview_draw(struct frame_state *views, const struct view_group *group);

#endif
