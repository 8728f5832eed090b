/* SPDX-License-Identifier: MIT */
#include "passes/aa/morphological.h"

#include "passes/aa/morphological_shared.h"
#include "shaders.h"

static graph_image add(struct graph *graph, const char *name, const struct gpu_shader *shader, uint32_t kind,
                       graph_image picture, const struct morphological_params *params) {
    struct graph_image_params image = graph_image_info(graph, picture);
    uint64_t row_words = DIVIDE_UP(image.width, 32u), column_words = DIVIDE_UP(image.height, 32u);
    graph_buffer edges = graph_create_buffer(graph, "edges of the picture",
                                             (image.height * row_words + image.width * column_words) * 2 * sizeof(uint32_t));
    graph_image target = graph_create_image(
        graph, &(struct graph_image_params){
                   .name = "antialiased picture", .format = image.format, .width = image.width, .height = image.height});
    struct gpu_morphological_push push = {
        .width = image.width, .height = image.height, .linear = params->linear, .swap = params->swap};
    graph_dispatch(graph, &(struct graph_dispatch){
                              .name = graph_name(graph, "%s edges", name),
                              .pipeline = {&shader_morphological_edges_comp, 1, {kind}},
                              .groups = {DIVIDE_UP(image.width, 32u), DIVIDE_UP(image.height, 32u)},
                              GRAPH_PUSH(push),
                              GRAPH_ROWS(graph_samples(&push.picture, picture), graph_writes(&push.edges, edges))});
    graph_dispatch(
        graph, &(struct graph_dispatch){.name = name,
                                        .pipeline = {.shader = shader},
                                        .groups = {DIVIDE_UP(image.width, 8u), DIVIDE_UP(image.height, 8u)},
                                        GRAPH_PUSH(push),
                                        GRAPH_ROWS(graph_samples(&push.picture, picture), graph_reads(&push.edges, edges),
                                                   graph_stores(&push.target, target))});
    return target;
}

graph_image mlaa_add(struct graph *graph, graph_image picture, const struct morphological_params *params) {
    return add(graph, "mlaa", &shader_mlaa_comp, GPU_EDGES_COLOR, picture, params);
}

graph_image smaa_add(struct graph *graph, graph_image picture, const struct morphological_params *params) {
    return add(graph, "smaa", &shader_smaa_comp, GPU_EDGES_LUMA, picture, params);
}
