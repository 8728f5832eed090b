/* SPDX-License-Identifier: MIT */
#include "passes/shade/sample_bounds.h"

#include "shaders.h"

#define RANGES_FORMAT VK_FORMAT_R32G32B32A32_SFLOAT

struct bounds_data {
    VkDeviceAddress view;
    graph_image depth;
    uint32_t samples;
};

static void execute_bounds(const struct graph_context *context, const void *data) {
    const struct bounds_data *d = data;
    struct gpu_graphics_params params = {.vertex = &shader_screen_vert,
                                         .fragment = &shader_sample_bounds_frag,
                                         .constant_count = 10,
                                         .constants = {[SAMPLES_ID] = d->samples},
                                         .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST,
                                         .color_count = 1,
                                         .color_formats = {RANGES_FORMAT},
                                         .depth_format = GEOMETRY_DEPTH_FORMAT,
                                         .depth_test = true,
                                         .depth_write = true,
                                         .depth_compare = VK_COMPARE_OP_ALWAYS,
                                         .samples = 1};
    struct gpu_sample_bounds_push push = {.view = d->view, .depth = graph_sampled(context, d->depth)};
    gpu_bind(context->commands, gpu_graphics_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_draw(context->commands, 3, 1, 0, 0);
}

struct sample_bounds sample_bounds_add(struct graph *graph, const struct shade_input *input, graph_image depth) {
    struct graph_image_params image = {
        .name = "sample bounds", .format = RANGES_FORMAT, .width = input->width, .height = input->height};
    struct sample_bounds bounds = {.ranges = graph_create_image(graph, &image)};
    image.name = "nearest of samples";
    image.format = GEOMETRY_DEPTH_FORMAT;
    bounds.nearest = graph_create_image(graph, &image);
    struct bounds_data data = {input->view, depth, graph_image_info(graph, depth).samples};
    struct graph_pass *pass =
        graph_add_pass(graph, "sample bounds", GRAPH_QUEUE_GRAPHICS, execute_bounds, &data, sizeof data);
    graph_use_image(pass, depth, GRAPH_SAMPLE_FRAGMENT);
    static const float zero[4];
    graph_color(pass, bounds.ranges, VK_ATTACHMENT_LOAD_OP_CLEAR, zero);
    graph_depth(pass, bounds.nearest, VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
    return bounds;
}
