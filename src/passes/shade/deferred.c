/* SPDX-License-Identifier: MIT */
#include "passes/shade/classify.h"
#include "passes/shade/deferred.h"
#include "passes/shade/shade_shared.h"
#include "shaders.h"

#define MAX_VISITS (1ull << 32) /* of lights by the pixels of a dispatch */

struct deferred_data {
    struct gpu_deferred_push push;
    struct gpu_compute_params pipeline;
    uint32_t width, height, light_count;
    graph_buffer dispatches;
    bool by_class;
};

static void execute_rows(const struct graph_context *context, const struct deferred_data *d) {
    struct gpu_deferred_push push = d->push;
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &d->pipeline));
    /* Systems reset a device that stays with one piece of work for seconds; here every pixel might visit every light. */
    uint32_t groups = DIVIDE_UP(d->height, 8u);
    uint64_t visits = 8ull * d->width * MAX(d->light_count, 1u); /* of a row of groups */
    uint32_t together = (uint32_t)CLAMP(MAX_VISITS / visits, 1ull, (uint64_t)groups);
    for (uint32_t first = 0; first < groups; first += together) {
        push.first_row = first * 8;
        gpu_push(context->commands, &push, sizeof push);
        gpu_dispatch(context->commands, DIVIDE_UP(d->width, 8u), MIN(together, groups - first), 1);
    }
}

static void execute_deferred(const struct graph_context *context, const void *data) {
    const struct deferred_data *d = data;
    if (!d->by_class) {
        execute_rows(context, d);
        return;
    }
    struct gpu_deferred_push push = d->push;
    struct gpu_compute_params params = d->pipeline;
    for (push.class_index = 0; push.class_index < SHADE_CLASSES; push.class_index++) {
        params.constants[HAS_LIGHTS_ID] = (push.class_index & SHADE_LIGHTS) != 0;
        params.constants[HAS_METAL_ID] = (push.class_index & SHADE_METAL) != 0;
        params.constants[IS_FULL_ID] = (push.class_index & SHADE_FULL) != 0;
        gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
        gpu_push(context->commands, &push, sizeof push);
        gpu_dispatch_indirect(context->commands, graph_get_buffer(context, d->dispatches), push.class_index * 12ull);
    }
}

void deferred_add(struct graph *graph, const struct shade_input *input, const struct gbuffer *gbuffer,
                  const struct shade_classes *classes, graph_image radiance) {
    bool counts = input->counters.id;
    struct deferred_data data = {
        .push = {.view = input->view, .lights = input->lights->header, .gbuffer = gbuffer_block(gbuffer)},
        .pipeline = {&shader_deferred_comp,
                     BLOCK_SIZE_ID + 1,
                     {[LISTS_ID] = input->lights->kind, [COUNT_LIGHTS_ID] = counts, [HAS_LIGHTS_ID] = 1, [HAS_METAL_ID] = 1}},
        .width = input->width,
        .height = input->height,
        .light_count = input->light_count,
        .by_class = classes};
    if (classes) {
        data.dispatches = classes->dispatches;
        data.push.block_count = classes->block_count;
        data.pipeline.constants[BLOCK_SIZE_ID] = classes->block_size;
    }
    gbuffer_specialise(gbuffer, data.pipeline.constants, &data.pipeline.constant_count);
    struct graph_pass *pass = graph_add_pass(graph, "deferred", GRAPH_QUEUE_GRAPHICS, execute_deferred, &data, sizeof data);
    gbuffer_add_rows(pass, &data.push.gbuffer, gbuffer, GRAPH_SAMPLE_COMPUTE);
    graph_add_row(pass, graph_image_row(&data.push.radiance, radiance, GRAPH_READ_WRITE_COMPUTE));
    light_list_use(pass, input->lights, GRAPH_READ_COMPUTE);
    graph_add_row(pass, graph_row_if(counts, graph_changes(&data.push.counters, input->counters)));
    if (!classes) return;
    graph_add_row(pass, graph_reads(&data.push.sums, classes->sums));
    graph_add_row(pass, graph_reads(&data.push.blocks, classes->blocks));
    graph_use_buffer(pass, classes->dispatches, GRAPH_INDIRECT);
}
