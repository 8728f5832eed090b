/* SPDX-License-Identifier: MIT */
#include "passes/visibility/grid_shared.h"

#include "passes/visibility/visibility.h"
#include "shaders.h"

bool visibility_grid_supported(const gpu_device *device) { return (gpu_info(device)->msaa_counts & 4) != 0; }

/* With an odd side the last row or column of samples lies beyond the picture. */
static fnl_result grid_view(gpu_device *device, const struct gpu_view *view, VkDeviceAddress *out) {
    struct gpu_slice slice = gpu_frame_allocate(device, sizeof *view);
    if (!slice.data) return gpu_status(device);
    struct gpu_view grid = *view;
    float x = (float)view->size.x / (float)(DIVIDE_UP(view->size.x, 2u) * 2);
    float y = (float)view->size.y / (float)(DIVIDE_UP(view->size.y, 2u) * 2);
    float *m = grid.world_to_clip.m;
    for (int column = 0; column < 4; column++) {
        float w = m[column * 4 + 3];
        m[column * 4] = m[column * 4] * x + w * (x - 1);
        m[column * 4 + 1] = m[column * 4 + 1] * y + w * (1 - y);
    }
    memcpy(slice.data, &grid, sizeof grid);
    *out = slice.address;
    return FNL_OK;
}

struct grid_data {
    struct visibility samples;
    uint32_t high_format;
};

static void execute_grid(const struct graph_context *context, const void *data) {
    const struct grid_data *d = data;
    struct gpu_graphics_params params = {.vertex = &shader_deferred_msaa_spread_vert,
                                         .fragment = &shader_grid_frag,
                                         .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST,
                                         .color_count = d->high_format ? 2 : 1,
                                         .color_formats = {VK_FORMAT_R32_UINT, (VkFormat)d->high_format},
                                         .depth_format = GEOMETRY_DEPTH_FORMAT,
                                         .depth_write = true,
                                         .samples = 1};
    struct gpu_grid_push push = {.ids = graph_sampled(context, d->samples.ids),
                                 .ids_high = d->high_format ? graph_sampled(context, d->samples.ids_high) : GPU_TEXTURE_NONE,
                                 .depth = graph_sampled(context, d->samples.depth)};
    gpu_bind(context->commands, gpu_graphics_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_draw(context->commands, 3, 1, 0, 0);
}

struct visibility visibility_grid_add(struct graph *graph, gpu_device *device, const struct shade_input *input,
                                      const struct gpu_view *view, uint32_t bits, graph_image depth) {
    struct shade_input half = *input;
    half.width = DIVIDE_UP(input->width, 2u);
    half.height = DIVIDE_UP(input->height, 2u);
    if (grid_view(device, view, &half.view) != FNL_OK) half.view = input->view; /* the error sticks */
    struct graph_image_params params = {.name = "visibility grid depth",
                                        .format = GEOMETRY_DEPTH_FORMAT,
                                        .width = half.width,
                                        .height = half.height,
                                        .samples = 4};
    struct visibility samples = visibility_add(graph, &half, bits, false, graph_create_image(graph, &params)), v = samples;
    struct grid_data data = {samples, samples.ids_high.id ? VK_FORMAT_R32_UINT : 0};
    params = (struct graph_image_params){
        .name = "visibility pixels", .format = VK_FORMAT_R32_UINT, .width = input->width, .height = input->height};
    v.depth = depth;
    v.grid = true;
    v.ids = graph_create_image(graph, &params);
    params.name = "visibility pixels high";
    if (data.high_format) v.ids_high = graph_create_image(graph, &params);
    struct graph_pass *pass =
        graph_add_pass(graph, "visibility grid", GRAPH_QUEUE_GRAPHICS, execute_grid, &data, sizeof data);
    graph_use_image(pass, samples.ids, GRAPH_SAMPLE_FRAGMENT);
    if (data.high_format) graph_use_image(pass, samples.ids_high, GRAPH_SAMPLE_FRAGMENT);
    graph_use_image(pass, samples.depth, GRAPH_SAMPLE_FRAGMENT);
    graph_color(pass, v.ids, VK_ATTACHMENT_LOAD_OP_DONT_CARE, NULL);
    if (data.high_format) graph_color(pass, v.ids_high, VK_ATTACHMENT_LOAD_OP_DONT_CARE, NULL);
    graph_depth(pass, depth, VK_ATTACHMENT_LOAD_OP_DONT_CARE, 0);
    return v;
}
