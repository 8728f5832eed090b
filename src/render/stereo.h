/* SPDX-License-Identifier: MIT */
/** The eyes of one viewer (fnl_stereo_options): one frustum for both, and what is found once with it. docs/techniques/stereo.md tells more. */
#ifndef FNL_RENDER_STEREO_H
#define FNL_RENDER_STEREO_H

#include "render/frame_state.h"

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

/** Notes what drawing the opaque set in so many passes takes, where views are eyes, and tells `draws` what to count. */
void stereo_count_work(struct frame_state *f, struct geometry_draws *draws, uint32_t passes);

#endif
