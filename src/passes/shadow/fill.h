/* SPDX-License-Identifier: MIT */
/**
 * Draws pages of shadow maps (shadows/maps_shared.h) into the atlas: those with SHADOW_PAGE_DRAW, whose flag is cleared. Each
 * walks the tree over items for what it shows; items whose meshes are in clusters are drawn as a whole if it shows most clusters, else cluster by
 * cluster. Pairs of item and page become the instances of one indirect draw for each primitive of a group or cluster of it, so that the CPU makes
 * three draw calls whatever there is to draw. Opaque and cutout triangles cast shadows, from
 * both sides. Cost: two walks for each page that is drawn, and drawing its items; where none is drawn, a look at each page and
 * item.
 *
 * Pages that show what has changed since the last frame are drawn too: items are compared with those that were kept, and pages
 * with the boxes of those that differ, as they are and as they were. Cost, in frames in which something moved: 76 bytes kept for
 * each item, and a test for each page and changed item.
 *
 * A page whose pairs have no room keeps its flag, and the atlas does not hold it in this frame: shading must look at the flag.
 * gpu_shadow_counts.pairs says for how many pairs there should have been room. Pages are drawn in their order, at least one in
 * each frame, so that the frames that follow draw the rest even if the caller does not make more room.
 */
#ifndef FNL_PASSES_SHADOW_FILL_H
#define FNL_PASSES_SHADOW_FILL_H

#include "passes/geometry/geometry.h"
#include "passes/shadow/rays.h"
#include "shadows/maps_shared.h"

struct shadow_fill_input {
    graph_buffer shapes;           /* by row: struct gpu_shape, whose faces the pages are of. hull_count not 0: its pages stay when items move */
    const struct geometry_scene *scene;
    const struct rays *rays;       /* of the same scene; the tree over items is enough */
    graph_buffer pages;            /* struct gpu_shadow_page[page_limit] */
    graph_buffer counts;           /* struct gpu_shadow_counts: `pages` is read, `drawn` grows, `pairs` is written */
    uint32_t page_limit;
    graph_image atlas;             /* square, D32_SFLOAT; keeps what lies outside of drawn pages. The caller clears it once */
    const struct gpu_buffer *kept; /* of shadow_fill_kept_bytes() or more; what it holds belongs to the atlas */
    /* What has changed since the last frame of this atlas. First: all pages are drawn, as nothing is kept, or something that is not
       compared has changed, such as materials or vertices that do not deform. */
    bool all_changed;
    bool moved;             /* items have come, gone or moved, or what deforms has */
    uint32_t pair_capacity; /* room for pairs, 20 bytes each; there is room for as many as there are items in any case */
};

struct shadow_fill {
    graph_buffer pairs;  /* struct gpu_fill_pair */
    graph_buffer drawn;  /* numbers of the pages that are drawn, in any order */
    graph_buffer totals; /* struct gpu_fill_totals */
};

uint64_t shadow_fill_kept_bytes(uint32_t item_count);
/** The device must have fnl_device_info.clip_distances. */
struct shadow_fill shadow_fill_add(struct graph *graph, gpu_device *device, const struct shadow_fill_input *input);

#endif
