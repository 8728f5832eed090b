/* SPDX-License-Identifier: MIT */
#include "passes/lights/cells.h"
#include "shaders.h"

struct light_list halfz_add(struct graph *graph, gpu_device *device, const struct light_input *input,
                            const struct lights_in_view *in_view, graph_image depth, const struct tiled_params *params) {
    if (!depth.id) return tiled_add(graph, device, input, in_view, depth, params); /* nothing to split */
    struct cells_build build = tiled_build(graph, device, input, depth, params);
    build.what = "halfz";
    build.bounds_shader = &shader_halfz_bounds_comp;
    build.flags |= CELLS_MIN_DEPTH | CELLS_MAX_DEPTH;
    build.extra_bytes = (uint64_t)build.bounds_groups_x * build.bounds_groups_y * 4;
    if (build.header) build.header->slices = 2;
    struct light_list list = cells_add(graph, input, in_view, &build);
    list.kind = GPU_LIST_HALVES;
    return list;
}
