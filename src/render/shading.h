/* SPDX-License-Identifier: MIT */
/**
 * Drawing and shading a view, whichever the path: what all paths share, and the call of the frame's own row (struct order of orders/order.h).
 */
#ifndef FNL_RENDER_SHADING_H
#define FNL_RENDER_SHADING_H

#include "passes/shade/edges_shared.h"
#include "passes/transmission/transmission.h"
#include "passes/transparency/transparency.h"
#include "render/frame_state.h"
#include "render/surfaces.h"
#include "render/traits.h"

/** Counts that orders share. Orders with MSAA copy `edges` (passes/shade/edges_shared.h). */
struct shading_counts {
    uint32_t edges[EDGES_COUNTS];
    struct linked_totals blend, blend_behind; /* and of those behind glass */
    struct transmission_totals transmission;
};
extern const struct counter_table counters_shading;

/** Whether the debug view of lights, or the pixel that is asked for, shows counts of this very frame's volumes. */
bool shading_shows_volumes(const fnl_frame *frame);
/** Whether the environment is seen behind everything. */
bool shading_shows_sky(const struct frame_state *f);
/** Where nothing opaque is seen. An order that draws blended surfaces itself calls it before them; a second call does nothing. */
void shading_add_sky(struct frame_state *f);
/** The frame's background in place of auto, and of what its scene does not have. Captures of reflection probes show the environment. */
fnl_background shading_background(const struct frame_state *f);
/** The format of the radiance target. */
VkFormat shading_format(const struct frame_state *f);

/** Fills in what of f->shared depends on the order, before it is sent. */
void shading_begin(struct frame_state *f);
/**
 * Draws what needs no lists, with f->draws. These may be of several views; targets then have a layer for each. Makes f->radiance and f->depth.
 */
void shading_draw(struct frame_state *f);
/** The view takes its layer of what was drawn for several, of which it is one. */
void shading_take_layer(struct frame_state *f, const struct frame_state *together, uint32_t layer);

/** Draw calls of the frame so declared. */
uint32_t shading_draw_count(const struct frame_state *f);

#endif
