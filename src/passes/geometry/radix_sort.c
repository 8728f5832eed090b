/* SPDX-License-Identifier: MIT */
#include "passes/geometry/radix_sort.h"

#include "passes/geometry/radix_shared.h"
#include "shaders.h"

/* Counts digits, or, given a target, moves the pairs. */
static void add_step(struct graph *graph, const char *name, const struct radix_sort_params *params, uint32_t shift,
                     graph_buffer in, graph_buffer counts, graph_buffer out) {
    uint32_t block_count = DIVIDE_UP(params->capacity, RADIX_BLOCK);
    struct gpu_radix_push push = {
        .counted = params->count.id != 0, .capacity = params->capacity, .block_count = block_count, .shift = shift};
    graph_dispatch(graph,
                   &(struct graph_dispatch){
                       .name = name,
                       .queue = params->queue,
                       .pipeline = {.shader = out.id ? &shader_radix_scatter_comp : &shader_radix_count_comp},
                       .groups = {block_count},
                       GRAPH_PUSH(push),
                       GRAPH_ROWS(graph_reads(&push.in_pairs, in),
                                  graph_row_if(push.counted,
                                               graph_row_at(params->count_offset, graph_reads(&push.count, params->count))),
                                  graph_buffer_row(&push.counts, counts, out.id ? GRAPH_READ_COMPUTE : GRAPH_WRITE_COMPUTE),
                                  graph_row_if(out.id, graph_writes(&push.out_pairs, out)))});
}

graph_buffer radix_sort_add(struct graph *graph, const struct radix_sort_params *params) {
    const char *what = params->what;
    const uint32_t count_words = DIVIDE_UP(params->capacity, RADIX_BLOCK) * RADIX_DIGITS;
    graph_buffer in = params->pairs;
    for (uint32_t number = 1; (number - 1) * RADIX_BITS < params->bits; number++) {
        uint32_t shift = (number - 1) * RADIX_BITS;
        graph_buffer counts =
            graph_create_buffer(graph, graph_name(graph, "%s sort counts %u", what, number), count_words * 4ull);
        add_step(graph, graph_name(graph, "%s sort count %u", what, number), params, shift, in, counts, (graph_buffer){0});
        prefix_sum_add(graph, graph_name(graph, "%s sort %u", what, number), params->queue, counts, count_words);
        graph_buffer out =
            graph_create_buffer(graph, graph_name(graph, "%s sort pairs %u", what, number), params->capacity * 8ull);
        add_step(graph, graph_name(graph, "%s sort scatter %u", what, number), params, shift, in, counts, out);
        in = out;
    }
    return in;
}
