/* SPDX-License-Identifier: MIT */
/**
 * Decals in the G-buffer (RTR4 20.2; Persson 2011): boxes are drawn once it is laid, and change what it says before it is lit. A box's
 * back faces are drawn to a grid of tiles of 8x8 pixels, a little larger, and find those that it touches between their least and greatest
 * depth; decals are counted, summed up, filled into a list for each tile, and sorted by index, so that no order of atomics shows. One pass
 * then reads a copy of the G-buffer, applies to each pixel the decals of its tile that hold its surface, and packs it anew. So any blend
 * can be had, normals are combined in tangent space, and two runs give the same bytes. Pixels without decals keep their bits.
 *
 * Cost: geometry once more at equal depth (receivers and true normals: 8 bytes a pixel), two fragments and 4 bytes for each tile of a box, a
 * copy of the G-buffer, a test of each pixel against the boxes of its tile. The G-buffer must have one sample a pixel.
 */
#ifndef FNL_PASSES_DECALS_GBUFFER_H
#define FNL_PASSES_DECALS_GBUFFER_H

#include "passes/shade/gbuffer.h"

struct decals_gbuffer_input {
    struct light_input boxes;
    struct lights_in_view in_view;
    graph_buffer decals;
    VkDeviceAddress set;    /* struct gpu_decal_set */
    bool emits;             /* some decal changes emission */
    bool mip_fix;           /* see fnl_frame.decal_mip_fix */
    uint32_t pool_capacity; /* entries of all tiles; pixels of tiles that do not fit go through all decals */
};

/** What the frame's counts are copied from. */
struct decals_gbuffer_totals {
    uint32_t entries, overflow_pixels, in_view;
};

/** Changes the targets of `gbuffer`, and radiance where decals emit. Returns a struct decals_gbuffer_totals. */
graph_buffer decals_gbuffer_add(struct graph *graph, gpu_device *device, const struct shade_input *input,
                                const struct decals_gbuffer_input *decals, const struct gbuffer *gbuffer,
                                graph_image radiance);

#endif
