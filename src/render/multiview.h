/* SPDX-License-Identifier: MIT */
/** Drawing several views at once (fnl_frame.multiview, fnl_stereo_options.path). docs/techniques/views.md tells more. */
#ifndef FNL_RENDER_MULTIVIEW_H
#define FNL_RENDER_MULTIVIEW_H

#include "render/frame_state.h"

/** Plans a frame for the renderer's device. The scene is prepared; only stereo.path and multiview may be auto. */
void multiview_plan(const fnl_renderer *r, const fnl_frame *frame, struct view_plan *out);
/** Logs once per renderer that the device lacks a requested feature and that `path` is used. */
void multiview_tell(const struct frame_state *shared, fnl_stereo_path path);
/** Draws what needs no lists for the views of a group at once. They have begun; each takes its layer. */
void multiview_draw(struct frame_state *views, const struct view_group *group);

#endif
