/* SPDX-License-Identifier: MIT */
#include "passes/shadow/dark.h"

#include "passes/shadow/dark_shared.h"
#include "passes/shadow/fill_shared.h"
#include "constants_shared.h"
#include "shaders.h"

void shadow_least_add(struct graph *graph, const struct shadow_pages *pages, const struct shadow_fill *fill) {
    struct gpu_shadow_least_push push = {.side = graph_image_info(graph, pages->atlas).width};
    graph_dispatch(graph, &(struct graph_dispatch){.name = "shadow least",
                                                   .pipeline = {.shader = &shader_dark_least_comp},
                                                   .indirect = fill->totals,
                                                   .indirect_offset = offsetof(struct gpu_fill_totals, groups),
                                                   GRAPH_PUSH(push),
                                                   GRAPH_ROWS(graph_reads(&push.drawn, fill->drawn), graph_reads(&push.pages, pages->pages),
                                                              graph_changes(&push.least, pages->least), graph_samples(&push.atlas, pages->atlas))});
}

void shadow_dark_add(struct graph *graph, const struct shadow_pages *pages, const struct lighting *lighting, graph_image depth, graph_buffer classes) {
    const struct graph_image_params image = graph_image_info(graph, depth);
    struct gpu_shadow_dark_push push = {.lighting = lighting->address, .side = graph_image_info(graph, pages->atlas).width};
    struct lighting others = *lighting;
    others.list.cells = others.list.ids = (graph_buffer){0};
    struct graph_pass *pass = graph_dispatch(
        graph, &(struct graph_dispatch){.name = "shadow dark",
                                        .pipeline = {&shader_dark_comp, 2, {[LIGHTING_ID] = lighting->bits, 1}},
                                        .groups = {DIVIDE_UP(image.width, 8u), DIVIDE_UP(image.height, 8u)},
                                        GRAPH_PUSH(push),
                                        GRAPH_ROWS(graph_changes(NULL, lighting->list.cells), graph_changes(NULL, lighting->list.ids),
                                                   graph_changes(&push.counts, pages->counts), graph_reads(&push.least, pages->least),
                                                   graph_row_if(classes.id > 0, graph_writes(&push.classes, classes)),
                                                   graph_samples(&push.depth, depth))});
    lighting_use(pass, &others, GRAPH_READ_COMPUTE);
}
