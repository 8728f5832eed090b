/* SPDX-License-Identifier: MIT */
/**
 * Forward shading that draws by light instead of by object: batches of items with like numbers of lights, and one pass per light.
 * Both need a complete depth, single-sampled, and the lists of mesh_lists.h.
 */
#ifndef FNL_PASSES_REGROUP_H
#define FNL_PASSES_REGROUP_H

#include "passes/shade/shade.h"

/**
 * Items are grouped by their number of lights on the GPU (none, 1, 2, up to 4, 8 and 16, more) and drawn by shaders whose loop has just
 * so many turns; those with fewer lights fill up with turns that do nothing (CS248, option 1). Cost besides shading: a pass over the
 * geometry that notes which item a pixel shows, since items at equal depth are no longer drawn in order.
 */
void batches_add(struct graph *graph, const struct shade_input *input, graph_image radiance, graph_image depth);

/**
 * For each light one pass over the items that it touches, added to what is there (CS248, option 2; RTR 4, 20.1), in order of the lights, into a
 * target of floats; then one that adds everything else. The CPU records a few commands for each light and bucket: it is the one kind
 * whose recording grows with the lights. `capacity`: pairs of light and item that there is room for; groups of items beyond are
 * drawn whole.
 */
void multipass_add(struct graph *graph, const struct shade_input *input, uint32_t local_count, uint32_t directional_count,
                   uint32_t capacity, graph_image radiance, graph_image depth);
/** False where lights times groups of items are too many draws, or the device cannot add floats. */
bool multipass_fits(gpu_device *device, const struct geometry_scene *scene, uint32_t local_count);
/** Indirect draw calls of the opaque set, prepass left out. */
uint32_t batches_draw_count(const struct geometry_scene *scene);
uint32_t multipass_draw_count(const struct geometry_scene *scene, uint32_t local_count, uint32_t directional_count);

#endif
