/* SPDX-License-Identifier: MIT */
/**
 * Debug views: pictures of what goes on inside a frame. A view has a name and a line of help in base/values.c and a row of this kind: in
 * debug_views.c if it goes with every order, else in the file of the orders that offer it.
 */
#ifndef FNL_RENDER_DEBUG_VIEWS_H
#define FNL_RENDER_DEBUG_VIEWS_H

#include "fanal/legend.h"
#include "render/frame_state.h"

/* What the colours mean; of a row's constants. */
struct debug_legend_color {
    float color[3];
    const char *name;
};
struct debug_legend {
    fnl_legend_kind kind;
    const char *text;
    uint32_t color_count;
    const struct debug_legend_color *colors;
    const char *low, *high; /* of a ramp */
    float from, to;         /* the part of the ramp of passes/debug/colors_shared.h between them */
    bool is_grey;           /* that brightness instead */
};
#define LEGEND_COLOR(r, g, b) {(float)(r), (float)(g), (float)(b)}
#define LEGEND_TEXT(words) {.kind = FNL_LEGEND_TEXT, .text = words}
#define LEGEND_COLORS(words, array) {.kind = FNL_LEGEND_COLORS, .text = words, .color_count = COUNT_OF(array), .colors = array}
#define LEGEND_RAMP(words, lowest, highest, first, last) {.kind = FNL_LEGEND_RAMP, .text = words, .low = lowest, .high = highest, .from = first, .to = last}
#define LEGEND_GREY(words, lowest, highest) {.kind = FNL_LEGEND_RAMP, .text = words, .low = lowest, .high = highest, .to = 1, .is_grey = true}
/* Counts from 1 to 256, on a logarithmic scale. */
#define LEGEND_COUNTS(words) LEGEND_RAMP(words, "1", "256 and more", 1.0f / DEBUG_COUNT_PARTS, 1)

struct debug_view {
    fnl_debug_view view;
    struct debug_legend legend;
    bool surfaces; /* reads the nearest surface of each pixel: f->nearest.aov exists */
    /* Draws into f->color once the frame is lit; `swap`: red and blue change places. */
    void (*add)(struct frame_state *f, bool swap);
    /* Fails, with a log line, where the frame or the device lacks what the view shows. NULL: they never do. */
    fnl_result (*check)(const struct call *call, const fnl_renderer *r, const fnl_frame *frame);
};

/** The row of a view with an order; NULL: it does not offer that. `auto` offers what all orders do. */
const struct debug_view *debug_views_find(fnl_shading shading, fnl_debug_view view);
/** Whether the frame's view looks at the nearest surface of each pixel. */
bool debug_views_need_surfaces(const fnl_frame *frame);
/** Draws the frame's view. */
void debug_views_add(struct frame_state *f, bool swap);
/** For rows: draws a view of debug_view.comp.glsl; counts.buffer.id 0: without numbers per pixel. */
void debug_views_add_counts(struct frame_state *f, struct debug_counts counts, bool swap);

#endif
