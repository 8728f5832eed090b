/* SPDX-License-Identifier: MIT */
/**
 * Visibility buffer: the geometry pass stores which triangle a pixel shows and nothing else; a compute pass fetches its vertices, redoes
 * the vertex work, interpolates with exact gradients and shades (Burns and Hunt, "The Visibility Buffer", JCGT 2013; RTR 4, 20.5).
 */
#ifndef FNL_PASSES_VISIBILITY_H
#define FNL_PASSES_VISIBILITY_H

#include "passes/shade/shade.h"
#include "view_shared.h"

/** Ids of what is seen: 32 bits where items and triangles fit, else 48 or 64 in two images. */
struct visibility {
    graph_image depth, ids, ids_high; /* ids_high.id 0: 32 bits */
    graph_image weights, gradients;   /* id 0: not stored */
    graph_buffer fragments;           /* where lights are counted: how often an id was written */
    bool grid;                        /* pixels are seen where visibility_grid_add has their samples */
    uint32_t triangle_bits;
};

/** Bits of an id for a scene of so many items, the largest of so many triangles: 32, 48 or 64; `out_triangle_bits` of them tell triangles. */
uint32_t visibility_bits(uint32_t item_count, uint32_t triangle_count, uint32_t *out_triangle_bits);

/**
 * Draws the opaque set into ids and depth, of one or several samples; cutouts are tested here. The device needs fnl_device_info.primitive_ids. `bits` 48 or
 * 64 makes ids wider than they need to be; 0: as wide as they need to be. With `weights` and one sample it stores where in its triangle a
 * pixel is, too: weights of two corners and how they change (after T. Stachowiak, "A Deferred Material Rendering System", 2015); shading then
 * takes positions from depth and fetches none; 16 bytes more a pixel, and a geometry shader, which tells the corners apart. Cost: of attributes only the position is read, but for cutouts; 4 to 8
 * bytes a pixel. Knows several views (cull_views_add), without weights and counters: depth then has a layer for each, and so have the ids.
 */
struct visibility visibility_add(struct graph *graph, const struct shade_input *input, uint32_t bits, bool weights,
                                 graph_image depth);
/** The buffer of one view, taken from one that was drawn for several. */
struct visibility visibility_layer(struct graph *graph, const struct visibility *visibility, uint32_t layer);

/** Whether the device can do visibility_grid_add. */
bool visibility_grid_supported(const gpu_device *device);
/**
 * Fills ids and depth, of one sample, from a target of half the size with four samples a pixel: one for each pixel of the picture, but a
 * quarter of the fragments (U. Haar and S. Aaltonen, "GPU-Driven Rendering Pipelines", SIGGRAPH 2015). The standard places of samples lie a quarter of a
 * pixel right or left and above or below of the pixels' centres: there each pixel is seen, and shaded. `view` is that of the input. Cost: a pass over
 * the screen that moves the samples to their pixels.
 */
struct visibility visibility_grid_add(struct graph *graph, gpu_device *device, const struct shade_input *input,
                                      const struct gpu_view *view, uint32_t bits, graph_image depth);

/** What pixels are sorted by before they are shaded; the picture is the same. */
enum visibility_sort { VISIBILITY_SORT_OFF, VISIBILITY_SORT_CLASS, VISIBILITY_SORT_MATERIAL };

/** What there is to know of what was shaded; id 0: not known. */
struct visibility_shaded {
    graph_buffer ranges;        /* with lists: first and end of the entries of each class (visible_shared.h) */
    graph_buffer words, counts; /* with several samples: samples_shared.h */
};

/**
 * Shades each pixel once into `radiance`, or, with several samples, each triangle that a pixel shows once, at the middle of its samples; those
 * that show nothing get the background. Cost: three vertices fetched for each; with several samples a result and a word of memory each.
 */
struct visibility_shaded visibility_shade_add(struct graph *graph, const struct shade_input *input,
                                              const struct visibility *visibility, enum visibility_sort sort,
                                              graph_image radiance);

#endif
