/* SPDX-License-Identifier: MIT */
#include "passes/geometry/radix_sort.h"

#include "passes/geometry/radix_shared.h"
#include "shaders.h"

struct sort_data {
    struct radix_sort_params params;
    graph_buffer in, out, counts;
    uint32_t block_count, shift;
};

static void execute_step(const struct graph_context *context, const void *data) {
    const struct sort_data *d = data;
    struct gpu_compute_params params = {.shader = d->out.id ? &shader_radix_scatter_comp : &shader_radix_count_comp};
    struct gpu_radix_push push = {.in_pairs = graph_address(context, d->in),
                                  .counts = graph_address(context, d->counts),
                                  .capacity = d->params.capacity,
                                  .block_count = d->block_count,
                                  .shift = d->shift};
    if (d->out.id) push.out_pairs = graph_address(context, d->out);
    if (d->params.count.id) {
        push.count = graph_address(context, d->params.count) + d->params.count_offset;
        push.counted = 1;
    }
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_dispatch_linear(context->commands, d->block_count);
}

static void add_step(struct graph *graph, const char *name, const struct sort_data *data) {
    struct graph_pass *pass = graph_add_pass(graph, name, data->params.queue, execute_step, data, sizeof *data);
    graph_use_buffer(pass, data->in, GRAPH_READ_COMPUTE);
    if (data->params.count.id) graph_use_buffer(pass, data->params.count, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data->counts, data->out.id ? GRAPH_READ_COMPUTE : GRAPH_WRITE_COMPUTE);
    if (data->out.id) graph_use_buffer(pass, data->out, GRAPH_WRITE_COMPUTE);
}

graph_buffer radix_sort_add(struct graph *graph, const struct radix_sort_params *params) {
    const char *what = params->what;
    struct sort_data data = {
        .params = *params, .in = params->pairs, .block_count = DIVIDE_UP(params->capacity, RADIX_BLOCK)};
    for (uint32_t step = 0; step * RADIX_BITS < params->bits; step++) {
        uint32_t number = step + 1;
        data.shift = step * RADIX_BITS;
        data.out = (graph_buffer){0};
        data.counts = graph_create_buffer(graph, graph_name(graph, "%s sort counts %u", what, number),
                                          data.block_count * RADIX_DIGITS * 4ull);
        add_step(graph, graph_name(graph, "%s sort count %u", what, number), &data);
        prefix_sum_add(graph, graph_name(graph, "%s sort %u", what, number), params->queue, data.counts,
                       data.block_count * RADIX_DIGITS);
        data.out = graph_create_buffer(graph, graph_name(graph, "%s sort pairs %u", what, number), params->capacity * 8ull);
        add_step(graph, graph_name(graph, "%s sort scatter %u", what, number), &data);
        data.in = data.out;
    }
    return data.in;
}
