/* SPDX-License-Identifier: MIT */
/** The eyes of one viewer (fnl_stereo_options): one frustum for both, and what is found once with it. docs/techniques/stereo.md tells more. */
#ifndef FNL_RENDER_STEREO_H
#define FNL_RENDER_STEREO_H

#include "render/frame_state.h"

/**
 * A view that sees all that any of the eyes sees, whatever their fields and directions: its apex lies behind them. `margin`: radians that it reaches
 * farther on each side, so that it still does if the head turns by that about any axis. Its pixels take about the angle that those of the eyes do. False: there is none, as eyes are
 * orthographic or look too far apart.
 */
bool stereo_combine(const struct gpu_view *eyes, uint32_t count, float margin, struct gpu_view *out);

/**
 * A camera in the middle of the head that sees all that any of the eyes sees from `distance` metres on; its near plane lies nearer by the part `overlap` of that. Its pixels
 * are those of the first eye for things at infinity, moved by whole ones. False: there is none, as above.
 */
bool stereo_middle(const struct gpu_view *eyes, uint32_t count, float distance, float overlap, fnl_camera *out, uint32_t *width, uint32_t *height);

/** Fills the display of `count` views whose cameras are known. */
fnl_result stereo_begin(struct frame_state *views, uint32_t count);
/** Culls for a view: for all eyes with the first, where that is possible. */
void stereo_cull(struct frame_state *f);
/** The camera that levels of detail are chosen for. */
fnl_camera stereo_head_camera(const fnl_frame *frame);
/** Whether eyes have one list of this kind. */
bool stereo_shares_list(const struct frame_state *f, fnl_light_lists lists);
/** Whether such frames are likely to have one: while pipelines are asked for, by a frame of one view. */
bool stereo_asks_list(const struct frame_state *f, fnl_light_lists lists);

#endif
