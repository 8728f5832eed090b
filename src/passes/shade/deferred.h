/* SPDX-License-Identifier: MIT */
/** Deferred shading in one pass: one compute thread a pixel reads the G-buffer once and sums up all lights. */
#ifndef FNL_PASSES_DEFERRED_H
#define FNL_PASSES_DEFERRED_H

#include "passes/shade/gbuffer.h"

struct shade_classes;
/** `classes` (classify.h) may be NULL: one shader for all pixels. */
void deferred_add(struct graph *graph, const struct shade_input *input, const struct gbuffer *gbuffer,
                  const struct shade_classes *classes, graph_image radiance);

#endif
