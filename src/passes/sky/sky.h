/* SPDX-License-Identifier: MIT */
/** The environment as it is seen behind everything: each sample of `radiance` whose depth is empty. Cost: a texel for each of those pixels. */
#ifndef FNL_PASSES_SKY_H
#define FNL_PASSES_SKY_H

#include "passes/ambient/environment.h"

void sky_add(struct graph *graph, const struct environment_light *environment, VkDeviceAddress view, graph_image radiance, graph_image depth);

#endif
