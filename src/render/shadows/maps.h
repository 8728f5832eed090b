/* SPDX-License-Identifier: MIT */
/** Shadow maps of lights, in pages: of the methods `maps` and `hybrid`. */
#ifndef FNL_RENDER_SHADOWS_MAPS_H
#define FNL_RENDER_SHADOWS_MAPS_H

#include "passes/shadow/fill.h"
#include "passes/shadow/pages.h"
#include "render/frame_state.h"

struct shadow_maps_counts {
    struct gpu_shadow_counts pages;
};
extern const struct counter_table counters_shadow_maps;

/** Rows of maps that the scene's lights have, directional ones several each. */
uint64_t shadow_maps_rows(const fnl_renderer *r);
/** False: the method has none, the device cannot draw them, or there are more rows than room: rays find all shadows. */
bool shadow_maps_possible(const fnl_renderer *r, const fnl_frame *frame);
/** Texels along a side of the atlas. */
uint32_t shadow_maps_side(const fnl_frame *frame);

/** The depth of a view's opaque surfaces, before it is shaded: paths that have none yet get one, drawn only for shadows. */
graph_image shadows_depth(struct frame_state *f);
/** Whether lights leave the lists of tiles that lie in their shadow; where the frame has maps. */
bool shadow_maps_classify(const fnl_frame *frame);
/** Of struct shadow_method. */
fnl_result shadow_maps_prepare_view(fnl_renderer *r, const fnl_frame *frame, struct renderer_view *view);
void shadow_maps_add(struct frame_state *views, uint32_t count);

/* ---- hybrid.c ---- */

/** How many rays take as long as drawing a page, given or measured. */
float shadow_hybrid_page_rays(const fnl_renderer *r, const fnl_frame *frame);
/** Collects what later frames decide by; called after the pages of the frame's views are added. */
void shadow_hybrid_add(struct frame_state *f, const struct shadow_pages *pages, const struct shadow_fill *filled, const struct lighting *surfaces, graph_image depth);

#endif
