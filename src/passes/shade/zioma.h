/* SPDX-License-Identifier: MIT */
/**
 * Layers of lights (Zioma, "Reverse Extruded Light Volumes", ShaderX 4, 2006; RTR 4, 20.1): where depth is complete, the volumes of lights
 * leave direction, colour and attenuation at the pixels that they reach, peeled into layers by light index, and forward shading reads those.
 */
#ifndef FNL_PASSES_ZIOMA_H
#define FNL_PASSES_ZIOMA_H

#include "passes/shade/shade.h"
#include "passes/shade/volumes.h"
#include "passes/shade/zioma_shared.h"

/**
 * Draws the opaque set into `radiance`, which it clears. `layers`: 1 .. ZIOMA_LAYERS lights a pixel; where more reach it, the others are
 * looked for among all lights: the picture is right, and volumes->totals counts such pixels as overflow, and all lights that reach pixels as entries. Cost:
 * 36 bytes a pixel and layer; every volume is drawn once for each layer. With several samples a pixel layers hold the lights whose spheres may
 * reach any of them (sample_bounds.h), in 4 bytes a pixel, and each surface asks those for itself.
 */
void zioma_add(struct graph *graph, const struct shade_input *input, const struct volumes *volumes, uint32_t layers,
               graph_image radiance, graph_image depth);

#endif
