/* SPDX-License-Identifier: MIT */
/**
 * Which local lights have maps, and to which rays are sent because that costs less (hybrid shadows). Everything is counted in rays: a light costs one for each pixel that
 * it reaches, or page_rays for each page that has to be drawn.
 *
 * A light that is new takes what is cheaper in this frame. Later it keeps what it has and counts its regret: by how much the other way would have been
 * cheaper, frame after frame, never below 0. Where that exceeds what all its pages cost, it switches: so much it would have lost by switching in vain. (The classical
 * strategy for two states, of which one has a price to enter: in all, no more than three times the cost of the best choice with
 * hindsight. A. Borodin, N. Linial and M. Saks, "An Optimal On-Line Algorithm for Metrical Task Systems", *JACM* 39, 1992.) What maps would cost a light that has none is all
 * pages where it has changed, else nothing. That misses what moves before it, so a light that switches back within 128 frames needs twice the regret next time, up to 64 times.
 *
 * Cost: a look at the words of each row; nothing is read back.
 */
#ifndef FNL_PASSES_SHADOW_SPLIT_H
#define FNL_PASSES_SHADOW_SPLIT_H

#include "graph/graph.h"
#include "passes/shadow/split_shared.h"

struct lighting;
struct shadow_pages;
struct shadow_fill;

struct shadow_split_input {
    float page_rays; /* rays that take as long as a page takes to draw, > 0 */
};

struct shadow_split_rows {
    graph_buffer wanted; /* of shadow_requests_add() that weighs */
    graph_buffer rows, kept, counts;
    uint32_t row_count, known_rows, sun_rows;
};
/** A step of shadow_pages_add(): takes the bits of lights that get rays, and returns a word for each row: 1 for these. */
graph_buffer shadow_split_add(struct graph *graph, const struct shadow_split_input *input, const struct shadow_split_rows *rows);

/** Counts the pages that were drawn, for the next frame's split. */
void shadow_drawn_add(struct graph *graph, const struct shadow_pages *pages, const struct shadow_fill *fill);

/**
 * Sends rays from one pixel of each 4x4 of `depth` to one of its lights, for their time alone: GRAPH_ROLE_SHADOW_PROBE. `list` is one of tiles or
 * of all lights, and has GPU_LIGHTING_RAYS.
 */
void shadow_probe_add(struct graph *graph, const struct shadow_pages *pages, const struct lighting *lighting, graph_image depth, uint32_t seed);

#endif
