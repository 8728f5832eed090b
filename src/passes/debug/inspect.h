/* SPDX-License-Identifier: MIT */
/**
 * What a frame does at one pixel: draws the surface there with all that shading knows of it, evaluates each of its lights alone, and asks the list by
 * which it was shaded. Cost: the scene's vertices once (twice with layers), a work group that walks the lists; of more than INSPECT_LIGHTS lights that
 * reach the surface nine more walks find the strongest.
 */
#ifndef FNL_PASSES_INSPECT_H
#define FNL_PASSES_INSPECT_H

#include "passes/debug/inspect_shared.h"
#include "passes/geometry/geometry.h"
#include "passes/lighting/lighting.h"

/** What is found, on the device and for the CPU. */
struct inspected {
    struct gpu_inspected pixel;
    struct gpu_inspect_light lights[INSPECT_LIGHTS];
};

struct inspect_input {
    const struct geometry_scene *scene;
    const struct geometry_draws *draws;
    const struct gpu_view *view;
    VkDeviceAddress view_address;
    uint32_t x, y;
    bool layered;                   /* some material has layers */
    const struct lighting *whole; /* that serves every surface of the pixel, by whose lights it is evaluated */
    const struct lighting *own;   /* by which it was shaded; NULL: none */
    bool own_skips_layered;         /* surfaces with layers were shaded by `whole` */
    graph_buffer counters;          /* two words a pixel, the first of them lights that were visited without a list; or id 0 */
    graph_buffer out;               /* struct inspected */
};
void inspect_add(struct graph *graph, gpu_device *device, const struct inspect_input *input);

#endif
