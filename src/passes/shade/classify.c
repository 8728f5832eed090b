/* SPDX-License-Identifier: MIT */
#include "passes/shade/classify.h"

#include "passes/geometry/prefix_sum.h"
#include "shaders.h"

struct classify_data {
    struct gbuffer gbuffer;
    VkDeviceAddress view, lights;
    graph_buffer classes;
    struct shade_classes out;
    uint32_t kind, width, height;
    bool fills;
};

static void execute_classify(const struct graph_context *context, const void *data) {
    const struct classify_data *d = data;
    struct gpu_compute_params params = {.shader = d->fills ? &shader_classify_fill_comp : &shader_classify_mark_comp,
                                        .constant_count = 1,
                                        .constants = {d->kind}};
    struct gpu_classify_push push = {.view = d->view,
                                     .lights = d->lights,
                                     .classes = graph_address(context, d->classes),
                                     .sums = graph_address(context, d->out.sums),
                                     .block_size = d->out.block_size,
                                     .blocks_x = DIVIDE_UP(d->width, d->out.block_size),
                                     .block_count = d->out.block_count};
    if (!d->fills) gbuffer_specialise(&d->gbuffer, params.constants, &params.constant_count);
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    if (d->fills) {
        push.blocks = graph_address(context, d->out.blocks);
        push.dispatches = graph_address(context, d->out.dispatches);
        push.counts = graph_address(context, d->out.counts);
        gpu_push(context->commands, &push, sizeof push);
        gpu_dispatch_linear(context->commands, DIVIDE_UP(MAX(d->out.block_count, SHADE_CLASSES + 1), 64u));
        return;
    }
    push.gbuffer = gbuffer_handles(context, &d->gbuffer);
    gpu_push(context->commands, &push, sizeof push);
    gpu_dispatch(context->commands, DIVIDE_UP(d->width, 8u), DIVIDE_UP(d->height, 8u), 1);
}

struct shade_classes classify_add(struct graph *graph, const struct shade_input *input, const struct gbuffer *gbuffer,
                                  uint32_t block_size) {
    struct classify_data data = {.gbuffer = *gbuffer,
                                 .view = input->view,
                                 .lights = input->lights->header,
                                 .kind = input->lights->kind,
                                 .width = input->width,
                                 .height = input->height};
    uint32_t count = DIVIDE_UP(input->width, block_size) * DIVIDE_UP(input->height, block_size);
    data.classes = graph_create_buffer(graph, "block classes", count * 4ull);
    data.out = (struct shade_classes){.sums = graph_create_buffer(graph, "class sums", (count * SHADE_CLASSES + 1) * 4ull),
                                      .blocks = graph_create_buffer(graph, "class blocks", count * 4ull),
                                      .dispatches = graph_create_buffer(graph, "class dispatches", SHADE_CLASSES * 12ull),
                                      .counts = graph_create_buffer(graph, "class counts", (SHADE_CLASSES + 1) * 4ull),
                                      .block_size = block_size,
                                      .block_count = count};
    struct graph_pass *pass = graph_add_pass(graph, "classify", GRAPH_QUEUE_GRAPHICS, execute_classify, &data, sizeof data);
    gbuffer_use(pass, gbuffer, GRAPH_SAMPLE_COMPUTE);
    light_list_use(pass, input->lights, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data.classes, GRAPH_WRITE_COMPUTE);
    graph_use_buffer(pass, data.out.sums, GRAPH_WRITE_COMPUTE);
    prefix_sum_add(graph, "classes", GRAPH_QUEUE_GRAPHICS, data.out.sums, count * SHADE_CLASSES + 1);
    data.fills = true;
    pass = graph_add_pass(graph, "classify fill", GRAPH_QUEUE_GRAPHICS, execute_classify, &data, sizeof data);
    graph_use_buffer(pass, data.classes, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data.out.sums, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data.out.blocks, GRAPH_WRITE_COMPUTE);
    graph_use_buffer(pass, data.out.dispatches, GRAPH_WRITE_COMPUTE);
    graph_use_buffer(pass, data.out.counts, GRAPH_WRITE_COMPUTE);
    return data.out;
}
