/* SPDX-License-Identifier: MIT */
#include "passes/shade/edges.h"

#include "passes/geometry/prefix_sum.h"
#include "shaders.h"

struct edges_data {
    struct gbuffer gbuffer;
    graph_image radiance;
    VkDeviceAddress view;
    struct edges_params params;
    struct edges out;
    uint32_t width, height, samples;
};

static void execute_find(const struct graph_context *context, const void *data) {
    const struct edges_data *d = data;
    struct gpu_compute_params params = {.shader = &shader_edges_find_comp, .constant_count = 10};
    params.constants[9] = d->samples;
    gbuffer_specialise(&d->gbuffer, params.constants, &params.constant_count);
    struct gpu_edges_push push = {.view = d->view,
                                  .surfaces = graph_address(context, d->out.surfaces),
                                  .sums = d->params.lists ? graph_address(context, d->out.sums) : 0,
                                  .counts = graph_address(context, d->out.counts),
                                  .gbuffer = gbuffer_handles(context, &d->gbuffer),
                                  .radiance = graph_sampled(context, d->radiance),
                                  .tolerance = d->params.tolerance,
                                  .limit = d->params.limit,
                                  .lists = d->params.lists};
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_dispatch(context->commands, DIVIDE_UP(d->width, 8u), DIVIDE_UP(d->height, 8u), 1);
}

static void execute_fill(const struct graph_context *context, const void *data) {
    const struct edges_data *d = data;
    struct gpu_compute_params params = {.shader = &shader_edges_fill_comp};
    struct gpu_edges_push push = {.view = d->view,
                                  .sums = graph_address(context, d->out.sums),
                                  .entries = graph_address(context, d->out.entries),
                                  .dispatch = graph_address(context, d->out.dispatch)};
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_dispatch_linear(context->commands, DIVIDE_UP(d->width * d->height, 64u));
}

struct edges edges_add(struct graph *graph, const struct shade_input *input, const struct gbuffer *gbuffer,
                       graph_image radiance, const struct edges_params *params) {
    struct edges_data data = {.gbuffer = *gbuffer,
                              .radiance = radiance,
                              .view = input->view,
                              .params = *params,
                              .width = input->width,
                              .height = input->height,
                              .samples = graph_image_info(graph, radiance).samples};
    uint32_t pixels = input->width * input->height;
    data.out.surfaces = graph_create_buffer(graph, "edge surfaces", pixels * 4ull);
    data.out.counts = graph_create_buffer(graph, "edge counts", EDGES_COUNTS * 4ull);
    if (params->lists) {
        data.out.sums = graph_create_buffer(graph, "edge sums", (pixels + 1ull) * 4);
        data.out.entries = graph_create_buffer(graph, "edge entries", (uint64_t)pixels * (params->limit - 1) * 4);
        data.out.dispatch = graph_create_buffer(graph, "edge dispatch", 12);
    }
    graph_add_clear(graph, "clear edge counts", GRAPH_QUEUE_GRAPHICS, (struct graph_clear){.buffers = {data.out.counts}});
    struct graph_pass *pass = graph_add_pass(graph, "edges", GRAPH_QUEUE_GRAPHICS, execute_find, &data, sizeof data);
    gbuffer_use(pass, gbuffer, GRAPH_SAMPLE_COMPUTE);
    graph_use_image(pass, radiance, GRAPH_SAMPLE_COMPUTE);
    graph_use_buffer(pass, data.out.surfaces, GRAPH_WRITE_COMPUTE);
    graph_use_buffer(pass, data.out.counts, GRAPH_READ_WRITE_COMPUTE);
    if (!params->lists) return data.out;
    graph_use_buffer(pass, data.out.sums, GRAPH_WRITE_COMPUTE);
    prefix_sum_add(graph, "edges", GRAPH_QUEUE_GRAPHICS, data.out.sums, pixels + 1);
    pass = graph_add_pass(graph, "edges fill", GRAPH_QUEUE_GRAPHICS, execute_fill, &data, sizeof data);
    graph_use_buffer(pass, data.out.sums, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data.out.entries, GRAPH_WRITE_COMPUTE);
    graph_use_buffer(pass, data.out.dispatch, GRAPH_WRITE_COMPUTE);
    return data.out;
}
