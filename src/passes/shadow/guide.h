/* SPDX-License-Identifier: MIT */
/**
 * Guides the choice of lights that are sent rays (shaders/shadows/sampled.glsl) away from those that are hidden. Unguided, a light's weight is what it gives
 * without shadows; here it is that times the square root of the part of its rays that came through in the same place in the frames before, but never less
 * than GUIDE_LEAST times. Each light's share is divided by the chance that these weights give it: whatever they are, the mean is that of all rays.
 *
 * Tiles of 8x8 pixels count rays, sent and passed, in slots that lights have by their lasting indices. A slot that two lights share, a tile that shows two
 * surfaces, and what has changed since, cost variance and nothing else. Counts fade by an eighth a frame, and follow motion.
 *
 * Why the root: a ray that comes through with chance v gives light f / p with chance p v, so that the second moment is the sum of f^2 v / p, which is least
 * for p in proportion to f sqrt(v).
 * Source: the idea is that of reservoirs with visibility in their weights (B. Bitterli et al., "Spatiotemporal Reservoir Resampling for Real-Time Ray Tracing
 * with Dynamic Direct Lighting", SIGGRAPH 2020). Those reuse chosen lights, as they do not know all lights of a pixel, and are biased unless each light that
 * is reused is sent a ray. Lists name all lights, so that visibility is all there is to reuse.
 * Cost: a pass with 10 to 13 texel reads a pixel; in shading a texel read for each weight and an atomic operation for each ray; 9 bytes a pixel.
 */
#ifndef FNL_PASSES_GUIDE_H
#define FNL_PASSES_GUIDE_H

#include "graph/graph.h"
#include "passes/shade/shade.h"

struct guide_input {
    VkDeviceAddress view;
    uint32_t width, height;
    graph_image motion; /* of motion_add; id 0: nothing has moved since the last frame */
    bool keeps;         /* the last frame counts */
    bool adverse;       /* tests: weights are nonsense */
};
/** For shading (shade_input.guide), which must follow in the same frame. */
struct shade_guide guide_add(struct graph *graph, const struct guide_input *input);

#endif
