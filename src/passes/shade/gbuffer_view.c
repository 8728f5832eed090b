/* SPDX-License-Identifier: MIT */
#include "passes/shade/gbuffer_view.h"

#include "passes/shade/gbuffer_layouts.h"
#include "shaders.h"

struct view_data {
    struct gbuffer gbuffer;
    graph_image target;
    uint32_t from, field_count, fields, width, height;
    bool swap;
};

static void execute_view(const struct graph_context *context, const void *data) {
    const struct view_data *d = data;
    struct gpu_compute_params params = {.shader = &shader_gbuffer_view_comp};
    struct gpu_gbuffer_view_push push = {.gbuffer = gbuffer_handles(context, &d->gbuffer),
                                         .from = d->from,
                                         .field_count = d->field_count,
                                         .fields = d->fields,
                                         .target = graph_storage(context, d->target),
                                         .swap = d->swap};
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_dispatch(context->commands, DIVIDE_UP(d->width, 8u), DIVIDE_UP(d->height, 8u), 1);
}

static void add_view(struct graph *graph, struct view_data *data) {
    struct graph_image_params image = graph_image_info(graph, data->target);
    data->width = image.width;
    data->height = image.height;
    struct graph_pass *pass = graph_add_pass(graph, "gbuffer view", GRAPH_QUEUE_GRAPHICS, execute_view, data, sizeof *data);
    gbuffer_use(pass, &data->gbuffer, GRAPH_SAMPLE_COMPUTE);
    graph_use_image(pass, data->target, GRAPH_WRITE_COMPUTE);
}

void gbuffer_view_field_add(struct graph *graph, const struct gbuffer *gbuffer, uint32_t field, graph_image target,
                            bool swap) {
    struct view_data data = {.gbuffer = *gbuffer, .target = target, .field_count = 1, .fields = field, .swap = swap};
    add_view(graph, &data);
}

void gbuffer_view_target_add(struct graph *graph, const struct gbuffer *gbuffer, uint32_t index, graph_image target,
                             bool swap) {
    const struct gbuffer_layout *layout = &gbuffer_layouts[GBUFFER_FORM_LAYOUT(gbuffer->form)];
    struct view_data data = {.gbuffer = *gbuffer, .target = target, .from = index, .swap = swap};
    for (uint32_t i = 0; i < layout->field_count; i++)
        if (layout->fields[i].target == index) data.fields |= (uint32_t)layout->semantics[i] << 8 * data.field_count++;
    if (data.field_count == 0) data.field_count = 1; /* normals in floats: 0 is what they are */
    add_view(graph, &data);
}
