/* SPDX-License-Identifier: MIT */
#include "passes/decals/decals_redraw.h"

#include "scene_shared.h"
#include "shaders.h"

struct redraw_data {
    struct decals_redraw redraw;
    VkDeviceAddress view, scene, lighting;
    struct gpu_graphics_params state;
};

static void execute_redraw(const struct graph_context *context, const void *data) {
    const struct redraw_data *d = data;
    struct gpu_redraw_push push = {
        .view = d->view, .scene = d->scene, .lighting = d->lighting, .table = d->redraw.table, .set = d->redraw.set};
    gpu_bind(context->commands, graph_pipeline(context, &d->state));
    gpu_push(context->commands, &push, sizeof push);
    gpu_bind_indices(context->commands, d->redraw.indices, 0);
    gpu_draw_indexed_indirect(context->commands, graph_get_buffer(context, d->redraw.draws), 0, d->redraw.draw_count);
}

void decals_redraw_add(struct graph *graph, const struct shade_input *input, const struct decals_redraw *redraw,
                       graph_image radiance, graph_image depth) {
    struct graph_image_params target = graph_image_info(graph, radiance);
    struct redraw_data data = {
        .redraw = *redraw, .view = input->view, .scene = input->scene->scene, .lighting = input->lighting->address};
    data.state = (struct gpu_graphics_params){.vertex = &shader_decals_redraw_vert,
                                              .fragment = &shader_decals_redraw_frag,
                                              .constant_count = 2,
                                              .constants = {input->lighting->bits, 0},
                                              .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST,
                                              .cull = VK_CULL_MODE_NONE,
                                              .color_count = 1,
                                              .color_formats = {target.format},
                                              .blends = {GPU_BLEND_ALPHA},
                                              .depth_format = GEOMETRY_DEPTH_FORMAT,
                                              .depth_test = true,
                                              .depth_compare = VK_COMPARE_OP_EQUAL,
                                              .samples = MAX(target.samples, 1u)};
    struct graph_pass *pass =
        graph_add_pass(graph, "decals redraw", GRAPH_QUEUE_GRAPHICS, execute_redraw, &data, sizeof data);
    graph_use_buffer(pass, input->scene->vertices, GRAPH_READ_VERTEX);
    graph_use_buffer(pass, redraw->draws, GRAPH_INDIRECT);
    graph_use_buffer(pass, redraw->decals, GRAPH_READ_FRAGMENT);
    lighting_use(pass, input->lighting, GRAPH_READ_FRAGMENT);
    graph_color(pass, radiance, VK_ATTACHMENT_LOAD_OP_LOAD, (float[4]){0});
    graph_depth_read_only(pass, depth);
}
