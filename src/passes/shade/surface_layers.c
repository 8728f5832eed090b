/* SPDX-License-Identifier: MIT */
#include "passes/shade/surface_layers.h"

#include "shaders.h"

struct layers_data {
    graph_buffer surfaces;
    VkDeviceAddress view;
    graph_image depth, images[SURFACE_LAYERS];
    VkFormat format;
    uint32_t layer, count;
};

static void execute_depth(const struct graph_context *context, const void *data) {
    const struct layers_data *d = data;
    struct gpu_graphics_params params = {.vertex = &shader_screen_vert,
                                         .fragment = &shader_surface_layers_depth_frag,
                                         .constant_count = 10,
                                         .constants = {[SAMPLES_ID] = d->count},
                                         .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST,
                                         .depth_format = GEOMETRY_DEPTH_FORMAT,
                                         .depth_test = true,
                                         .depth_write = true,
                                         .depth_compare = VK_COMPARE_OP_ALWAYS,
                                         .samples = 1};
    struct gpu_surface_layers_push push = {.view = d->view,
                                           .surfaces = graph_address(context, d->surfaces),
                                           .depth = graph_sampled(context, d->depth),
                                           .layer = d->layer};
    gpu_bind(context->commands, gpu_graphics_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_draw(context->commands, 3, 1, 0, 0);
}

void surface_layers_add_depths(struct graph *graph, const struct shade_input *input, graph_image depth,
                               struct surface_layers *layers) {
    struct layers_data data = {.surfaces = layers->surfaces, .view = input->view, .depth = depth, .count = layers->count};
    struct graph_image_params image = {.format = GEOMETRY_DEPTH_FORMAT, .width = input->width, .height = input->height};
    for (uint32_t i = 0; i < layers->count; i++) {
        image.name = graph_numbered_name(graph, "surface depth", i);
        layers->depths[i] = graph_create_image(graph, &image);
        data.layer = i;
        struct graph_pass *pass = graph_add_pass(graph, graph_numbered_name(graph, "surface layer", i), GRAPH_QUEUE_GRAPHICS,
                                                 execute_depth, &data, sizeof data);
        graph_use_image(pass, depth, GRAPH_SAMPLE_FRAGMENT);
        graph_use_buffer(pass, layers->surfaces, GRAPH_READ_FRAGMENT);
        graph_depth(pass, layers->depths[i], VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
    }
}

static void execute_spread(const struct graph_context *context, const void *data) {
    const struct layers_data *d = data;
    struct gpu_graphics_params params = {.vertex = &shader_deferred_msaa_spread_vert,
                                         .fragment = &shader_surface_layers_spread_frag,
                                         .constant_count = 10,
                                         .constants = {[SAMPLES_ID] = d->count},
                                         .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST,
                                         .color_count = 1,
                                         .color_formats = {d->format},
                                         .blends = {GPU_BLEND_ADD},
                                         .samples = d->count};
    struct gpu_surface_layers_push push = {.view = d->view, .surfaces = graph_address(context, d->surfaces)};
    for (uint32_t i = 0; i < d->count; i++) push.layers[i] = graph_sampled(context, d->images[i]);
    gpu_bind(context->commands, gpu_graphics_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_draw(context->commands, 3, d->count, 0, 0);
}

void surface_layers_spread(struct graph *graph, const struct shade_input *input, const struct surface_layers *layers,
                           const graph_image images[SURFACE_LAYERS], graph_image radiance) {
    struct layers_data data = {.surfaces = layers->surfaces,
                               .view = input->view,
                               .format = graph_image_info(graph, radiance).format,
                               .count = layers->count};
    memcpy(data.images, images, layers->count * sizeof *images);
    struct graph_pass *pass =
        graph_add_pass(graph, "surface layers spread", GRAPH_QUEUE_GRAPHICS, execute_spread, &data, sizeof data);
    for (uint32_t i = 0; i < layers->count; i++) graph_use_image(pass, images[i], GRAPH_SAMPLE_FRAGMENT);
    graph_use_buffer(pass, layers->surfaces, GRAPH_READ_FRAGMENT);
    graph_color(pass, radiance, VK_ATTACHMENT_LOAD_OP_LOAD, NULL);
}
