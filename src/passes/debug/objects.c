/* SPDX-License-Identifier: MIT */
#include "passes/debug/debug.h"
#include "shaders.h"

struct objects_data {
    const struct geometry_scene *scene;
    struct geometry_draws draws;
    struct gpu_geometry_push push;
    const struct gpu_shader *fragment;
};

static void execute_objects(const struct graph_context *context, const void *data) {
    const struct objects_data *d = data;
    const struct gpu_graphics_params state = {.fragment = d->fragment,
                                              .color_count = 1,
                                              .color_formats = {VK_FORMAT_R32G32B32A32_SFLOAT},
                                              .depth_format = GEOMETRY_DEPTH_FORMAT,
                                              .depth_test = true,
                                              .depth_write = true,
                                              .depth_compare = VK_COMPARE_OP_GREATER_OR_EQUAL,
                                              .samples = 1};
    const enum geometry_set sets[] = {GEOMETRY_OPAQUE, GEOMETRY_GLASS, GEOMETRY_BLEND};
    for (uint32_t i = 0; i < COUNT_OF(sets); i++) geometry_draw(context, d->scene, &d->draws, sets[i], &state, NULL, d->push);
}

graph_image objects_add(struct graph *graph, gpu_device *device, const struct geometry_scene *scene, const struct geometry_draws *draws,
                        VkDeviceAddress view, VkDeviceAddress table, uint32_t width, uint32_t height) {
    struct graph_image_params params = {.name = "objects", .format = VK_FORMAT_R32G32B32A32_SFLOAT, .width = width, .height = height};
    graph_image objects = graph_create_image(graph, &params);
    params.name = "objects depth";
    params.format = GEOMETRY_DEPTH_FORMAT;
    struct objects_data data = {scene, *draws, {.view = view, .counters = table},
                                gpu_info(device)->primitive_ids ? &shader_objects_frag : &shader_objects_plain_frag};
    struct graph_pass *pass = graph_add_pass(graph, "objects", GRAPH_QUEUE_GRAPHICS, execute_objects, &data, sizeof data);
    geometry_use(pass, scene, draws, GEOMETRY_OPAQUE);
    if (draws->blend_draws.id) {
        graph_use_buffer(pass, draws->blend_visible, GRAPH_READ_VERTEX);
        graph_use_buffer(pass, draws->blend_draws, GRAPH_INDIRECT);
    }
    graph_color(pass, objects, VK_ATTACHMENT_LOAD_OP_CLEAR, (float[4]){0, 0, 0, 0});
    graph_depth(pass, graph_create_image(graph, &params), VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
    return objects;
}
