/* SPDX-License-Identifier: MIT */
/**
 * Draws pages of shadow maps (shadows/maps_shared.h) into the atlas: those with SHADOW_PAGE_DRAW, whose flag is cleared. Each
 * walks the tree over items for what it shows; pairs of item and page become the instances of one indirect draw for each group
 * of items, so that the CPU makes three draw calls whatever there is to draw. Opaque and cutout triangles cast shadows, from
 * both sides. Cost: two walks for each page that is drawn, and drawing its items; where none is drawn, a look at each page and
 * item.
 *
 * Pages that show what has changed since the last frame are drawn too: items are compared with those that were kept, and pages
 * with the boxes of those that differ, as they are and as they were. Cost, in frames in which something moved: 76 bytes kept for
 * each item, and a test for each page and changed item.
 *
 * A page whose pairs have no room keeps its flag, and the atlas does not hold it in this frame: whoever samples must ask.
 * gpu_shadow_counts.pairs says for how many pairs there should have been room. Pages are drawn in their order, at least one in
 * each frame, so that the frames that follow draw the rest even if the caller does not make more room.
 */
#ifndef FNL_PASSES_SHADOW_FILL_H
#define FNL_PASSES_SHADOW_FILL_H

#include "passes/geometry/geometry.h"
#include "passes/lights/light_list.h"
#include "passes/shadow/rays.h"
#include "shadows/maps_shared.h"

struct shadow_fill_input {
    const struct light_input *lights; /* rows are its local lights */
    const struct geometry_scene *scene;
    const struct rays *rays; /* of the same scene */
    graph_buffer pages;      /* struct gpu_shadow_page[page_limit] */
    graph_buffer counts;     /* struct gpu_shadow_counts: `pages` is read, `pairs` is written */
    uint32_t page_limit;
    graph_image
        atlas; /* square, D32_SFLOAT, with contents: the caller clears it once. Outside of the pages it stays what it is */
    const struct gpu_buffer *kept; /* of shadow_fill_kept_bytes(), or more, from frame to frame */
    bool
        all_changed; /* nothing is kept, or what is not compared has changed (vertices that do not deform, materials): all pages are drawn */
    bool moved;             /* or items have come, gone or moved since the last frame, or deforming vertices have */
    uint32_t pair_capacity; /* room for pairs, 16 bytes each; at least as many as items are made */
};

struct shadow_fill {
    graph_buffer pairs;  /* struct gpu_fill_pair */
    graph_buffer totals; /* struct gpu_fill_totals */
};

uint64_t shadow_fill_kept_bytes(uint32_t item_count);

/** The device has fnl_device_info.clip_distances. */
struct shadow_fill shadow_fill_add(struct graph *graph, gpu_device *device, const struct shadow_fill_input *input);

#endif
