/* SPDX-License-Identifier: MIT */
#include "passes/aa/morphological.h"

#include "passes/aa/morphological_shared.h"
#include "shaders.h"

struct morphological_data {
    struct morphological_params params;
    const struct gpu_shader *shader;
    uint32_t kind; /* GPU_EDGES_… */
    graph_image picture, target;
    graph_buffer edges;
    uint32_t width, height;
};

static struct gpu_morphological_push push_of(const struct graph_context *context, const struct morphological_data *d) {
    return (struct gpu_morphological_push){.edges = graph_address(context, d->edges),
                                           .picture = graph_sampled(context, d->picture),
                                           .width = d->width,
                                           .height = d->height,
                                           .linear = d->params.linear,
                                           .swap = d->params.swap};
}

static void execute_edges(const struct graph_context *context, const void *data) {
    const struct morphological_data *d = data;
    struct gpu_compute_params params = {
        .shader = &shader_morphological_edges_comp, .constant_count = 1, .constants = {d->kind}};
    struct gpu_morphological_push push = push_of(context, d);
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_dispatch(context->commands, DIVIDE_UP(d->width, 32u), DIVIDE_UP(d->height, 32u), 1);
}

static void execute_blend(const struct graph_context *context, const void *data) {
    const struct morphological_data *d = data;
    struct gpu_compute_params params = {.shader = d->shader};
    struct gpu_morphological_push push = push_of(context, d);
    push.target = graph_storage(context, d->target);
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_dispatch(context->commands, DIVIDE_UP(d->width, 8u), DIVIDE_UP(d->height, 8u), 1);
}

static graph_image add(struct graph *graph, const char *edges_name, const char *name, graph_image picture,
                       struct morphological_data data) {
    struct graph_image_params image = graph_image_info(graph, picture);
    uint64_t row_words = DIVIDE_UP(image.width, 32u), column_words = DIVIDE_UP(image.height, 32u);
    data.picture = picture;
    data.width = image.width;
    data.height = image.height;
    data.edges = graph_create_buffer(graph, "edges of the picture",
                                     (image.height * row_words + image.width * column_words) * 2 * sizeof(uint32_t));
    data.target = graph_create_image(
        graph, &(struct graph_image_params){
                   .name = "antialiased picture", .format = image.format, .width = image.width, .height = image.height});
    struct graph_pass *pass = graph_add_pass(graph, edges_name, GRAPH_QUEUE_GRAPHICS, execute_edges, &data, sizeof data);
    graph_use_image(pass, picture, GRAPH_SAMPLE_COMPUTE);
    graph_use_buffer(pass, data.edges, GRAPH_WRITE_COMPUTE);
    pass = graph_add_pass(graph, name, GRAPH_QUEUE_GRAPHICS, execute_blend, &data, sizeof data);
    graph_use_image(pass, picture, GRAPH_SAMPLE_COMPUTE);
    graph_use_buffer(pass, data.edges, GRAPH_READ_COMPUTE);
    graph_use_image(pass, data.target, GRAPH_WRITE_COMPUTE);
    return data.target;
}

graph_image mlaa_add(struct graph *graph, graph_image picture, const struct morphological_params *params) {
    struct morphological_data data = {.params = *params, .shader = &shader_mlaa_comp, .kind = GPU_EDGES_COLOR};
    return add(graph, "mlaa edges", "mlaa", picture, data);
}

graph_image smaa_add(struct graph *graph, graph_image picture, const struct morphological_params *params) {
    struct morphological_data data = {.params = *params, .shader = &shader_smaa_comp, .kind = GPU_EDGES_LUMA};
    return add(graph, "smaa edges", "smaa", picture, data);
}
