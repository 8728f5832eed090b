/* SPDX-License-Identifier: MIT */
#include "passes/decals/decals.h"

#include "passes/decals/decals_pass_shared.h"
#include "shaders.h"

struct count_data {
    VkDeviceAddress view;
    graph_image position, normal;
    graph_buffer counts;
    uint32_t width, height;
};

static void execute_count(const struct graph_context *context, const void *data) {
    const struct count_data *d = data;
    struct gpu_compute_params params = {.shader = &shader_decals_count_comp};
    struct gpu_decals_count_push push = {.view = d->view,
                                         .counts = graph_address(context, d->counts),
                                         .position = graph_sampled(context, d->position),
                                         .normal = graph_sampled(context, d->normal)};
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_dispatch(context->commands, DIVIDE_UP(d->width, 8u), DIVIDE_UP(d->height, 8u), 1);
}

graph_buffer decals_count_pass_add(struct graph *graph, const struct decals_count_input *input) {
    struct count_data data = {.view = input->view,
                              .position = input->position,
                              .normal = input->normal,
                              .counts = graph_create_buffer(graph, "decal counts", input->width * input->height * 4ull),
                              .width = input->width,
                              .height = input->height};
    struct graph_pass *pass = graph_add_pass(graph, "count decals", GRAPH_QUEUE_GRAPHICS, execute_count, &data, sizeof data);
    light_list_use(pass, input->list, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, input->decals, GRAPH_READ_COMPUTE);
    graph_use_image(pass, input->position, GRAPH_SAMPLE_COMPUTE);
    graph_use_image(pass, input->normal, GRAPH_SAMPLE_COMPUTE);
    graph_use_buffer(pass, data.counts, GRAPH_WRITE_COMPUTE);
    return data.counts;
}
