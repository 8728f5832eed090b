/* SPDX-License-Identifier: MIT */
/**
 * Redrawn decals (RTR4 20.2): the triangles of a mesh that a decal touches are drawn again over the lit surface, at equal depth, as
 * surfaces of their own with the same lights, and blended by alpha. The mesh's shader knows nothing of them. Cost: an index list of the touched
 * triangles, made when the decal is; their fragments are shaded once more.
 */
#ifndef FNL_PASSES_DECALS_REDRAW_H
#define FNL_PASSES_DECALS_REDRAW_H

#include "passes/decals/decals_redraw_shared.h"
#include "passes/shade/shade.h"

struct decals_redraw {
    const struct gpu_buffer *indices; /* of the touched triangles, into their mesh */
    graph_buffer draws;               /* struct gpu_draw, in the decals' order; one instance each, numbered from 0 */
    uint32_t draw_count;
    VkDeviceAddress table; /* struct gpu_redraw, by that number */
    VkDeviceAddress set;   /* struct gpu_decal_set */
    graph_buffer decals;
};

/** Over `radiance`, with the samples of both; `depth` is that of the opaque set. */
void decals_redraw_add(struct graph *graph, const struct shade_input *input, const struct decals_redraw *redraw,
                       graph_image radiance, graph_image depth);

#endif
