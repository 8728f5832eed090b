/* SPDX-License-Identifier: MIT */
/**
 * Deferred lighting with volumes: lights are drawn as rectangles on the screen and blended into a diffuse and a specular buffer (Lee,
 * "Pre-lighting in Resistance 2", 2009), which materials read as those of light_prepass.h.
 */
#ifndef FNL_PASSES_PRE_LIGHTING_H
#define FNL_PASSES_PRE_LIGHTING_H

#include "passes/shade/light_prepass.h"
#include "passes/shade/volumes.h"

/** Adds all local lights to `sums`, of LIGHT_BUFFER_TWO and full resolution, layer by layer. Cost: per light and pixel of its volume two blends. */
void pre_lighting_add(struct graph *graph, const struct shade_input *input, const struct volumes *volumes,
                      const struct light_surfaces *surfaces, const struct light_sums *sums);

#endif
