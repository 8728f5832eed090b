/* SPDX-License-Identifier: MIT */
/**
 * Inferred lighting (Kircher & Lawrance 2009): normals, depth and items are drawn at a lower resolution, blended surfaces in a stipple
 * pattern among the others; lights are summed up for each texel as in light_prepass.h; materials are drawn at full resolution, opaque and
 * blended alike, and take the light of texels around that are of the same item and surface.
 */
#ifndef FNL_PASSES_INFERRED_H
#define FNL_PASSES_INFERRED_H

#include "passes/shade/light_prepass.h"

struct inferred {
    struct light_surfaces surfaces; /* at the resolution of light, with a depth of their own */
    graph_image items;
    VkDeviceAddress low; /* the view at that resolution */
};
/** 12 bytes a texel beside depth. `low`: the input with the view and the size of light. `blend`: blended surfaces are stippled in. */
struct inferred inferred_surfaces_add(struct graph *graph, const struct shade_input *low, bool blend);
/**
 * Draws a set into `radiance`: the opaque one clears it, and wants a complete depth; the blended one is drawn over it. `sums` have
 * LIGHT_BUFFER_RGBA or LIGHT_BUFFER_FOUR. input->lights: what pixels go through that no texel suits.
 */
void inferred_material_add(struct graph *graph, const struct shade_input *input, enum geometry_set set,
                           const struct inferred *inferred, const struct light_sums *sums, graph_image radiance,
                           graph_image depth);

#endif
