/* SPDX-License-Identifier: MIT */
/**
 * Debug views: pictures of what goes on inside a frame. A view has a name and a line of help in base/values.c and a row of this kind: in
 * debug_views.c if it goes with every order, else in the file of the orders that offer it.
 */
#ifndef FNL_RENDER_DEBUG_VIEWS_H
#define FNL_RENDER_DEBUG_VIEWS_H

#include "render/frame_state.h"

struct debug_view {
    fnl_debug_view view;
    bool surfaces; /* looks at the nearest surface of each pixel: f->aov is there */
    /* Draws into f->color once the frame is lit; `swap`: red and blue change places. */
    void (*add)(struct frame_state *f, bool swap);
    /* Fails, with a log line, where the frame or the device lacks what the view shows. NULL: they never do. */
    fnl_result (*check)(const struct call *call, const fnl_renderer *r, const fnl_frame *frame);
};

/** The row of a view with an order; NULL: it does not offer that. `auto` offers what all orders do. */
const struct debug_view *debug_views_find(fnl_shading shading, fnl_debug_view view);
/** Fails with a log line unless the frame's order offers the frame's view, and the frame has what it shows. */
fnl_result debug_views_check(const struct call *call, const fnl_renderer *r, const fnl_frame *frame);
/** Whether the frame's view looks at the nearest surface of each pixel. */
bool debug_views_need_surfaces(const fnl_frame *frame);
/** Draws the frame's view. */
void debug_views_add(struct frame_state *f, bool swap);
/** For rows: draws a view of debug_view.comp.glsl; counts.buffer.id 0: without numbers per pixel. */
void debug_views_add_counts(struct frame_state *f, struct debug_counts counts, bool swap);

#endif
