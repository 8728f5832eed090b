/* SPDX-License-Identifier: MIT */
/** The G-buffer: what is seen at each pixel, for shading that comes later. */
#ifndef FNL_PASSES_GBUFFER_H
#define FNL_PASSES_GBUFFER_H

#include "gbuffer_shared.h"
#include "passes/shade/shade.h"

struct gbuffer {
    graph_image depth;
    graph_image targets[GBUFFER_TARGETS]; /* id 0 from target_count on */
    uint32_t target_count;
    graph_image normal; /* the one of the targets that gbuffer_normal() of shaders/gbuffer.glsl reads */
};

/**
 * Draws the opaque set: 16 bytes a pixel beside depth and radiance, which takes the emission (layout in shaders/gbuffer.glsl).
 * Has the samples of `depth`. With `prepass` the depth is complete and the pass tests for equality (ES-4e): no hidden surface reads its textures; geometry
 * is drawn twice.
 */
struct gbuffer gbuffer_add(struct graph *graph, const struct shade_input *input, bool prepass, graph_image radiance,
                           graph_image depth);
/** Declares that a pass samples all of it. */
void gbuffer_use(struct graph_pass *pass, const struct gbuffer *gbuffer, enum graph_use use);
/** Inside such a pass: what its shaders need. */
struct gpu_gbuffer gbuffer_handles(const struct graph_context *context, const struct gbuffer *gbuffer);

#endif
