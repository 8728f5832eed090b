/* SPDX-License-Identifier: MIT */
#include "passes/aa/taa.h"

#include "passes/aa/taa_shared.h"
#include "shaders.h"

static float radical_inverse(uint32_t index, uint32_t base) {
    double value = 0, digit = 1.0 / base;
    for (; index; index /= base, digit /= base) value += digit * (index % base);
    return (float)value;
}

vec2 taa_jitter(uint32_t index) {
    /* The first point is (1/2, 1/3): y is turned by 1/6, and stays in the unit square. */
    uint32_t i = index % 4096 + 1;
    float y = radical_inverse(i, 3) + 1 / 6.0f;
    return (vec2){radical_inverse(i, 2) - 0.5f, (y < 1 ? y : y - 1) - 0.5f};
}

struct taa_data {
    struct taa_params params;
    graph_image radiance;
    struct graph_history color, depth;
    uint32_t width, height;
};

static void execute_taa(const struct graph_context *context, const void *data) {
    const struct taa_data *d = data;
    const struct taa_params *p = &d->params;
    struct gpu_compute_params params = {.shader = &shader_taa_comp, .constant_count = 1, .constants = {p->tonemap}};
    struct gpu_taa_push push = {.view = p->view,
                                .exposure = p->exposure.id ? graph_address(context, p->exposure) : 0,
                                .factor = p->factor,
                                .metered = p->exposure.id != 0,
                                .radiance = graph_sampled(context, d->radiance),
                                .depth = graph_sampled(context, p->depth),
                                .motion = graph_sampled(context, p->motion),
                                .history = p->keeps ? graph_sampled(context, d->color.previous) : 0,
                                .history_depth = p->keeps ? graph_sampled(context, d->depth.previous) : 0,
                                .target = graph_storage(context, d->color.current),
                                .target_depth = graph_storage(context, d->depth.current),
                                .keeps = p->keeps,
                                .still = p->still};
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_dispatch(context->commands, DIVIDE_UP(d->width, 8u), DIVIDE_UP(d->height, 8u), 1);
}

graph_image taa_add(struct graph *graph, graph_image radiance, const struct taa_params *params) {
    struct graph_image_params image = graph_image_info(graph, radiance);
    struct taa_data data = {.params = *params, .radiance = radiance, .width = image.width, .height = image.height};
    image.name = "collected radiance";
    image.format = VK_FORMAT_R32G32B32A32_SFLOAT;
    data.color = graph_history(graph, &image);
    image.name = "collected depth";
    image.format = VK_FORMAT_R16G16B16A16_SFLOAT;
    data.depth = graph_history(graph, &image);
    data.params.keeps = params->keeps && data.color.previous.id && data.depth.previous.id;
    struct graph_pass *pass = graph_add_pass(graph, "taa", GRAPH_QUEUE_GRAPHICS, execute_taa, &data, sizeof data);
    graph_use_image(pass, radiance, GRAPH_SAMPLE_COMPUTE);
    graph_use_image(pass, params->depth, GRAPH_SAMPLE_COMPUTE);
    graph_use_image(pass, params->motion, GRAPH_SAMPLE_COMPUTE);
    if (params->exposure.id) graph_use_buffer(pass, params->exposure, GRAPH_READ_COMPUTE);
    if (data.params.keeps) {
        graph_use_image(pass, data.color.previous, GRAPH_SAMPLE_COMPUTE);
        graph_use_image(pass, data.depth.previous, GRAPH_SAMPLE_COMPUTE);
    }
    graph_use_image(pass, data.color.current, GRAPH_WRITE_COMPUTE);
    graph_use_image(pass, data.depth.current, GRAPH_WRITE_COMPUTE);
    return data.color.current;
}
