/* SPDX-License-Identifier: MIT */
#include "passes/geometry/prefix_sum.h"

#include "passes/geometry/prefix_sum_shared.h"
#include "shaders.h"

struct sum_data {
    graph_buffer values, blocks;
    uint32_t count;
    enum graph_queue queue;
    const struct gpu_shader *shader;
};

static void execute_sum(const struct graph_context *context, const void *data) {
    const struct sum_data *d = data;
    struct gpu_compute_params params = {.shader = d->shader};
    struct gpu_prefix_sum_push push = {
        .values = graph_address(context, d->values), .blocks = graph_address(context, d->blocks), .count = d->count};
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_dispatch_linear(context->commands, DIVIDE_UP(d->count, PREFIX_SUM_BLOCK));
}

static void add_step(struct graph *graph, const char *name, struct sum_data data) {
    struct graph_pass *pass = graph_add_pass(graph, name, data.queue, execute_sum, &data, sizeof data);
    bool adds = data.shader == &shader_prefix_sum_add_comp;
    graph_use_buffer(pass, data.values, GRAPH_READ_WRITE_COMPUTE);
    graph_use_buffer(pass, data.blocks, adds ? GRAPH_READ_COMPUTE : GRAPH_WRITE_COMPUTE);
}

static void add_level(struct graph *graph, const char *what, enum graph_queue queue, graph_buffer values, uint32_t count,
                      uint32_t level) {
    uint32_t block_count = DIVIDE_UP(count, PREFIX_SUM_BLOCK), number = level ? level + 1 : 0;
    const char *totals = graph_numbered_name(graph, graph_name(graph, "%s totals", what), number);
    struct sum_data data = {.values = values,
                            .count = count,
                            .queue = queue,
                            .shader = &shader_prefix_sum_block_comp,
                            .blocks = graph_create_buffer(graph, totals, block_count * 4ull)};
    add_step(graph, graph_numbered_name(graph, graph_name(graph, "%s sum", what), number), data);
    if (block_count == 1) return;
    add_level(graph, what, queue, data.blocks, block_count, level + 1);
    data.shader = &shader_prefix_sum_add_comp;
    add_step(graph, graph_numbered_name(graph, graph_name(graph, "%s sum add", what), number), data);
}

void prefix_sum_add(struct graph *graph, const char *what, enum graph_queue queue, graph_buffer values, uint32_t count) {
    add_level(graph, what, queue, values, count, 0);
}
