/* SPDX-License-Identifier: MIT */
#include "passes/lights/clustered.h"

#include "passes/lights/cells.h"
#include "shaders.h"

struct clustered_params clustered_params_default(void) {
    return (struct clustered_params){
        .tile_size = 64, .slices = 32, .near = 0.5f, .far = 100, .cone_tests = true, .pool_capacity = 1u << 20};
}

void clustered_grid(struct gpu_light_list *header, uint32_t width, uint32_t height, const struct clustered_params *params) {
    header->tile_size = params->tile_size;
    header->tiles_x = DIVIDE_UP(width, params->tile_size);
    header->tiles_y = DIVIDE_UP(height, params->tile_size);
    header->slices = params->slices;
    /* slice(near) = 1 and slice(far) = slices - 1: the first and the last slice are open-ended (ES-51). */
    float inner = (float)MAX(params->slices, 3u) - 2;
    header->linear = params->linear;
    header->slice_scale = inner / (params->linear ? params->far - params->near : log2f(params->far / params->near));
    header->slice_bias = 1 - (params->linear ? params->near : log2f(params->near)) * header->slice_scale;
}

struct light_list clustered_add(struct graph *graph, gpu_device *device, const struct light_input *input,
                                const struct lights_in_view *in_view, const struct clustered_params *params) {
    struct cells_build build = {.what = "clustered",
                                .bounds_shader = &shader_clustered_bounds_comp,
                                .bounds_samples = 1,
                                .flags = params->cone_tests ? CELLS_CONES : 0,
                                .pool_capacity = params->pool_capacity,
                                .bounds_groups_x = 1};
    build.header = light_list_header(device, input, &build.header_address);
    if (build.header) {
        clustered_grid(build.header, input->width, input->height, params);
        build.bounds_groups_x = DIVIDE_UP(build.header->tiles_x * build.header->tiles_y * build.header->slices, 64u);
    }
    struct light_list list = cells_add(graph, input, in_view, &build);
    list.kind = GPU_LIST_CLUSTERS;
    return list;
}
