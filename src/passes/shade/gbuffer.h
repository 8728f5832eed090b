/* SPDX-License-Identifier: MIT */
/** The G-buffer: what is seen at each pixel, for shading that comes later. */
#ifndef FNL_PASSES_GBUFFER_H
#define FNL_PASSES_GBUFFER_H

#include "gbuffer_shared.h"
#include "passes/shade/shade.h"

enum { GBUFFER_EXTRAS = 4 };

/** What an order keeps beside the layout's targets: those come after them, and a fragment shader of the order's own writes all. */
struct gbuffer_extras {
    const struct gpu_shader *fragment;
    uint32_t count;
    struct {
        const char *name; /* a literal */
        VkFormat format;
    } targets[GBUFFER_EXTRAS];
    uint32_t constant; /* GBUFFER_EXTRA_CONSTANT of that shader */
};

struct gbuffer {
    graph_image depth;
    graph_image targets[GBUFFER_TARGETS]; /* id 0 from target_count on */
    uint32_t target_count;
    graph_image normal; /* the one of the targets that gbuffer_normal() of shaders/gbuffer.glsl reads */
    graph_image extras[GBUFFER_EXTRAS]; /* gbuffer_use() and gbuffer_handles() leave them alone */
    graph_image mask;   /* R8: not 0 where hybrid_add() is to light the pixel: which item it is, in 8 bits; id 0: nowhere */
    uint32_t form;      /* how it is packed (gbuffer_shared.h) */
    VkDeviceAddress view, entries;
};

/**
 * Draws the opaque set into the targets of input->layout (gbuffer_layouts.h), and the emission into radiance. Has the samples of `depth`.
 * With `prepass` the depth is complete and the pass tests for equality (ES-4e): no hidden surface reads its textures; geometry is drawn
 * twice. Materials that the layout cannot hold are marked in the mask: lighting skips them, hybrid_add() draws them.
 * Knows several views (cull_views_add): radiance and depth then have a layer for each, and so have the targets; without decals.
 */
struct gbuffer gbuffer_add(struct graph *graph, const struct shade_input *input, bool prepass, graph_image radiance,
                           graph_image depth);
/** The G-buffer of one view, taken from one that was drawn for several; `view` is the address of the view. */
struct gbuffer gbuffer_layer(struct graph *graph, const struct gbuffer *gbuffer, uint32_t layer, VkDeviceAddress view);
/** The same with more targets, for layouts without a mask and for one view; `extras` may be NULL. */
struct gbuffer gbuffer_add_with(struct graph *graph, const struct shade_input *input, bool prepass, graph_image radiance,
                                graph_image depth, const struct gbuffer_extras *extras);
/** Declares that a pass samples all of it. */
void gbuffer_use(struct graph_pass *pass, const struct gbuffer *gbuffer, enum graph_use use);
/** Declares that a pass samples what gbuffer_normal() reads. */
void gbuffer_use_normal(struct graph_pass *pass, const struct gbuffer *gbuffer, enum graph_use use);
/** The same as rows: members of a struct gpu_gbuffer that gbuffer_block() made. */
void gbuffer_add_rows(struct graph_pass *pass, const struct gpu_gbuffer *member, const struct gbuffer *gbuffer, enum graph_use use);
void gbuffer_add_normal_rows(struct graph_pass *pass, const struct gpu_gbuffer *member, const struct gbuffer *gbuffer,
                             enum graph_use use);
/** What of it is known before images have their places. */
struct gpu_gbuffer gbuffer_block(const struct gbuffer *gbuffer);
/** Fills in one that stands in memory of the frame, for passes that declare gbuffer_use_normal(). */
void gbuffer_put_normal(struct graph *graph, struct gpu_gbuffer *place, const struct gbuffer *gbuffer);
/** Inside such passes: what their shaders need. */
struct gpu_gbuffer gbuffer_handles(const struct graph_context *context, const struct gbuffer *gbuffer);
struct gpu_gbuffer gbuffer_normal_handles(const struct graph_context *context, const struct gbuffer *gbuffer);
/** Makes a pipeline for this way of packing alone; without it shaders ask the handles. Sets the constant GBUFFER_CONSTANT of `constants`, and
 *  those from *count up to it to what shaders have by themselves. */
void gbuffer_specialise(const struct gbuffer *gbuffer, uint32_t constants[GPU_MAX_CONSTANTS], uint32_t *count);

/**
 * Lights what the mask marks, forward, where it is nearest: geometry of those materials is drawn once more, at equal depth, with the lists of
 * input->lights, and replaces what the radiance target holds there. Position and normal are those of the G-buffer, so that lists made from it
 * hold; the rest comes from the material. Adds nothing where there is no mask.
 */
void hybrid_add(struct graph *graph, const struct shade_input *input, const struct gbuffer *gbuffer, graph_image radiance);

#endif
