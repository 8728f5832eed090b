/* SPDX-License-Identifier: MIT */
/** Shadows in a frame: what finds them, and the maps of each view. */
#ifndef FNL_RENDER_SHADOWS_H
#define FNL_RENDER_SHADOWS_H

#include "render/frame_state.h"

/** Says what FNL_SHADOWS_AUTO is; before the frame is checked. */
void shadows_settle(const fnl_renderer *r, fnl_frame *frame);
/** Whether the times of the frame's passes are wanted. */
bool shadows_timed(const fnl_frame *frame);
/** Notes what the last frame of a slot has counted, inside of the next one, and takes its times when that was executed. */
void shadows_note(fnl_renderer *r, uint32_t slot);

/** The same for one more view. */
fnl_result shadows_prepare_view(fnl_renderer *r, const fnl_frame *frame, struct renderer_view *view);
/** What all views of a frame share. */
void shadows_begin(struct frame_state *shared, struct device_scene_frame *scene);
/** The maps of a view: lists that are made afterwards cast shadows. After what is drawn before lists, before lists. */
void shadows_add(struct frame_state *f);
/** The same of the eyes of a display, which share the maps of the first. All have been drawn. */
void shadows_add_display(struct frame_state *views, uint32_t count);

/** Whether lights leave the lists of tiles that lie in their shadow; where the frame has maps. */
bool shadows_classify(const fnl_frame *frame);
/** What guides this frame, for shade_input.guide; before its surfaces are shaded. */
struct shade_guide shadows_guide(struct frame_state *f);
/** Adds to f->radiance what the order kept apart, denoised. */
void shadows_denoise(struct frame_state *f, const struct shade_apart *apart);

#endif
