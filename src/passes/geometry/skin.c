/* SPDX-License-Identifier: MIT */
#include "passes/geometry/skin.h"

#include "shaders.h"

void skin_add(struct graph *graph, const struct skin_input *input) {
    struct gpu_skin_push push = {.positions = input->positions,
                                 .attributes = input->attributes,
                                 .deforms = input->deforms,
                                 .influences = input->influences,
                                 .morphs = input->morphs,
                                 .weights = input->weights,
                                 .matrices = input->matrices};
    struct graph_pass *pass = NULL;
    for (uint32_t i = 0; i < input->deform_count; i++) {
        push.deform = i;
        pass = graph_dispatch(graph, &(struct graph_dispatch){.pass = pass,
                                                              .name = "skin",
                                                              .pipeline = {.shader = &shader_skin_comp},
                                                              .groups = {DIVIDE_UP(input->vertex_counts[i], 64u)},
                                                              GRAPH_PUSH(push),
                                                              GRAPH_ROWS(graph_changes(NULL, input->vertices))});
    }
}
