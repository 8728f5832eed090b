/* SPDX-License-Identifier: MIT */
#include "passes/decals/decals.h"

#include "passes/decals/decals_pass_shared.h"
#include "shaders.h"

graph_buffer decals_count_pass_add(struct graph *graph, const struct decals_count_input *input) {
    graph_buffer counts = graph_create_buffer(graph, "decal counts", input->width * input->height * 4ull);
    struct gpu_decals_count_push push = {.view = input->view};
    struct graph_pass *pass = graph_dispatch(
        graph, &(struct graph_dispatch){
                   .name = "count decals",
                   .pipeline = {.shader = &shader_decals_count_comp},
                   .groups = {DIVIDE_UP(input->width, 8u), DIVIDE_UP(input->height, 8u)},
                   GRAPH_PUSH(push),
                   GRAPH_ROWS(graph_reads(NULL, input->decals), graph_samples(&push.position, input->position),
                              graph_samples(&push.normal, input->normal), graph_writes(&push.counts, counts))});
    light_list_use(pass, input->list, GRAPH_READ_COMPUTE);
    return counts;
}
