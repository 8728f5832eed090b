/* SPDX-License-Identifier: MIT */
/**
 * Blended surfaces without sorting items. Both draw the blended set over `radiance` behind an opaque `depth` of the same size and
 * number of samples, shaded as forward_add() shades it (passes/shade/shade.h), which is the third way: items back to front.
 */
#ifndef FNL_PASSES_TRANSPARENCY_H
#define FNL_PASSES_TRANSPARENCY_H

#include "passes/shade/shade.h"

/**
 * Weighted blended order-independent transparency (McGuire and Bavoil 2013, "Weighted Blended Order-Independent Transparency", JCGT 2(2)):
 * one pass adds up weighted colours, and the logarithms of what stays open; a second one puts the mean of the colours over the picture.
 * Exact where one surface covers a sample; else the order is a guess by distance. Two surfaces in either order give the same bits; with
 * more, sums differ in their rounding. Cost: one shading per fragment, weighted_bytes() per sample.
 */
void weighted_add(struct graph *graph, const struct shade_input *input, bool half, graph_image radiance, graph_image depth);
/** `half`: of 16-bit sums, which devices get that cannot blend 32-bit ones. They tell distances apart between 0.35 and 22 m only. */
bool weighted_needs_half(const gpu_device *device);
uint32_t weighted_bytes(bool half);
/** The first of its two passes: weighted colours and weights; in red, minus the logarithm of what stays open. For those that go on by themselves. */
struct weighted_sums {
    graph_image sum, density;
};
struct weighted_sums weighted_sums_add(struct graph *graph, const struct shade_input *input, bool half, graph_image depth);

/**
 * Lists of all fragments of a pixel (Yang et al. 2010, "Real-Time Concurrent Linked List Construction on the GPU", EGSR), here without
 * links: fragments are counted, a prefix sum gives each pixel its piece of the pool, a second pass over the blended geometry shades and
 * writes them, and the last sorts them per sample. Ties go by item and triangle, then by colour, so the order of writing does not
 * show. Exact for any number of surfaces that intersect in any way. Where the pool does not hold the pixel's fragments they are blended in
 * the order of their draws, to the bit as forward_add() does. With MSAA fragments carry their samples and the slope of their depth:
 * order and visibility are found at each sample. Cost: geometry twice, one shading per fragment, linked_bytes() each, and 8 bytes per pixel.
 */
struct linked_params {
    uint32_t capacity; /* fragments that the pool holds, 1 .. LINKED_CAPACITY_MAX */
};
#define LINKED_CAPACITY_MAX (1u << 28)

/** What the GPU counts. */
struct linked_totals {
    uint32_t fragments, longest; /* fragments that pass the depth test in at least one sample; saturates */
    uint32_t overflow_pixels;    /* of which the pool did not hold all fragments */
};
struct linked_lists {
    graph_buffer totals; /* struct linked_totals */
    uint64_t byte_count; /* of the pool and its lists */
};
struct linked_lists linked_add(struct graph *graph, const struct shade_input *input, const struct linked_params *params,
                               graph_image radiance, graph_image depth);
/** Bytes that the pool takes for a fragment. */
uint32_t linked_bytes(uint32_t samples);

/** Counts blended fragments that no opaque surface hides: one uint per pixel, single-sampled, whatever way they are blended. */
graph_buffer layers_add(struct graph *graph, const struct geometry_scene *scene, const struct geometry_draws *draws,
                        VkDeviceAddress view, uint32_t width, uint32_t height);

#endif
