/* SPDX-License-Identifier: MIT */
#include "passes/shade/classify.h"

#include "passes/geometry/prefix_sum.h"
#include "shaders.h"

struct shade_classes classify_add(struct graph *graph, const struct shade_input *input, const struct gbuffer *gbuffer,
                                  uint32_t block_size) {
    uint32_t count = DIVIDE_UP(input->width, block_size) * DIVIDE_UP(input->height, block_size);
    graph_buffer classes = graph_create_buffer(graph, "block classes", count * 4ull);
    struct shade_classes out = {.sums = graph_create_buffer(graph, "class sums", (count * SHADE_CLASSES + 1) * 4ull),
                                .blocks = graph_create_buffer(graph, "class blocks", count * 4ull),
                                .dispatches = graph_create_buffer(graph, "class dispatches", SHADE_CLASSES * 12ull),
                                .counts = graph_create_buffer(graph, "class counts", (SHADE_CLASSES + 1) * 4ull),
                                .block_size = block_size,
                                .block_count = count};
    const struct gpu_classify_push common = {.view = input->view,
                                             .lighting = input->lighting->address,
                                             .block_size = block_size,
                                             .blocks_x = DIVIDE_UP(input->width, block_size),
                                             .block_count = count};
    struct gpu_classify_push push = common;
    push.gbuffer = gbuffer_block(gbuffer);
    struct gpu_compute_params pipeline = {&shader_classify_mark_comp, 1, {input->lighting->bits}};
    gbuffer_specialise(gbuffer, pipeline.constants, &pipeline.constant_count);
    struct graph_pass *pass = graph_dispatch(
        graph,
        &(struct graph_dispatch){.name = "classify",
                                 .pipeline = pipeline,
                                 .groups = {DIVIDE_UP(input->width, 8u), DIVIDE_UP(input->height, 8u)},
                                 GRAPH_PUSH(push),
                                 GRAPH_ROWS(graph_writes(&push.classes, classes), graph_writes(&push.sums, out.sums))});
    gbuffer_add_rows(pass, &push.gbuffer, gbuffer, GRAPH_SAMPLE_COMPUTE);
    lighting_use(pass, input->lighting, GRAPH_READ_COMPUTE);
    prefix_sum_add(graph, "classes", GRAPH_QUEUE_GRAPHICS, out.sums, count * SHADE_CLASSES + 1);
    push = common;
    graph_dispatch(graph,
                   &(struct graph_dispatch){
                       .name = "classify fill",
                       .pipeline = {&shader_classify_fill_comp, 1, {input->lighting->bits}},
                       .groups = {DIVIDE_UP(MAX(count, SHADE_CLASSES + 1), 64u)},
                       GRAPH_PUSH(push),
                       GRAPH_ROWS(graph_reads(&push.classes, classes), graph_reads(&push.sums, out.sums),
                                  graph_writes(&push.blocks, out.blocks), graph_writes(&push.dispatches, out.dispatches),
                                  graph_writes(&push.counts, out.counts))});
    return out;
}
