/* SPDX-License-Identifier: MIT */
#include "passes/geometry/skin.h"

#include "shaders.h"

static void execute_skin(const struct graph_context *context, const void *data) {
    const struct skin_input *d = data;
    struct gpu_compute_params params = {.shader = &shader_skin_comp};
    struct gpu_skin_push push = {.positions = d->positions,
                                 .attributes = d->attributes,
                                 .deforms = d->deforms,
                                 .influences = d->influences,
                                 .morphs = d->morphs,
                                 .weights = d->weights,
                                 .matrices = d->matrices};
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    for (uint32_t i = 0; i < d->deform_count; i++) {
        push.deform = i;
        gpu_push(context->commands, &push, sizeof push);
        gpu_dispatch_linear(context->commands, DIVIDE_UP(d->vertex_counts[i], 64u));
    }
}

void skin_add(struct graph *graph, const struct skin_input *input) {
    if (input->deform_count == 0) return;
    struct graph_pass *pass = graph_add_pass(graph, "skin", GRAPH_QUEUE_GRAPHICS, execute_skin, input, sizeof *input);
    graph_use_buffer(pass, input->vertices, GRAPH_READ_WRITE_COMPUTE);
}
