/* SPDX-License-Identifier: MIT */
/**
 * Deferred shading the traditional way: a solid drawn for each light, its contribution added up by blending
 * (Ishmukhametov, "Efficient Tile-Based Deferred Shading Pipeline", 2013, chapter 3; efficient-shading chapter of RTR 4, 20.1). The
 * G-buffer is read once for each light and pixel, and nothing is sorted into lists.
 */
#ifndef FNL_PASSES_VOLUMES_H
#define FNL_PASSES_VOLUMES_H

#include "passes/shade/gbuffer.h"
#include "passes/shade/surface_layers.h"
#include "passes/shade/volumes_shared.h"

/** Indices of both solids, front faces counter-clockwise from outside. */
#define VOLUME_INDEX_COUNT 300u
void volumes_indices(uint32_t out[VOLUME_INDEX_COUNT]);

/** The format that volumes add up in: floats of 32 bits where the device blends them, else of 16. Thousands of small
    contributions would get lost in 16 bits. */
VkFormat volumes_format(const gpu_device *device);

/**
 * One light at a time (ES-18): the first `count` local lights of the scene get a pass each, in their order, and `add` is called for each right
 * before its pass is: it may declare passes of its own, a shadow map's, and returns a mask of the picture's size, 1 in red where the light
 * is not kept off, or id 0. The graph lays the images of all lights over one another: one shadow map serves them all.
 */
struct volumes_hook {
    graph_image (*add)(struct graph *graph, uint32_t light, void *user);
    void *user;
    uint32_t count;
};

struct volumes_input {
    const struct lighting *scopes; /* what lights the view */
    VkDeviceAddress view;
    bool cull;      /* only volumes in view; default true */
    uint32_t shape; /* VOLUME_… of volumes_shared.h; default VOLUME_SOLIDS */
    uint32_t batch; /* VOLUME_SCREEN: lights added per draw, 1 .. VOLUME_BATCH_MAX; 0 (default): 1 */
    const struct volumes_hook *hook; /* NULL (default): none. VOLUME_STENCIL */
};
/** The lights whose volumes are drawn, ready to be drawn by any number of passes. */
struct volumes {
    struct lighting lighting;      /* by all lights */
    graph_buffer sums, ids,
        draws; /* two prefix sums per light; instance -> local light; indirect draws: two, then `alone` of one light */
    graph_buffer totals;           /* struct light_totals: volumes drawn, 0, 0 */
    struct gpu_slice indices;
    uint32_t shape, batch, light_count;
    const struct volumes_hook *hook;
    uint32_t
        alone; /* the first so many are drawn one by one: VOLUME_STENCIL; VOLUME_STENCIL_LIGHTS and all lights at most */
};
/** Instances ascend by light, spheres before cones (flat shapes know no cones), so that what they add up repeats to the bit. */
struct volumes volumes_prepare(struct graph *graph, gpu_device *device, const struct volumes_input *input);
/** Declares that a pass draws them; it has the depth of what is seen attached. */
void volumes_use(struct graph_pass *pass, const struct volumes *volumes);
/**
 * Inside such a pass: sets vertex shader, topology, culling and (unless it writes depth) depth test of `state` and draws every volume once. `push` begins with a
 * struct gpu_volume_head, of which the view and the counters are already set, and has `size` bytes; it is changed.
 */
void volumes_draw(const struct graph_context *context, const struct volumes *volumes, struct gpu_graphics_params *state,
                  struct gpu_volume_head *push, uint32_t size);

/** Whether the device has the format of depth and stencil that VOLUME_STENCIL needs. */
bool volumes_stencil_supported(const gpu_device *device);
/**
 * Adds all local lights to `radiance`, which holds everything else already. Cost: per light 49 vertices (cones 16, rectangles 4, octagons 8),
 * per pixel that a solid covers in front of its far side, or a flat shape not behind the surface, a read of the G-buffer and a blend.
 * VOLUME_STENCIL: two draws for each of `alone` lights, in the order of the lights. The first marks where its front faces are behind
 * the surface, the second draws its back faces where they are not in front of it and nothing is marked: surfaces inside, and those alone.
 * A mark is the light's number modulo 255, so that the stencil is cleared once for 255 lights. Beside: a copy of the depth with a stencil.
 */
void volumes_add(struct graph *graph, const struct shade_input *input, const struct volumes *volumes,
                 const struct gbuffer *gbuffer, graph_image radiance);
/** The same for several samples a pixel, each surface of which is lit once: volumes are drawn for each of `layers`, which have no depths
 *  yet. Cost beside that: a radiance image for each. */
void volumes_add_samples(struct graph *graph, const struct shade_input *input, const struct volumes *volumes,
                         const struct gbuffer *gbuffer, const struct surface_layers *layers, graph_image radiance);

#endif
