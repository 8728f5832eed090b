/* SPDX-License-Identifier: MIT */
/** What is seen behind everything: each sample of `radiance` whose depth is empty. Cost: a texel for each of those pixels. */
#ifndef FNL_PASSES_SKY_H
#define FNL_PASSES_SKY_H

#include "passes/ambient/environment.h"

struct sky_params {
    bool gradient; /* instead of the environment, which may be absent */
    float blur;    /* the angle over which the environment is blurred, radians */
};
void sky_add(struct graph *graph, const struct environment_light *environment, const struct sky_params *params, VkDeviceAddress view,
             graph_image radiance, graph_image depth);

#endif
