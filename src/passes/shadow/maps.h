/* SPDX-License-Identifier: MIT */
/**
 * Shadow maps as shading reads them, and the requests that say which of their pages a frame needs. A frame makes them in this order: requests
 * of all that it shades, shadow_pages_add() (pages.h) finds a place for each page, shadow_fill_add() (fill.h) draws those that are not true any more.
 * shaders/shadows/maps_shared.h says how maps are laid out.
 *
 * Virtual shadow maps for many lights: O. Olsson et al., "Efficient Virtual Shadow Maps for Many Lights", *I3D* 2014. There, pages come from the boxes of
 * clusters; here each pixel asks for the one that it will read.
 */
#ifndef FNL_PASSES_SHADOW_MAPS_H
#define FNL_PASSES_SHADOW_MAPS_H

#include "graph/graph.h"
#include "shadows/maps_shared.h"

struct shadow_maps {
    graph_buffer held, before, pages, biases, shapes;
    graph_buffer suns; /* id 0: no light is directional */
    graph_image atlas;
    VkDeviceAddress address; /* struct gpu_shadow_maps; 0: there are none */
};
/** Declares that a pass looks up shadows in fragment or compute shaders. */
void shadow_maps_use(struct graph_pass *pass, const struct shadow_maps *maps, enum graph_use use);

struct light_list;
struct light_input;
struct rays;
struct geometry_scene;
struct geometry_draws;

/** Rows of shadow maps: those of the directional lights, then one for each local light. */
uint32_t shadow_row_count(const struct light_input *lights);
/** How the grids of the directional lights lie: a struct gpu_shadow_sun each. The tree over items is enough of `rays`. Returns id 0 where there are none. */
graph_buffer shadow_suns_add(struct graph *graph, gpu_device *device, const struct light_input *lights, const struct rays *rays);

/**
 * A page for each opaque surface in `depth` and each light of `list` that reaches it. `list` is one of tiles or of all lights, and has neither
 * GPU_LIST_RAYS nor GPU_LIST_MAPS; of its struct gpu_shadow_maps `suns` and `first_row` are read. Returns SHADOW_ROW_WORDS words for each of `row_count`
 * rows. Cost: a look at every light of the list for every 8x8 pixels; a visit of it by each of their samples only where it may reach them and some page
 * that they may need has not been asked for yet. `weighs`: behind them is a word for each row, how many pixels the local light may reach; no fewer
 * than it does, and the more by as far as its volume ends within quads of 2x2 pixels.
 */
graph_buffer shadow_requests_add(struct graph *graph, const struct light_list *list, graph_buffer suns, uint32_t row_count,
                                 graph_image depth, bool weighs);
/** The same of one more list and depth, added to `wanted`. */
void shadow_requests_more_add(struct graph *graph, const struct light_list *list, graph_buffer suns, graph_buffer wanted, graph_image depth,
                              bool weighs);
/** The same of blended surfaces, or of glass (GEOMETRY_GLASS), added to `wanted`. */
void shadow_requests_blend_add(struct graph *graph, const struct light_list *list, graph_buffer suns, graph_buffer wanted,
                               const struct geometry_scene *scene, const struct geometry_draws *draws, bool glass, VkDeviceAddress view,
                               graph_image depth, bool weighs);

#endif
