/* SPDX-License-Identifier: MIT */
#include "passes/stereo/hidden_area.h"

#include "passes/stereo/hidden_area_shared.h"
#include "shaders.h"

struct hidden_area hidden_area_send(gpu_device *device, const fnl_hidden_area *area, const struct gpu_view *view) {
    if (!area || area->corner_count == 0) return (struct hidden_area){0};
    struct gpu_slice slice = gpu_frame_allocate(device, area->corner_count * sizeof(fnl_vec2));
    if (!slice.data) return (struct hidden_area){0};
    fnl_vec2 *corners = slice.data;
    for (uint32_t i = 0; i < area->corner_count; i++) /* a point of the plane z = -1, whose depth is 1 */
        corners[i] = (fnl_vec2){(area->corners[i].x - view->ndc_offset.x) / view->ndc_scale.x, (area->corners[i].y - view->ndc_offset.y) / view->ndc_scale.y};
    return (struct hidden_area){slice.address, area->corner_count};
}

struct hidden_data {
    struct gpu_hidden_area_push push;
    uint32_t corner_count;
    struct gpu_graphics_params state;
};

static void execute(const struct graph_context *context, const void *data) {
    const struct hidden_data *d = data;
    if (d->corner_count == 0) return;
    gpu_bind(context->commands, graph_pipeline(context, &d->state));
    gpu_push(context->commands, &d->push, sizeof d->push);
    gpu_draw(context->commands, d->corner_count, 1, 0, 0);
}

static struct graph_pass *add(struct graph *graph, const char *name, const struct hidden_area *area, enum hidden_area_depth to, VkFormat color, graph_image depth) {
    const struct graph_image_params target = graph_image_info(graph, depth);
    struct hidden_data data = {.push = {.corners = area->corners, .depth = to == HIDDEN_AREA_NEAR ? 1 : 0}, .corner_count = area->corner_count};
    data.state = (struct gpu_graphics_params){.vertex = &shader_hidden_area_vert,
                                              .fragment = color ? &shader_hidden_area_frag : NULL,
                                              .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST,
                                              .color_count = color ? 1 : 0,
                                              .color_formats = {color},
                                              .depth_format = target.format,
                                              .depth_test = true,
                                              .depth_write = true,
                                              .depth_compare = VK_COMPARE_OP_ALWAYS,
                                              .samples = MAX(target.samples, 1u)};
    return graph_add_pass(graph, name, GRAPH_QUEUE_GRAPHICS, execute, &data, sizeof data);
}

void hidden_area_add(struct graph *graph, const char *name, const struct hidden_area *area, enum hidden_area_depth to, bool clears, graph_image depth) {
    struct graph_pass *pass = add(graph, name, area, to, VK_FORMAT_UNDEFINED, depth);
    graph_depth(pass, depth, clears ? VK_ATTACHMENT_LOAD_OP_CLEAR : VK_ATTACHMENT_LOAD_OP_LOAD, 0);
}

void hidden_area_blacken(struct graph *graph, const struct hidden_area *area, graph_image radiance, graph_image depth) {
    struct graph_pass *pass = add(graph, "hidden area black", area, HIDDEN_AREA_NEAR, graph_image_info(graph, radiance).format, depth);
    graph_color(pass, radiance, VK_ATTACHMENT_LOAD_OP_LOAD, NULL);
    graph_depth(pass, depth, VK_ATTACHMENT_LOAD_OP_LOAD, 0);
}
