/* SPDX-License-Identifier: MIT */
#include "passes/post/post.h"

#include "fanal/renderer.h"
#include "passes/post/post_shared.h"
#include "shaders.h"

_Static_assert((uint32_t)FNL_TONEMAP_AGX == GPU_TONEMAP_AGX && FNL_TONEMAP_COUNT == FNL_TONEMAP_AGX + 1,
               "post_shared.h has the values of fnl_tonemap");

static uint32_t sample_count(const struct graph *graph, graph_image image) {
    return MAX(graph_image_info(graph, image).samples, 1u);
}

/* ---- metering ---- */

struct meter_data {
    graph_image radiance;
    graph_buffer histogram, exposure;
    uint32_t width, height, samples;
};

static void execute_clear(const struct graph_context *context, const void *data) {
    const struct meter_data *d = data;
    gpu_fill_buffer(context->commands, graph_get_buffer(context, d->histogram), 0, METER_BINS * 4, 0);
}

static void execute_meter(const struct graph_context *context, const void *data) {
    const struct meter_data *d = data;
    struct gpu_compute_params params = {.shader = &shader_meter_comp, .constant_count = 1, .constants = {d->samples}};
    struct gpu_meter_push push = {.histogram = graph_address(context, d->histogram),
                                  .radiance = graph_sampled(context, d->radiance),
                                  .width = d->width,
                                  .height = d->height};
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_dispatch(context->commands, DIVIDE_UP(d->width, 32u), DIVIDE_UP(d->height, 32u), 1);
}

static void execute_exposure(const struct graph_context *context, const void *data) {
    const struct meter_data *d = data;
    struct gpu_compute_params params = {.shader = &shader_exposure_comp};
    struct gpu_exposure_push push = {.histogram = graph_address(context, d->histogram),
                                     .exposure = graph_address(context, d->exposure)};
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_dispatch(context->commands, 1, 1, 1);
}

graph_buffer exposure_add(struct graph *graph, graph_image radiance) {
    struct graph_image_params image = graph_image_info(graph, radiance);
    struct meter_data data = {radiance,
                              graph_create_buffer(graph, "luminance histogram", METER_BINS * 4),
                              graph_create_buffer(graph, "exposure", 8),
                              image.width,
                              image.height,
                              sample_count(graph, radiance)};
    struct graph_pass *pass = graph_add_pass(graph, "meter clear", GRAPH_QUEUE_GRAPHICS, execute_clear, &data, sizeof data);
    graph_use_buffer(pass, data.histogram, GRAPH_COPY_TO);
    pass = graph_add_pass(graph, "meter", GRAPH_QUEUE_GRAPHICS, execute_meter, &data, sizeof data);
    graph_use_image(pass, radiance, GRAPH_SAMPLE_COMPUTE);
    graph_use_buffer(pass, data.histogram, GRAPH_READ_WRITE_COMPUTE);
    pass = graph_add_pass(graph, "exposure", GRAPH_QUEUE_GRAPHICS, execute_exposure, &data, sizeof data);
    graph_use_buffer(pass, data.histogram, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data.exposure, GRAPH_WRITE_COMPUTE);
    return data.exposure;
}

/* ---- tone mapping ---- */

struct tonemap_data {
    struct tonemap_params params;
    graph_image radiance, target;
    uint32_t width, height, samples;
};

static void execute_tonemap(const struct graph_context *context, const void *data) {
    const struct tonemap_data *d = data;
    struct gpu_compute_params params = {.shader = &shader_tonemap_comp, .constant_count = 1, .constants = {d->samples}};
    bool metered = d->params.exposure.id != 0;
    struct gpu_tonemap_push push = {.exposure = metered ? graph_address(context, d->params.exposure) : 0,
                                    .metered = metered,
                                    .factor = d->params.factor,
                                    .radiance = graph_sampled(context, d->radiance),
                                    .target = graph_storage(context, d->target),
                                    .width = d->width,
                                    .height = d->height,
                                    .encode = !d->params.linear,
                                    .swap = d->params.swap,
                                    .tonemap = d->params.tonemap};
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_dispatch(context->commands, DIVIDE_UP(d->width, 8u), DIVIDE_UP(d->height, 8u), 1);
}

void tonemap_add(struct graph *graph, graph_image radiance, graph_image target, const struct tonemap_params *params) {
    struct graph_image_params image = graph_image_info(graph, radiance);
    struct tonemap_data data = {*params, radiance, target, image.width, image.height, sample_count(graph, radiance)};
    struct graph_pass *pass = graph_add_pass(graph, "tonemap", GRAPH_QUEUE_GRAPHICS, execute_tonemap, &data, sizeof data);
    graph_use_image(pass, radiance, GRAPH_SAMPLE_COMPUTE);
    graph_use_image(pass, target, GRAPH_WRITE_COMPUTE);
    if (params->exposure.id) graph_use_buffer(pass, params->exposure, GRAPH_READ_COMPUTE);
}

/* ---- resolve ---- */

static void execute_resolve(const struct graph_context *context, const void *data) {
    const struct tonemap_data *d = data;
    struct gpu_compute_params params = {.shader = &shader_resolve_comp, .constant_count = 1, .constants = {d->samples}};
    struct gpu_resolve_push push = {graph_sampled(context, d->radiance), graph_storage(context, d->target), d->width,
                                    d->height};
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_dispatch(context->commands, DIVIDE_UP(d->width, 8u), DIVIDE_UP(d->height, 8u), 1);
}

void resolve_add(struct graph *graph, graph_image radiance, graph_image target) {
    struct graph_image_params image = graph_image_info(graph, radiance);
    struct tonemap_data data = {.radiance = radiance,
                                .target = target,
                                .width = image.width,
                                .height = image.height,
                                .samples = sample_count(graph, radiance)};
    struct graph_pass *pass = graph_add_pass(graph, "resolve", GRAPH_QUEUE_GRAPHICS, execute_resolve, &data, sizeof data);
    graph_use_image(pass, radiance, GRAPH_SAMPLE_COMPUTE);
    graph_use_image(pass, target, GRAPH_WRITE_COMPUTE);
}
