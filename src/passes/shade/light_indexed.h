/* SPDX-License-Identifier: MIT */
/**
 * Light-indexed shading (Trebilco, "Light Indexed Deferred Rendering", 2008): where depth is complete, the volumes of lights write ids, and
 * forward shading looks its lights up in those of its pixel.
 */
#ifndef FNL_PASSES_LIGHT_INDEXED_H
#define FNL_PASSES_LIGHT_INDEXED_H

#include "passes/shade/light_indexed_shared.h"
#include "passes/shade/sample_bounds.h"
#include "passes/shade/shade.h"
#include "passes/shade/volumes.h"

struct indexed_params {
    uint32_t packing; /* INDEXED_…; default INDEXED_IDS */
    uint32_t layers;  /* 1 .. INDEXED_LAYERS, default 4. Per layer: four ids per pixel (ids), four sets (sets), otherwise an RGBA8 image for 255 lights */
    const struct gpu_entity_bounds *bounds; /* sets: bounds of the local lights */
    const vec4 *planes;                     /* sets: as in light_sets.h; NULL: all lights are drawn */
    uint32_t plane_count;
};
/** Whether the device has the stencil format that INDEXED_STENCIL needs. */
bool light_indexed_stencil_supported(const gpu_device *device);
/** Data for the lights of several samples per pixel. With one sample, all fields except without_set are 0. */
struct indexed_samples {
    uint32_t without_set; /* out, with any number of samples: lights without a place in a set */
    struct sample_bounds bounds;
    VkDeviceAddress all; /* struct gpu_lighting of a list of one cell, with all lights */
};
/**
 * A list with a cell for each pixel. Pixels that more lights may reach than fit use all lights, and count as overflow cells, exactly. Needs
 * a complete depth. Cost: a fragment for each light and pixel that its volume covers, 8 bytes a pixel, and 6 for each light that
 * fits (4 and 8 more a layer with images). With several samples a pixel it has all lights that may reach any of them; `samples` is filled.
 */
struct lighting light_indexed_add(struct graph *graph, gpu_device *device, const struct shade_input *input,
                                    const struct volumes *volumes, const struct lighting *scopes, graph_image depth,
                                    const struct indexed_params *params, struct indexed_samples *samples);
/** Draws the opaque set into `radiance`, which it clears, by such a list of several samples a pixel in input->lights. */
void light_indexed_samples_add(struct graph *graph, const struct shade_input *input, const struct indexed_samples *samples,
                               graph_image radiance, graph_image depth);

#endif
