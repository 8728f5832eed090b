/* SPDX-License-Identifier: MIT */
/**
 * Deferred lighting: light is summed up before the material is known (Engel, "Light Pre-Pass", 2008; RTR 4, 20.1). Three steps:
 * light_surfaces_add draws the geometry's normals and roughness, light_sums_add sums up the lights of each pixel, light_material_add draws the
 * geometry again with its materials. With `scale` above 1 light is summed up for one pixel of each square alone, and the last step filters
 * (Kircher's mixed resolutions).
 */
#ifndef FNL_PASSES_LIGHT_PREPASS_H
#define FNL_PASSES_LIGHT_PREPASS_H

#include "passes/shade/gbuffer.h"
#include "passes/shade/light_prepass_shared.h"
#include "passes/shade/surface_layers.h"

#define LIGHT_GEOMETRIC_FORMAT VK_FORMAT_R16G16_UNORM

struct light_surfaces {
    graph_image depth, normal, reflectance; /* reflectance: id 0 but with LIGHT_BUFFER_TWO */
    graph_image geometric;                  /* id 0 without GPU_FEATURE_LEANING */
    uint32_t samples;                       /* of a pixel */
    struct surface_layers layers;           /* of light_surfaces_split; else one */
};
/**
 * 8 bytes a sample beside depth, with LIGHT_BUFFER_TWO 12. With `prepass` the depth is complete and the pass tests for equality.
 * `normal` holds octahedral normals in its first two channels, as lists that ask for normals want them.
 */
struct light_surfaces light_surfaces_add(struct graph *graph, const struct shade_input *input, bool prepass, uint32_t buffer,
                                         graph_image depth);

/**
 * Tells apart what the samples of a pixel show, so that light is summed up for each of a pixel's surfaces, in a layer of sums of its own, and
 * materials take the light of their own. Without it light is summed up for the first sample alone. Nothing to do for one sample a pixel.
 */
struct edges light_surfaces_split(struct graph *graph, const struct shade_input *input, struct light_surfaces *surfaces);

/** The surfaces as lists that ask for normals see them: a G-buffer of the default layout that has nothing else. */
struct gbuffer light_surfaces_normals(const struct light_surfaces *surfaces);

/** Sums of light: 1, 2 or 4 images of four floats each. */
struct light_sums {
    uint32_t buffer, scale; /* LIGHT_BUFFER_…; pixels along a side of a texel */
    uint32_t width, height, target_count;
    uint32_t layers; /* of several samples a pixel; else 1 */
    graph_image targets[LIGHT_BUFFER_TARGETS], more[SURFACE_LAYERS - 1][LIGHT_BUFFER_TARGETS]; /* of the first layer, of others */
    graph_image samples; /* with scale above 1: which pixel of its square a texel is lit for */
};
/** Empty sums for a screen, or for `layers` of it: images that some pass has to fill. */
struct light_sums light_sums_create(struct graph *graph, const struct shade_input *input, uint32_t buffer, uint32_t scale,
                                    VkFormat format, uint32_t layers);
/** The targets of a layer. */
const graph_image *light_sums_layer(const struct light_sums *sums, uint32_t layer);
/** Sums up the lights of input->lights in a compute pass. Cost: a loop over a list per texel, and as many writes as there are targets. */
void light_sums_add(struct graph *graph, const struct shade_input *input, const struct light_surfaces *surfaces,
                    const struct light_sums *sums);
/** Draws the opaque set into `radiance`, which it clears. Where no sample of scaled sums suits a pixel, it is lit by input->lights. */
void light_material_add(struct graph *graph, const struct shade_input *input, const struct light_surfaces *surfaces,
                        const struct light_sums *sums, graph_image radiance);

/** Inside a pass that uses the surfaces: what its shaders need. */
void light_surfaces_use(struct graph_pass *pass, const struct light_surfaces *surfaces, enum graph_use use);
struct gpu_light_surfaces light_surfaces_handles(const struct graph_context *context, const struct light_surfaces *surfaces);

#endif
