/* SPDX-License-Identifier: MIT */
/**
 * Shadow maps as shading reads them. A frame makes them in this order: requests of all that it shades (requests.h), shadow_pages_add() (pages.h) finds a place
 * for each page, shadow_fill_add() (fill.h) draws those that are not true any more. shaders/shadows/maps_shared.h says how maps are laid out.
 *
 * Virtual shadow maps for many lights: O. Olsson et al., "Efficient Virtual Shadow Maps for Many Lights", *I3D* 2014. There, pages come from the boxes of
 * clusters; here each pixel requests the page that it will sample.
 */
#ifndef FNL_PASSES_SHADOW_MAPS_H
#define FNL_PASSES_SHADOW_MAPS_H

#include "graph/graph.h"
#include "shadows/maps_shared.h"

struct shadow_maps {
    graph_buffer held, before, pages, biases, shapes;
    graph_buffer suns; /* id 0: no light is directional */
    graph_buffer keys, planes; /* id 0: no sun has oblong blocks */
    graph_image atlas;
    VkDeviceAddress address; /* struct gpu_shadow_maps; 0: there are none */
};
/** Declares that a pass looks up shadows in fragment or compute shaders. */
void shadow_maps_use(struct graph_pass *pass, const struct shadow_maps *maps, enum graph_use use);

#endif
