/* SPDX-License-Identifier: MIT */
#include "passes/shade/classify.h"
#include "passes/shade/deferred.h"
#include "passes/shade/shade_shared.h"
#include "shaders.h"

#define MAX_VISITS (1ull << 32) /* of lights by the pixels of a dispatch */

struct deferred_data {
    struct gbuffer gbuffer;
    graph_image radiance;
    VkDeviceAddress view, lights;
    graph_buffer counters;
    uint32_t kind, width, height, light_count;
    struct shade_classes classes;
};

static void execute_deferred(const struct graph_context *context, const void *data) {
    const struct deferred_data *d = data;
    struct gpu_compute_params params = {
        .shader = &shader_deferred_comp, .constant_count = 6, .constants = {d->kind, d->counters.id != 0, 1, 1, 0, 0}};
    gbuffer_specialise(&d->gbuffer, params.constants, &params.constant_count);
    struct gpu_deferred_push push = {.view = d->view,
                                     .lights = d->lights,
                                     .counters = d->counters.id ? graph_address(context, d->counters) : 0,
                                     .gbuffer = gbuffer_handles(context, &d->gbuffer),
                                     .radiance = graph_storage(context, d->radiance)};
    if (d->classes.block_count == 0) {
        gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
        /* Systems reset a device that stays with one piece of work for seconds; here every pixel might visit every light. */
        uint32_t groups = DIVIDE_UP(d->height, 8u);
        uint64_t visits = 8ull * d->width * MAX(d->light_count, 1u); /* of a row of groups */
        uint32_t together = (uint32_t)CLAMP(MAX_VISITS / visits, 1ull, (uint64_t)groups);
        for (uint32_t first = 0; first < groups; first += together) {
            push.first_row = first * 8;
            gpu_push(context->commands, &push, sizeof push);
            gpu_dispatch(context->commands, DIVIDE_UP(d->width, 8u), MIN(together, groups - first), 1);
        }
        return;
    }
    push.sums = graph_address(context, d->classes.sums);
    push.blocks = graph_address(context, d->classes.blocks);
    push.block_count = d->classes.block_count;
    params.constants[5] = d->classes.block_size;
    for (push.class_index = 0; push.class_index < SHADE_CLASSES; push.class_index++) {
        params.constants[2] = (push.class_index & SHADE_LIGHTS) != 0;
        params.constants[3] = (push.class_index & SHADE_METAL) != 0;
        params.constants[4] = (push.class_index & SHADE_FULL) != 0;
        gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
        gpu_push(context->commands, &push, sizeof push);
        gpu_dispatch_indirect(context->commands, graph_get_buffer(context, d->classes.dispatches), push.class_index * 12ull);
    }
}

void deferred_add(struct graph *graph, const struct shade_input *input, const struct gbuffer *gbuffer,
                  const struct shade_classes *classes, graph_image radiance) {
    struct deferred_data data = {.gbuffer = *gbuffer,
                                 .radiance = radiance,
                                 .view = input->view,
                                 .lights = input->lights->header,
                                 .counters = input->counters,
                                 .kind = input->lights->kind,
                                 .width = input->width,
                                 .height = input->height,
                                 .light_count = input->light_count};
    if (classes) data.classes = *classes;
    struct graph_pass *pass = graph_add_pass(graph, "deferred", GRAPH_QUEUE_GRAPHICS, execute_deferred, &data, sizeof data);
    gbuffer_use(pass, gbuffer, GRAPH_SAMPLE_COMPUTE);
    graph_use_image(pass, radiance, GRAPH_READ_WRITE_COMPUTE);
    light_list_use(pass, input->lights, GRAPH_READ_COMPUTE);
    if (input->counters.id) graph_use_buffer(pass, input->counters, GRAPH_READ_WRITE_COMPUTE);
    if (!classes) return;
    graph_use_buffer(pass, classes->sums, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, classes->blocks, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, classes->dispatches, GRAPH_INDIRECT);
}
