/* SPDX-License-Identifier: MIT */
/**
 * Temporal antialiasing. Every frame samples its pixels at another place (pixel_jitter); the samples of a surface are collected along its
 * motion.
 *
 * While nothing moves, a pixel is the plain mean of all frames since then. Otherwise what was collected is fetched from where the
 * nearest surface of the 3x3 pixels was (cubic, Catmull-Rom), dropped where the last frame saw nothing of that depth or motion there, clipped to
 * the spread of colours of the 3x3 pixels in this frame (mean and standard deviation in YCoCg), and counts for at most 16 frames, 6 where it
 * moves by a pixel a frame or more, as each fetch between texels blurs a little. Means are
taken of what the tone mapper makes of radiance, so that bright edges stay smooth and a still picture becomes the mean
 * of its frames' pictures; what is stored and returned is the radiance that maps to it (tone_space.glsl: exact for no operator and for
 * Khronos neutral, near for the others).
 *
 * Sources: Karis, High Quality Temporal Supersampling, SIGGRAPH 2014; Salvi, An Excursion in Temporal Supersampling, GDC 2016; Lottes, TXAA 2012.
 * Cost: a pass over the screen with up to 40 texel reads a pixel (while nothing moves, 3), two images of 16 and two of 8 bytes a pixel.
 */
#ifndef FNL_PASSES_TAA_H
#define FNL_PASSES_TAA_H

#include "base/maths.h"
#include "graph/graph.h"

struct taa_params {
    VkDeviceAddress view;
    graph_image depth, motion; /* of motion_add */
    graph_buffer exposure;     /* of exposure_add; id 0: `factor` */
    float factor;
    uint32_t tonemap; /* GPU_TONEMAP_…: what will become of the radiance */
    bool keeps;       /* the history of the last frame is of this sequence */
    bool still;       /* and nothing moved since */
};
/** Returns the collected radiance, RGBA32F. */
graph_image taa_add(struct graph *graph, graph_image radiance, const struct taa_params *params);

#endif
