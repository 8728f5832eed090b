/* SPDX-License-Identifier: MIT */
/** Steps of a frame, in the order of frame.c, that have files of their own. */
#ifndef FNL_RENDER_FRAME_STEPS_H
#define FNL_RENDER_FRAME_STEPS_H

#include "render/frame_state.h"

/** Culls the opaque scene: fills f->draws (culling.c). */
void frame_cull(struct frame_state *f);
/** Whether a debug view or an output of the frame looks at the nearest surface of each pixel (picture.c). */
bool frame_shows_surfaces(const fnl_frame *frame);
/** Makes the picture, or the debug view in its place, at the size of f->target, and what goes over it: fills f->color (picture.c). */
void frame_add_picture(struct frame_state *f);
/** Copies the picture into f->target (picture.c). */
void frame_add_target(struct frame_state *f);
/** Copies the outputs asked for to where the CPU reads them (outputs.c). */
void frame_add_outputs(struct frame_state *f);
/** Copies exact counts of this very frame there (outputs.c). */
void frame_add_counts(struct frame_state *f);
/** Notes what the CPU knows for the stats before the GPU has run (outputs.c). */
void frame_note_stats(struct frame_state *f);

#endif
