/* SPDX-License-Identifier: MIT */
/**
 * Requests: which pages of shadow maps (maps.h) a frame needs, and how the grids of directional lights lie.
 */
#ifndef FNL_PASSES_SHADOW_REQUESTS_H
#define FNL_PASSES_SHADOW_REQUESTS_H

#include "passes/geometry/geometry.h"
#include "passes/lighting/lighting.h"

/** Rows of shadow maps: those of the directional lights, then one for each local light. */
uint32_t shadow_row_count(const struct light_set *lights);
/** How the grids of the directional lights lie: a struct gpu_shadow_sun each. The tree over items is enough of `rays`. Returns id 0 where there are none. */
graph_buffer shadow_suns_add(struct graph *graph, const struct lighting *lighting, const struct rays *rays);

/**
 * Requests a page for each opaque surface in `depth` and each light of the list that reaches it. The list is one of
 * tiles or of all lights. `lighting` must be without GPU_LIGHTING_RAYS and GPU_LIGHTING_MAPS. Only these members of
 * its struct gpu_shadow_maps are read: `suns`, `keys`, `planes` and `planes_across` (where suns have pages), `widest`
 * and `first_row`. Only `suns`, `keys` and `planes` of `places` are read. Returns SHADOW_ROW_WORDS words for each of
 * `row_count` rows.
 *
 * Cost: a look at every light of the list for every 8x8 pixels; a visit of it by each of their samples only where it may reach them and some page
 * that they may need has not been asked for yet. `weighs`: behind them is a word for each row, how many pixels the local light may reach; no fewer
 * than it does, and the more by as far as its volume ends within quads of 2x2 pixels.
 */
graph_buffer shadow_requests_add(struct graph *graph, const struct lighting *lighting, const struct shadow_maps *places, uint32_t row_count,
                                 graph_image depth, bool weighs);
/** The same of one more list and depth, added to `wanted`. */
void shadow_requests_more_add(struct graph *graph, const struct lighting *lighting, const struct shadow_maps *places, graph_buffer wanted, graph_image depth,
                              bool weighs);
/** The same of blended surfaces, or of glass (GEOMETRY_GLASS), added to `wanted`. */
void shadow_requests_blend_add(struct graph *graph, const struct lighting *lighting, const struct shadow_maps *places, graph_buffer wanted,
                               const struct geometry_scene *scene, const struct geometry_draws *draws, bool glass, VkDeviceAddress view,
                               graph_image depth, bool weighs);

#endif
