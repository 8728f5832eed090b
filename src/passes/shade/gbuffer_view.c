/* SPDX-License-Identifier: MIT */
#include "passes/shade/gbuffer_view.h"

#include "passes/shade/gbuffer_layouts.h"
#include "shaders.h"

static void add_view(struct graph *graph, const struct gbuffer *gbuffer, graph_image target,
                     struct gpu_gbuffer_view_push push) {
    struct graph_image_params image = graph_image_info(graph, target);
    push.gbuffer = gbuffer_block(gbuffer);
    struct graph_pass *pass =
        graph_dispatch(graph, &(struct graph_dispatch){.name = "gbuffer view",
                                                       .pipeline = {.shader = &shader_gbuffer_view_comp},
                                                       .groups = {DIVIDE_UP(image.width, 8u), DIVIDE_UP(image.height, 8u)},
                                                       GRAPH_PUSH(push),
                                                       GRAPH_ROWS(graph_stores(&push.target, target))});
    gbuffer_add_rows(pass, &push.gbuffer, gbuffer, GRAPH_SAMPLE_COMPUTE);
}

void gbuffer_view_field_add(struct graph *graph, const struct gbuffer *gbuffer, uint32_t field, graph_image target,
                            bool swap) {
    add_view(graph, gbuffer, target, (struct gpu_gbuffer_view_push){.field_count = 1, .fields = field, .swap = swap});
}

void gbuffer_view_target_add(struct graph *graph, const struct gbuffer *gbuffer, uint32_t index, graph_image target,
                             bool swap) {
    const struct gbuffer_layout *layout = &gbuffer_layouts[GBUFFER_FORM_LAYOUT(gbuffer->form)];
    struct gpu_gbuffer_view_push push = {.from = index, .swap = swap};
    for (uint32_t i = 0; i < layout->field_count; i++)
        if (layout->fields[i].target == index) push.fields |= (uint32_t)layout->semantics[i] << 8 * push.field_count++;
    if (push.field_count == 0) push.field_count = 1; /* normals in floats: 0 is what they are */
    add_view(graph, gbuffer, target, push);
}
