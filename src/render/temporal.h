/* SPDX-License-Identifier: MIT */
/** What a renderer remembers from frame to frame to follow surfaces: the last view, and how far it has come with its jitter. */
#ifndef FNL_RENDER_TEMPORAL_H
#define FNL_RENDER_TEMPORAL_H

#include "render/frame_state.h"

/** Whether the frame needs motion vectors. */
bool temporal_needs_motion(const fnl_frame *frame);
/** Decides, once updates of the scene are declared, what of the last frame counts; fills f->temporal. */
void temporal_begin(struct frame_state *f);
/** The frame's camera, its depth fitted to the scene (view_fit_depth). */
fnl_camera frame_camera(const struct frame_state *f);
/** Motion vectors, with f->depth, for what needs them before the frame is shaded; fills f->temporal.motion. */
void temporal_add_motion(struct frame_state *f);
#endif
