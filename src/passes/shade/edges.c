/* SPDX-License-Identifier: MIT */
#include "passes/shade/edges.h"

#include "passes/geometry/prefix_sum.h"
#include "shaders.h"

struct edges edges_add(struct graph *graph, const struct shade_input *input, const struct gbuffer *gbuffer,
                       graph_image radiance, const struct edges_params *params) {
    struct edges out = {0};
    uint32_t pixels = input->width * input->height;
    out.surfaces = graph_create_buffer(graph, "edge surfaces", pixels * 4ull);
    out.counts = graph_create_buffer(graph, "edge counts", EDGES_COUNTS * 4ull);
    if (params->lists) {
        out.sums = graph_create_buffer(graph, "edge sums", (pixels + 1ull) * 4);
        out.entries = graph_create_buffer(graph, "edge entries", (uint64_t)pixels * (params->limit - 1) * 4);
        out.dispatch = graph_create_buffer(graph, "edge dispatch", 12);
    }
    graph_add_clear(graph, "clear edge counts", GRAPH_QUEUE_GRAPHICS, (struct graph_clear){.buffers = {out.counts}});
    struct gpu_edges_push push = {.view = input->view,
                                  .gbuffer = gbuffer_block(gbuffer),
                                  .tolerance = params->tolerance,
                                  .limit = params->limit,
                                  .lists = params->lists};
    struct gpu_compute_params pipeline = {&shader_edges_find_comp, SAMPLES_ID + 1, {[SAMPLES_ID] = graph_image_info(graph, radiance).samples}};
    gbuffer_specialise(gbuffer, pipeline.constants, &pipeline.constant_count);
    struct graph_pass *pass = graph_dispatch(
        graph, &(struct graph_dispatch){.name = "edges",
                                        .pipeline = pipeline,
                                        .groups = {DIVIDE_UP(input->width, 8u), DIVIDE_UP(input->height, 8u)},
                                        GRAPH_PUSH(push),
                                        GRAPH_ROWS(graph_samples(&push.radiance, radiance),
                                                   graph_writes(&push.surfaces, out.surfaces),
                                                   graph_changes(&push.counts, out.counts),
                                                   graph_row_if(params->lists, graph_writes(&push.sums, out.sums)))});
    gbuffer_add_rows(pass, &push.gbuffer, gbuffer, GRAPH_SAMPLE_COMPUTE);
    if (!params->lists) return out;
    prefix_sum_add(graph, "edges", GRAPH_QUEUE_GRAPHICS, out.sums, pixels + 1);
    push = (struct gpu_edges_push){.view = input->view};
    graph_dispatch(graph, &(struct graph_dispatch){.name = "edges fill",
                                                   .pipeline = {.shader = &shader_edges_fill_comp},
                                                   .groups = {DIVIDE_UP(pixels, 64u)},
                                                   GRAPH_PUSH(push),
                                                   GRAPH_ROWS(graph_reads(&push.sums, out.sums),
                                                              graph_writes(&push.entries, out.entries),
                                                              graph_writes(&push.dispatch, out.dispatch))});
    return out;
}
