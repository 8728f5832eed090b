/* SPDX-License-Identifier: MIT */
#include "passes/lights/cells.h"
#include "shaders.h"

struct light_list enhanced_add(struct graph *graph, gpu_device *device, const struct light_input *input,
                               const struct lights_in_view *in_view, const struct tiled_params *params) {
    struct tiled_params own = *params;
    own.bounds = TILE_PLANES; /* the ranges themselves are tighter than any box round an endless tile */
    own.front = (graph_image){0};
    struct cells_build build = tiled_build(graph, device, input, (graph_image){0}, &own);
    build.what = "enhanced";
    build.flags |= CELLS_RANGES;
    build.extra_bytes = MAX(build.pool_capacity, 1u) * 4ull;
    struct light_list list = cells_add(graph, input, in_view, &build);
    list.kind = GPU_LIST_RANGES;
    return list;
}
