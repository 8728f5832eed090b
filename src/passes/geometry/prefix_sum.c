/* SPDX-License-Identifier: MIT */
#include "passes/geometry/prefix_sum.h"

#include "passes/geometry/prefix_sum_shared.h"
#include "shaders.h"

static void add_step(struct graph *graph, const char *name, enum graph_queue queue, const struct gpu_shader *shader,
                     graph_buffer values, uint32_t count, graph_buffer blocks, enum graph_use use) {
    struct gpu_prefix_sum_push push = {.count = count};
    graph_dispatch(graph, &(struct graph_dispatch){
                              .name = name,
                              .queue = queue,
                              .pipeline = {.shader = shader},
                              .groups = {DIVIDE_UP(count, PREFIX_SUM_BLOCK)},
                              GRAPH_PUSH(push),
                              GRAPH_ROWS(graph_changes(&push.values, values), graph_buffer_row(&push.blocks, blocks, use))});
}

static void add_level(struct graph *graph, const char *what, enum graph_queue queue, graph_buffer values, uint32_t count,
                      uint32_t level) {
    uint32_t block_count = DIVIDE_UP(count, PREFIX_SUM_BLOCK), number = level ? level + 1 : 0;
    const char *totals = graph_numbered_name(graph, graph_name(graph, "%s totals", what), number),
               *sum = graph_numbered_name(graph, graph_name(graph, "%s sum", what), number),
               *add = graph_numbered_name(graph, graph_name(graph, "%s sum add", what), number);
    graph_buffer blocks = graph_create_buffer(graph, totals, block_count * 4ull);
    add_step(graph, sum, queue, &shader_prefix_sum_block_comp, values, count, blocks, GRAPH_WRITE_COMPUTE);
    if (block_count == 1) return;
    add_level(graph, what, queue, blocks, block_count, level + 1);
    add_step(graph, add, queue, &shader_prefix_sum_add_comp, values, count, blocks, GRAPH_READ_COMPUTE);
}

void prefix_sum_add(struct graph *graph, const char *what, enum graph_queue queue, graph_buffer values, uint32_t count) {
    add_level(graph, what, queue, values, count, 0);
}
