/* SPDX-License-Identifier: MIT */
#include "passes/shade/deferred_msaa.h"

#include "shaders.h"

struct msaa_data {
    struct gbuffer gbuffer;
    struct edges edges;
    graph_image radiance;
    graph_buffer counters, results;
    VkDeviceAddress view, lighting;
    VkFormat format;
    uint32_t bits, method, step, width, height, samples, slots;
    bool merged;
};

static void set_constants(const struct msaa_data *d, uint32_t *count, uint32_t *constants) {
    bool floats = d->format == VK_FORMAT_R32G32B32A32_SFLOAT;
    const uint32_t values[14] = {[LIGHTING_ID] = d->bits,
                                 [COUNT_LIGHTS_ID] = d->counters.id != 0,
                                 [HAS_LIGHTS_ID] = 1,
                                 [HAS_METAL_ID] = 1,
                                 [SAMPLES_ID] = d->samples,
                                 [MSAA_METHOD_ID] = d->method,
                                 [FLOATS_ID] = floats,
                                 [MSAA_STEP_ID] = d->step,
                                 [MSAA_MERGED_ID] = d->merged};
    *count = COUNT_OF(values);
    memcpy(constants, values, sizeof values);
    gbuffer_specialise(&d->gbuffer, constants, count);
}

static struct gpu_deferred_msaa_push push_of(const struct msaa_data *d) {
    return (struct gpu_deferred_msaa_push){.view = d->view, .lighting = d->lighting, .gbuffer = gbuffer_block(&d->gbuffer)};
}

/* ---- shading ---- */

static void add_step(struct graph *graph, const char *name, const struct shade_input *input, const struct msaa_data *d) {
    struct gpu_compute_params pipeline = {.shader = &shader_deferred_msaa_comp};
    set_constants(d, &pipeline.constant_count, pipeline.constants);
    struct gpu_deferred_msaa_push push = push_of(d);
    bool rest = d->step == MSAA_STEP_REST, listed = rest && d->edges.entries.id, counts = d->counters.id;
    uint32_t layers = d->method == MSAA_ALL ? d->samples : rest ? d->samples - 1 : 1;
    struct graph_pass *pass = graph_dispatch(
        graph, &(struct graph_dispatch){
                   .name = name,
                   .pipeline = pipeline,
                   .groups = {DIVIDE_UP(d->width, 8u), DIVIDE_UP(d->height, 8u), layers},
                   .indirect = listed ? d->edges.dispatch : (graph_buffer){0},
                   GRAPH_PUSH(push),
                   GRAPH_ROWS(graph_samples(&push.radiance, d->radiance), graph_reads(&push.surfaces, d->edges.surfaces),
                              graph_row_if(d->edges.sums.id, graph_reads(&push.sums, d->edges.sums)),
                              graph_row_if(listed, graph_reads(&push.entries, d->edges.entries)),
                              graph_writes(&push.results, d->results), /* the steps fill different slots */
                              graph_row_if(counts, graph_changes(&push.counters, d->counters)),
                              graph_row_if(counts, graph_changes(&push.counts, d->edges.counts)))});
    gbuffer_add_rows(pass, &push.gbuffer, &d->gbuffer, GRAPH_SAMPLE_COMPUTE);
    lighting_use(pass, input->lighting, GRAPH_READ_COMPUTE);
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
    struct gpu_deferred_msaa_push push = push_of(d);
    push.gbuffer = gbuffer_handles(context, &d->gbuffer);
    push.surfaces = graph_address(context, d->edges.surfaces);
    push.sums = d->edges.sums.id ? graph_address(context, d->edges.sums) : 0;
    push.results = graph_address(context, d->results);
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
                             .lighting = input->lighting->address,
                             .format = target.format,
                             .bits = input->lighting->bits,
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
