/* SPDX-License-Identifier: MIT */
/** Decals in a frame: which way they take, and their list. */
#ifndef FNL_RENDER_DECALS_H
#define FNL_RENDER_DECALS_H

#include "render/frame_state.h"

/** Whether a later pass applies boxes and volumes to the G-buffer. */
bool decals_in_gbuffer(const struct frame_state *f);

/** Applies boxes and volumes to a G-buffer that was just laid; where they take another way, nothing. */
void decals_on_gbuffer_add(struct frame_state *f, const struct shade_input *input, const struct gbuffer *gbuffer);
/** Whether the frame has decals that are drawn over finished surfaces. */
bool decals_redraws(const struct frame_state *f);
/** Draws redrawn decals over lit opaque surfaces. */
void decals_redraw(struct frame_state *f, const struct shade_input *input);
/** How many boxes and volumes hold what each pixel shows: a uint a pixel, for the debug view. */
graph_buffer decals_count_add(struct frame_state *f);

#endif
