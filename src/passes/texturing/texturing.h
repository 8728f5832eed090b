/* SPDX-License-Identifier: MIT */
/**
 * Deferred texturing with bindless textures: the geometry pass writes texture coordinates with their gradients, the tangent frame and the
 * material, and reads no texture but the alpha of cutouts; a compute pass reads the textures of what is seen and shades it (Pettineo,
 * "Bindless Texturing for Deferred Rendering and Decals", 2016; RTR 4, 20.5).
 */
#ifndef FNL_PASSES_TEXTURING_H
#define FNL_PASSES_TEXTURING_H

#include "passes/shade/shade.h"
#include "passes/texturing/virtual.h"
#include "passes/texturing/texturing_shared.h"
#include "passes/visibility/visible.h"

struct texturing {
    graph_image depth;
    graph_image targets[TEXTURING_TARGETS]; /* texturing_shared.h */
    uint32_t target_count, form, samples;
    uint32_t bytes;                         /* of a pixel, all samples, depth left out */
    struct virtual_frame pages;             /* of virtual texturing */
    bool shows_levels;                      /* virtual texturing: levels of detail instead of radiance */
};

/**
 * Draws the opaque set into targets and depth, with as many samples as depth has. With `prepass` depth is complete. `derived`: gradients of coordinates are not
 * stored but taken from neighbours. Cost: all attributes; 26 bytes a pixel, 22 derived (2 more beyond 65 536 materials), more with a second set of
 * coordinates (16, derived 8), vertex colours (8) or decals (up to 32); with several samples 28 for each of them, derived 24, and as much more.
 */
struct texturing texturing_add(struct graph *graph, const struct shade_input *input, bool derived, bool prepass,
                               graph_image depth);

/**
 * The same for virtual texturing: 8 bytes a pixel (vertex colours and decals as above). Marks the pages that it wants, drawn or hidden by what is
 * drawn later. `name` is the pass's.
 */
struct texturing texturing_virtual_add(struct graph *graph, const struct shade_input *input,
                                       const struct virtual_frame *pages, const char *name, bool prepass, graph_image depth);

/**
 * Reads textures and shades each pixel once into `radiance`; those that show nothing get the background. With several samples each surface that a pixel
 * shows is shaded once, at the middle of its samples: samples are of one if they store the same bits and lie in one plane. The list then has
 * words, counts and sums of them. Cost, then: all samples are read twice, a result and a word of memory for each.
 */
struct visible_list texturing_shade_add(struct graph *graph, const struct shade_input *input,
                                        const struct texturing *texturing, graph_image radiance);

/** Virtual texturing: lights forward what the atlas cannot hold, where it is nearest. Adds nothing where it holds all. */
void texturing_forward_add(struct graph *graph, const struct shade_input *input, graph_image radiance, graph_image depth);

#endif
