/* SPDX-License-Identifier: MIT */
#include "passes/shade/deferred_msaa.h"

#include "shaders.h"

struct msaa_data {
    struct gbuffer gbuffer;
    struct edges edges;
    graph_image radiance;
    graph_buffer counters, results;
    VkDeviceAddress view, lights;
    VkFormat format;
    uint32_t kind, method, step, width, height, samples, slots;
    bool merged;
};

static void set_constants(const struct msaa_data *d, uint32_t *count, uint32_t *constants) {
    bool floats = d->format == VK_FORMAT_R32G32B32A32_SFLOAT;
    const uint32_t values[14] = {d->kind,  d->counters.id != 0, 1, 1, [9] = d->samples, d->method, floats, d->step,
                                 d->merged};
    *count = COUNT_OF(values);
    memcpy(constants, values, sizeof values);
    gbuffer_specialise(&d->gbuffer, constants, count);
}

static struct gpu_deferred_msaa_push push_of(const struct graph_context *context, const struct msaa_data *d) {
    return (struct gpu_deferred_msaa_push){.view = d->view,
                                           .lights = d->lights,
                                           .surfaces = graph_address(context, d->edges.surfaces),
                                           .sums = d->edges.sums.id ? graph_address(context, d->edges.sums) : 0,
                                           .results = graph_address(context, d->results),
                                           .gbuffer = gbuffer_handles(context, &d->gbuffer)};
}

/* ---- shading ---- */

static void execute_shade(const struct graph_context *context, const void *data) {
    const struct msaa_data *d = data;
    struct gpu_compute_params params = {.shader = &shader_deferred_msaa_comp};
    set_constants(d, &params.constant_count, params.constants);
    struct gpu_deferred_msaa_push push = push_of(context, d);
    push.radiance = graph_sampled(context, d->radiance);
    if (d->counters.id) {
        push.counters = graph_address(context, d->counters);
        push.counts = graph_address(context, d->edges.counts);
    }
    bool listed = d->step == MSAA_STEP_REST && d->edges.entries.id;
    if (listed) push.entries = graph_address(context, d->edges.entries);
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    if (listed) {
        gpu_dispatch_indirect(context->commands, graph_get_buffer(context, d->edges.dispatch), 0);
        return;
    }
    uint32_t layers = d->method == MSAA_ALL ? d->samples : d->step == MSAA_STEP_REST ? d->samples - 1 : 1;
    gpu_dispatch(context->commands, DIVIDE_UP(d->width, 8u), DIVIDE_UP(d->height, 8u), layers);
}

static void add_step(struct graph *graph, const char *name, const struct shade_input *input, const struct msaa_data *data) {
    struct graph_pass *pass = graph_add_pass(graph, name, GRAPH_QUEUE_GRAPHICS, execute_shade, data, sizeof *data);
    gbuffer_use(pass, &data->gbuffer, GRAPH_SAMPLE_COMPUTE);
    graph_use_image(pass, data->radiance, GRAPH_SAMPLE_COMPUTE);
    graph_use_buffer(pass, data->edges.surfaces, GRAPH_READ_COMPUTE);
    if (data->edges.sums.id) graph_use_buffer(pass, data->edges.sums, GRAPH_READ_COMPUTE);
    if (data->step == MSAA_STEP_REST && data->edges.entries.id) {
        graph_use_buffer(pass, data->edges.entries, GRAPH_READ_COMPUTE);
        graph_use_buffer(pass, data->edges.dispatch, GRAPH_INDIRECT);
    }
    /* The steps fill different slots. */
    graph_use_buffer(pass, data->results, GRAPH_WRITE_COMPUTE);
    light_list_use(pass, input->lights, GRAPH_READ_COMPUTE);
    if (!data->counters.id) return;
    graph_use_buffer(pass, data->counters, GRAPH_READ_WRITE_COMPUTE);
    graph_use_buffer(pass, data->edges.counts, GRAPH_READ_WRITE_COMPUTE);
}

/* ---- spreading ---- */

static void execute_spread(const struct graph_context *context, const void *data) {
    const struct msaa_data *d = data;
    struct gpu_graphics_params params = {.vertex = &shader_deferred_msaa_spread_vert,
                                         .fragment = &shader_deferred_msaa_spread_frag,
                                         .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST,
                                         .color_count = 1,
                                         .color_formats = {d->format},
                                         .samples = d->samples};
    set_constants(d, &params.constant_count, params.constants);
    struct gpu_deferred_msaa_push push = push_of(context, d);
    gpu_bind(context->commands, gpu_graphics_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_draw(context->commands, 3, d->slots, 0, 0);
}

static void add_spread(struct graph *graph, const struct msaa_data *data) {
    struct graph_pass *pass =
        graph_add_pass(graph, "deferred spread", GRAPH_QUEUE_GRAPHICS, execute_spread, data, sizeof *data);
    gbuffer_use(pass, &data->gbuffer, GRAPH_SAMPLE_FRAGMENT);
    graph_use_buffer(pass, data->edges.surfaces, GRAPH_READ_FRAGMENT);
    if (data->edges.sums.id) graph_use_buffer(pass, data->edges.sums, GRAPH_READ_FRAGMENT);
    graph_use_buffer(pass, data->results, GRAPH_READ_FRAGMENT);
    graph_color(pass, data->radiance, VK_ATTACHMENT_LOAD_OP_LOAD, NULL);
}

struct edges deferred_msaa_add(struct graph *graph, const struct shade_input *input, const struct gbuffer *gbuffer,
                               const struct deferred_msaa_params *params, graph_image radiance) {
    struct graph_image_params target = graph_image_info(graph, radiance);
    struct msaa_data data = {.gbuffer = *gbuffer,
                             .radiance = radiance,
                             .counters = input->counters,
                             .view = input->view,
                             .lights = input->lights->header,
                             .format = target.format,
                             .kind = input->lights->kind,
                             .method = params->method,
                             .width = input->width,
                             .height = input->height,
                             .samples = target.samples,
                             .slots = target.samples,
                             .merged = params->method == MSAA_AGGREGATE || params->tolerance > 0};
    bool merges = params->method == MSAA_AGGREGATE, lists = merges || params->method == MSAA_COMPACT;
    if (merges) data.slots = MIN(params->groups, target.samples);
    struct edges_params edges = {.tolerance = params->tolerance, .limit = data.slots, .lists = lists};
    data.edges = edges_add(graph, input, gbuffer, radiance, &edges);
    uint64_t size = target.format == VK_FORMAT_R32G32B32A32_SFLOAT ? 12 : 8;
    uint32_t kept = params->method == MSAA_COVERAGE ? 1 : data.slots;
    data.results = graph_create_buffer(graph, "sample radiance", (uint64_t)input->width * input->height * kept * size);
    add_step(graph, "deferred", input, &data);
    if (lists || params->method == MSAA_STENCIL) {
        data.step = MSAA_STEP_REST;
        add_step(graph, "deferred edges", input, &data);
    }
    add_spread(graph, &data);
    return data.edges;
}
