/* SPDX-License-Identifier: MIT */
#include "passes/post/post.h"

#include "fanal/renderer.h"
#include "passes/post/display_shared.h"
#include "passes/post/post_shared.h"
#include "shaders.h"

_Static_assert((uint32_t)FNL_TONEMAP_AGX == GPU_TONEMAP_AGX && FNL_TONEMAP_COUNT == FNL_TONEMAP_AGX + 1,
               "post_shared.h has the values of fnl_tonemap");

static uint32_t sample_count(const struct graph *graph, graph_image image) {
    return MAX(graph_image_info(graph, image).samples, 1u);
}

/* ---- metering ---- */

graph_buffer exposure_add(struct graph *graph, const graph_image *radiance, const graph_image *depth, uint32_t count) {
    graph_buffer histogram = graph_create_buffer(graph, "luminance histogram", 2 * METER_BINS * 4);
    graph_buffer exposure = graph_create_buffer(graph, "exposure", 8);
    graph_add_clear(graph, "meter clear", GRAPH_QUEUE_GRAPHICS, (struct graph_clear){.buffers = {histogram}});
    for (uint32_t i = 0; i < count; i++) {
        const struct graph_image_params image = graph_image_info(graph, radiance[i]);
        struct gpu_meter_push meter = {.width = image.width, .height = image.height};
        graph_dispatch(graph, &(struct graph_dispatch){.name = count > 1 ? graph_name(graph, "meter %u", i) : "meter",
                                                       .pipeline = {&shader_meter_comp, 1, {sample_count(graph, radiance[i])}},
                                                       .groups = {DIVIDE_UP(image.width, 32u), DIVIDE_UP(image.height, 32u)},
                                                       GRAPH_PUSH(meter),
                                                       GRAPH_ROWS(graph_samples(&meter.radiance, radiance[i]), graph_samples(&meter.depth, depth[i]),
                                                                  graph_changes(&meter.histogram, histogram))});
    }
    struct gpu_exposure_push push = {0};
    graph_dispatch(graph, &(struct graph_dispatch){
                              .name = "exposure",
                              .pipeline = {.shader = &shader_exposure_comp},
                              .groups = {1},
                              GRAPH_PUSH(push),
                              GRAPH_ROWS(graph_reads(&push.histogram, histogram), graph_writes(&push.exposure, exposure))});
    return exposure;
}

/* ---- tone mapping ---- */

void tonemap_add(struct graph *graph, graph_image radiance, graph_image target, const struct tonemap_params *params) {
    struct graph_image_params image = graph_image_info(graph, radiance);
    struct gpu_tonemap_push push = {.metered = params->exposure.id != 0,
                                    .factor = params->factor,
                                    .width = image.width,
                                    .height = image.height,
                                    .encode = !params->linear,
                                    .swap = params->swap,
                                    .tonemap = params->tonemap};
    graph_dispatch(graph, &(struct graph_dispatch){
                              .name = "tonemap",
                              .pipeline = {&shader_tonemap_comp, 1, {sample_count(graph, radiance)}},
                              .groups = {DIVIDE_UP(image.width, 8u), DIVIDE_UP(image.height, 8u)},
                              GRAPH_PUSH(push),
                              GRAPH_ROWS(graph_samples(&push.radiance, radiance), graph_stores(&push.target, target),
                                         graph_row_if(push.metered, graph_reads(&push.exposure, params->exposure)))});
}

/* ---- displays ---- */

_Static_assert(DISPLAY_ABGR10 == GPU_DISPLAY_ABGR10 && DISPLAY_ARGB10 == GPU_DISPLAY_ARGB10, "display_shared.h has these values");

graph_image display_add(struct graph *graph, graph_image picture, enum display_format format, bool decode) {
    const struct graph_image_params from = graph_image_info(graph, picture);
    graph_image target = graph_create_image(graph, &(struct graph_image_params){.name = "encoded for the display",
                                                                                .format = format == DISPLAY_LINEAR ? from.format : VK_FORMAT_R8G8B8A8_UNORM,
                                                                                .width = from.width,
                                                                                .height = from.height,
                                                                                .samples = 1});
    struct gpu_display_push push = {.width = from.width, .height = from.height, .decode = decode, .format = (uint32_t)format};
    graph_dispatch(graph, &(struct graph_dispatch){.name = "encode for display",
                                                   .pipeline = {.shader = &shader_display_comp},
                                                   .groups = {DIVIDE_UP(from.width, 8u), DIVIDE_UP(from.height, 8u)},
                                                   GRAPH_PUSH(push),
                                                   GRAPH_ROWS(graph_samples(&push.picture, picture), graph_stores(&push.target, target))});
    return target;
}

/* ---- resolve ---- */

void resolve_add(struct graph *graph, graph_image radiance, graph_image target) {
    struct graph_image_params image = graph_image_info(graph, radiance);
    struct gpu_resolve_push push = {.width = image.width, .height = image.height};
    graph_dispatch(graph, &(struct graph_dispatch){
                              .name = "resolve",
                              .pipeline = {&shader_resolve_comp, 1, {sample_count(graph, radiance)}},
                              .groups = {DIVIDE_UP(image.width, 8u), DIVIDE_UP(image.height, 8u)},
                              GRAPH_PUSH(push),
                              GRAPH_ROWS(graph_samples(&push.radiance, radiance), graph_stores(&push.target, target))});
}

/* ---- depth ---- */

struct depth_picture_data {
    graph_image depth;
    VkFormat format;
    uint32_t samples, forward;
};

static void execute_depth_picture(const struct graph_context *context, const void *data) {
    const struct depth_picture_data *d = data;
    struct gpu_graphics_params params = {.vertex = &shader_screen_vert,
                                         .fragment = &shader_depth_picture_frag,
                                         .constant_count = 1,
                                         .constants = {d->samples},
                                         .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST,
                                         .depth_format = d->format,
                                         .depth_test = true,
                                         .depth_write = true,
                                         .depth_compare = VK_COMPARE_OP_ALWAYS,
                                         .samples = 1};
    struct gpu_depth_picture_push push = {graph_sampled(context, d->depth), d->forward};
    gpu_bind(context->commands, gpu_graphics_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_draw(context->commands, 3, 1, 0, 0);
}

graph_image depth_picture_add(struct graph *graph, graph_image depth, bool forward) {
    const struct graph_image_params from = graph_image_info(graph, depth);
    if (from.samples <= 1 && !forward) return depth;
    const struct depth_picture_data data = {depth, from.format, MAX(from.samples, 1u), forward};
    const graph_image out =
        graph_create_image(graph, &(struct graph_image_params){.name = "depth picture", .format = from.format, .width = from.width, .height = from.height});
    struct graph_pass *pass = graph_add_pass(graph, "depth picture", GRAPH_QUEUE_GRAPHICS, execute_depth_picture, &data, sizeof data);
    graph_use_image(pass, depth, GRAPH_SAMPLE_FRAGMENT);
    graph_depth(pass, out, VK_ATTACHMENT_LOAD_OP_DONT_CARE, 0);
    return out;
}
