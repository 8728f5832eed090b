/* SPDX-License-Identifier: MIT */
#include "passes/lights/cells.h"
#include "shaders.h"

struct light_list tiled25d_add(struct graph *graph, gpu_device *device, const struct light_input *input,
                               const struct lights_in_view *in_view, graph_image depth, const struct tiled_params *params) {
    if (!depth.id) return tiled_add(graph, device, input, in_view, depth, params); /* all cells may be occupied */
    struct cells_build build = tiled_build(graph, device, input, depth, params);
    build.what = "2.5d";
    build.bounds_shader = &shader_tiled25d_bounds_comp;
    build.flags |= CELLS_MIN_DEPTH | CELLS_MAX_DEPTH | CELLS_MASKS;
    build.extra_bytes = (uint64_t)build.bounds_groups_x * build.bounds_groups_y * 4;
    if (build.header) build.header->masks_depth = 1;
    struct light_list list = cells_add(graph, input, in_view, &build);
    list.kind = GPU_LIST_TILES;
    return list;
}
