/* SPDX-License-Identifier: MIT */
/** Which views of a frame are drawn at once (fnl_frame.multiview), and the drawing. docs/techniques/views.md tells more. */
#ifndef FNL_RENDER_MULTIVIEW_H
#define FNL_RENDER_MULTIVIEW_H

#include "render/frame_state.h"

/** Views that are drawn at once at most: as many as every device with multiview takes. */
enum { MULTIVIEW_MOST = 6, DISPLAY_MOST = MULTIVIEW_MOST + 1 }; /* eyes of a display, and the view of what is far away */

/** How many views of the frame, from `first` on, are drawn at once: 1 where that does not work or does not pay. */
uint32_t multiview_count(const fnl_renderer *r, const fnl_frame *frame, uint32_t first);
/** The log says once of each renderer that the device lacks what the frame asks for. */
void multiview_tell(fnl_renderer *r, const fnl_frame *frame);
/** Draws what needs no lists for `together` views, of which the first `count`, which have begun, each take their layer. */
void multiview_draw(struct frame_state *views, uint32_t count, uint32_t together);
/** Bit n: some n views of the frame are drawn at once. The scene is prepared. */
uint32_t multiview_counts(const fnl_renderer *r, const fnl_frame *frame);

/** Notes what drawing the opaque set in so many passes takes, where views are eyes, and tells `draws` what to count. */
void multiview_count_work(struct frame_state *f, struct geometry_draws *draws, uint32_t passes);

extern const struct counter_table multiview_counters;

#endif
