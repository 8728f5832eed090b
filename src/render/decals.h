/* SPDX-License-Identifier: MIT */
/** Decals in a frame: which way they take, and their list. */
#ifndef FNL_RENDER_DECALS_H
#define FNL_RENDER_DECALS_H

#include "render/frame_state.h"

/** Sends changed decals, once for all views. */
fnl_result decals_send(struct frame_state *f);
/** Makes the place of the decals' set known to the view; before the view is sent. */
fnl_result decals_begin(struct frame_state *f);
/** The list over their boxes, and what the shaders of the scene do for them. After the view was sent, before anything is drawn. */
fnl_result decals_add_list(struct frame_state *f);
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
