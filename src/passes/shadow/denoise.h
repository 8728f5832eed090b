/* SPDX-License-Identifier: MIT */
/**
 * Denoises shadows of lights that are chosen by chance (shaders/shadows/sampled.glsl). What is filtered is not radiance. A pixel knows exactly what its
 * lights give without shadows; of the chosen ones it knows what they give without and with. The ratio of those two, each filtered with the same
 * weights, is what shadows leave, and the exact light is multiplied by it: textures and highlights stay as they are. Both count as parts of the
 * pixel's light, so that a highlight weighs no more than its neighbours. Directional lights and all other light are not touched.
 *
 * 1. Over time: what the last frames kept is fetched along motion from the pixels that saw the same plane, and this frame joins the mean. Where lights
 *    have changed (the sum of their light, and of its direction, which are exact) history is shortened in proportion.
 * 2. What moves changes shadows and no light: where this frame contradicts the mean in 5x5 pixels together, by more than its noise explains, history is
 *    shortened too. Nothing of that while nothing moves: the mean is left alone and grows. Its variance follows from the mean itself.
 * 3. In space: four levels of an edge-avoiding wavelet, by plane, normal, and variance.
 *
 * Sources: Heitz, Hill and McGuire, "Combining Analytic Direct Illumination and Stochastic Shadows", I3D 2018 (the ratio); Schied et al., "Spatiotemporal
 * Variance-Guided Filtering", HPG 2017 (history, variance, wavelet); Dammertz et al., "Edge-Avoiding A-Trous Wavelet Transform for fast Global
 * Illumination Filtering", HPG 2010. Of our own: the part of all light as what is filtered, and both tests for changes.
 * Cost: 6 passes over the screen with about 30 (still: 12), 75 and 4 times 27 texel reads a pixel; 64 bytes a pixel kept, 72 more for a while.
 */
#ifndef FNL_PASSES_DENOISE_H
#define FNL_PASSES_DENOISE_H

#include "base/maths.h"
#include "graph/graph.h"
#include "passes/shade/shade.h"
#include "passes/shadow/denoise_shared.h"
#include "view_shared.h"

/** Images for shading to write (shade_input.apart): all light in the format of `radiance`, and what struct gpu_denoise_collect_push says. */
struct shade_apart denoise_begin(struct graph *graph, graph_image radiance);

struct denoise_input {
    VkDeviceAddress view;
    const struct gpu_view *previous; /* of the last frame, without jitter; NULL: its history does not count */
    graph_image depth, motion;       /* of motion_add */
    const struct shade_apart *apart; /* written */
    uint32_t still;                  /* frames since something moved */
    bool whole;                      /* since the history began */
};
struct denoise {
    graph_image collected, variance, places; /* for denoise_view_add() */
    graph_buffer counts;                     /* struct gpu_denoise_counts */
};
/** Adds the light to `radiance`, which holds everything else. */
struct denoise denoise_add(struct graph *graph, gpu_device *device, const struct denoise_input *input, graph_image radiance);

/** A picture of the frames that pixels have collected, up to DENOISE_FRAMES, or of the standard deviation that they have left, up to a half. */
void denoise_view_add(struct graph *graph, const struct denoise *denoise, bool history, VkDeviceAddress view, graph_image target, bool swap);

#endif
