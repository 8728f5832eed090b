/* SPDX-License-Identifier: MIT */
#include "passes/lights/cells.h"
#include "shaders.h"

struct tiled_params tiled_params_default(void) {
    return (struct tiled_params){.tile_size = 16,
                                 .bounds = TILE_BOX,
                                 .min_depth = true,
                                 .max_depth = true,
                                 .cone_tests = true,
                                 .pool_capacity = 1u << 20};
}

struct cells_build tiled_build(struct graph *graph, gpu_device *device, const struct light_input *input, graph_image depth,
                               const struct tiled_params *params) {
    static const uint32_t bounds[] = {[TILE_PLANES] = CELLS_PLANES, [TILE_BOX] = 0, [TILE_RECTANGLE] = CELLS_RECTANGLE};
    struct cells_build build = {.bounds_shader = &shader_tiled_bounds_comp,
                                .depth = depth,
                                .front = params->front,
                                .flags = bounds[params->bounds] | (params->min_depth ? CELLS_MIN_DEPTH : 0) |
                                         (params->max_depth ? CELLS_MAX_DEPTH : 0) | (params->cone_tests ? CELLS_CONES : 0),
                                .pool_capacity = params->pool_capacity,
                                .bounds_samples = depth.id ? MAX(graph_image_info(graph, depth).samples, 1u) : 1,
                                .bounds_rows = CLAMP(gpu_info(device)->subgroup_size / 8, 1u, 8u)};
    build.header = light_list_header(device, input, &build.header_address);
    build.bounds_groups_x = DIVIDE_UP(input->width, params->tile_size);
    build.bounds_groups_y = DIVIDE_UP(input->height, params->tile_size);
    if (build.header) {
        build.header->tile_size = params->tile_size;
        build.header->tiles_x = build.bounds_groups_x;
        build.header->tiles_y = build.bounds_groups_y;
    }
    return build;
}

struct light_list tiled_add(struct graph *graph, gpu_device *device, const struct light_input *input,
                            const struct lights_in_view *in_view, graph_image depth, const struct tiled_params *params) {
    struct cells_build build = tiled_build(graph, device, input, depth, params);
    build.what = params->front.id ? "tiled blend" : "tiled";
    struct light_list list = cells_add(graph, input, in_view, &build);
    list.kind = GPU_LIST_TILES;
    return list;
}
