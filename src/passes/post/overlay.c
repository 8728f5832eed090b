/* SPDX-License-Identifier: MIT */
#include "passes/post/overlay.h"

#include "passes/post/overlay_shared.h"
#include "passes/post/scale_shared.h"
#include "shaders.h"

_Static_assert(sizeof(fnl_overlay_vertex) == sizeof(struct gpu_overlay_vertex), "vertices are copied as they are");

static uint32_t smooth_sampler(gpu_device *device) {
    return gpu_sampler_index(device, &(struct gpu_sampler_params){.mag = VK_FILTER_LINEAR,
                                                                               .min = VK_FILTER_LINEAR,
                                                                               .wrap_u = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                                                               .wrap_v = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                                                               .anisotropy = 1});
}

struct overlay_data {
    struct gpu_overlay_push push;
    struct gpu_graphics_params state;
    const fnl_overlay_draw *draws; /* in the frame's memory */
    uint32_t draw_count, width, height;
    int32_t x, y;
    uint32_t images[FNL_OVERLAY_IMAGES_MAX]; /* bindless */
};

/* Clips a rectangle to 0 .. limit in one direction. */
static uint32_t clip(int64_t from, uint32_t length, uint32_t limit, uint32_t *out_length) {
    int64_t first = MIN(MAX(from, 0), (int64_t)limit), last = MIN(MAX(from + (int64_t)length, first), (int64_t)limit);
    *out_length = (uint32_t)(last - first);
    return (uint32_t)first;
}

static void execute_overlay(const struct graph_context *context, const void *data) {
    const struct overlay_data *d = data;
    gpu_bind(context->commands, graph_pipeline(context, &d->state));
    for (uint32_t i = 0; i < d->draw_count; i++) {
        const fnl_overlay_draw *draw = &d->draws[i];
        uint32_t width, height;
        const uint32_t x = clip((int64_t)draw->x - d->x, draw->width, d->width, &width),
                       y = clip((int64_t)draw->y - d->y, draw->height, d->height, &height);
        if (draw->index_count == 0 || width == 0 || height == 0) continue;
        struct gpu_overlay_push push = d->push;
        push.vertices += draw->first_vertex * sizeof(fnl_overlay_vertex);
        push.indices += draw->first_index * sizeof(uint32_t);
        push.image = d->images[draw->image];
        gpu_scissor(context->commands, x, y, width, height);
        gpu_push(context->commands, &push, sizeof push);
        gpu_draw(context->commands, draw->index_count, 1, 0, 0);
    }
}

void overlay_add(gpu_device *device, struct graph *graph, graph_image picture, const struct overlay_params *params) {
    const fnl_overlay *overlay = params->overlay;
    const struct graph_image_params target = graph_image_info(graph, picture);
    if (overlay->draw_count == 0) return;
    const uint64_t vertex_bytes = overlay->vertex_count * sizeof *overlay->vertices, index_bytes = overlay->index_count * sizeof *overlay->indices,
                   draw_bytes = overlay->draw_count * sizeof *overlay->draws;
    struct gpu_slice vertices = gpu_frame_allocate(device, vertex_bytes + index_bytes + draw_bytes);
    if (!vertices.data) return;
    if (vertex_bytes) memcpy(vertices.data, overlay->vertices, vertex_bytes);
    if (index_bytes) memcpy((char *)vertices.data + vertex_bytes, overlay->indices, index_bytes);
    memcpy((char *)vertices.data + vertex_bytes + index_bytes, overlay->draws, draw_bytes);
    struct overlay_data data = {.push = {.vertices = vertices.address,
                                         .indices = vertices.address + vertex_bytes,
                                         .corner = {(float)params->x, (float)params->y},
                                         .scale = {2.0f / (float)target.width, 2.0f / (float)target.height},
                                         .sampler_index = smooth_sampler(device),
                                         .linear = params->linear,
                                         .swap = params->swap},
                                .draws = (const fnl_overlay_draw *)((char *)vertices.data + vertex_bytes + index_bytes),
                                .draw_count = overlay->draw_count,
                                .width = target.width,
                                .height = target.height,
                                .x = params->x,
                                .y = params->y};
    memcpy(data.images, params->images, sizeof data.images);
    data.state = (struct gpu_graphics_params){.vertex = &shader_overlay_vert,
                                              .fragment = &shader_overlay_frag,
                                              .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST,
                                              .color_count = 1,
                                              .color_formats = {target.format},
                                              .blends = {GPU_BLEND_ALPHA},
                                              .samples = 1};
    struct graph_pass *pass = graph_add_pass(graph, "overlay", GRAPH_QUEUE_GRAPHICS, execute_overlay, &data, sizeof data);
    graph_color(pass, picture, VK_ATTACHMENT_LOAD_OP_LOAD, NULL);
}

graph_image scale_add(gpu_device *device, struct graph *graph, graph_image picture, uint32_t width, uint32_t height) {
    const struct graph_image_params from = graph_image_info(graph, picture);
    graph_image target = graph_create_image(
        graph, &(struct graph_image_params){.name = "scaled picture", .format = from.format, .width = width, .height = height, .samples = 1});
    struct gpu_scale_push push = {.sampler_index = smooth_sampler(device), .width = width, .height = height};
    graph_dispatch(graph, &(struct graph_dispatch){.name = "scale picture",
                                                   .pipeline = {.shader = &shader_scale_comp},
                                                   .groups = {DIVIDE_UP(width, 8u), DIVIDE_UP(height, 8u)},
                                                   GRAPH_PUSH(push),
                                                   GRAPH_ROWS(graph_samples(&push.picture, picture), graph_stores(&push.target, target))});
    return target;
}
