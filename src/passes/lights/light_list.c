/* SPDX-License-Identifier: MIT */
#include "passes/lights/light_list.h"

#include "passes/geometry/prefix_sum.h"
#include "passes/lights/cells.h"
#include "shaders.h"

void light_list_use(struct graph_pass *pass, const struct light_list *list, enum graph_use use) {
    graph_use_buffer(pass, list->lights, use);
    if (list->cells.id) graph_use_buffer(pass, list->cells, use);
    if (list->ids.id) graph_use_buffer(pass, list->ids, use);
    if (list->extra.id) graph_use_buffer(pass, list->extra, use);
}

struct gpu_light_list *light_list_header(gpu_device *device, const struct light_input *input, VkDeviceAddress *out_address) {
    struct gpu_slice slice = gpu_frame_allocate(device, sizeof(struct gpu_light_list));
    *out_address = slice.address;
    if (slice.data)
        *(struct gpu_light_list *)slice.data = (struct gpu_light_list){.directional_count = input->directional_count,
                                                                       .local_count = input->local_count,
                                                                       .tile_size = 1,
                                                                       .tiles_x = 1,
                                                                       .tiles_y = 1,
                                                                       .slices = 1,
                                                                       .lights = input->lights};
    return slice.data;
}

struct light_list light_list_all_add(struct graph *graph, gpu_device *device, const struct light_input *input) {
    UNUSED(graph);
    struct light_list list = {
        .kind = GPU_LIST_ALL, .lights = input->buffer, .totals_known = true, .known = {.in_view = input->local_count}};
    light_list_header(device, input, &list.header);
    return list;
}

/* ---- lights in view ---- */

struct view_data {
    struct light_input input;
    struct lights_in_view in_view;
    VkDeviceAddress header;
    const struct gpu_shader *shader;
};

static void execute_lights(const struct graph_context *context, const void *data) {
    const struct view_data *d = data;
    bool gathers = d->shader == &shader_lights_gather_comp, reaches = gathers && d->in_view.reaches.id;
    struct gpu_compute_params params = {.shader = d->shader};
    struct gpu_lights_push push = {.view = d->input.view,
                                   .list = d->header,
                                   .sums = graph_address(context, d->in_view.sums),
                                   .ids = gathers ? graph_address(context, d->in_view.ids) : 0,
                                   .bounds = gathers ? graph_address(context, d->in_view.bounds) : 0,
                                   .reaches = reaches ? graph_address(context, d->in_view.reaches) : 0,
                                   .light_count = d->input.local_count,
                                   .cull = !d->input.keep_unseen,
                                   .reach = reaches};
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_dispatch_linear(context->commands, DIVIDE_UP(d->input.local_count + 1, 64u));
}

struct lights_in_view lights_in_view_add(struct graph *graph, gpu_device *device, const struct light_input *input) {
    static const struct in_view_names {
        const char *mark, *gather, *sums, *ids, *bounds, *reaches;
        struct prefix_sum_names sum;
    } all_names[LIGHT_USE_COUNT] = {
        {"lights mark", "lights gather", "light sums", "lights in view", "light bounds", "light reaches",
         PREFIX_SUM_NAMES("lights")},
        {"decals mark", "decals gather", "decal sums", "decals in view", "decal bounds", "decal reaches",
         PREFIX_SUM_NAMES("decals")},
        {"fallback mark", "fallback gather", "fallback sums", "fallback in view", "fallback bounds", "fallback reaches",
         PREFIX_SUM_NAMES("fallback")},
    };
    const struct in_view_names *names = &all_names[input->use];
    uint64_t count = MAX(input->local_count, 1u);
    struct view_data data = {.input = *input, .shader = &shader_lights_mark_comp};
    data.in_view.sums = graph_create_buffer(graph, names->sums, (input->local_count + 1) * 4ull);
    data.in_view.ids = graph_create_buffer(graph, names->ids, count * 4);
    data.in_view.bounds = graph_create_buffer(graph, names->bounds, count * sizeof(struct gpu_bound));
    if (!input->spheres_only)
        data.in_view.reaches = graph_create_buffer(graph, names->reaches, count * sizeof(struct gpu_reach));
    light_list_header(device, input, &data.header);
    struct graph_pass *pass = graph_add_pass(graph, names->mark, input->queue, execute_lights, &data, sizeof data);
    graph_use_buffer(pass, input->buffer, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data.in_view.sums, GRAPH_WRITE_COMPUTE);
    prefix_sum_add(graph, &names->sum, input->queue, data.in_view.sums, input->local_count + 1);
    data.shader = &shader_lights_gather_comp;
    pass = graph_add_pass(graph, names->gather, input->queue, execute_lights, &data, sizeof data);
    graph_use_buffer(pass, input->buffer, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data.in_view.sums, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data.in_view.ids, GRAPH_WRITE_COMPUTE);
    graph_use_buffer(pass, data.in_view.bounds, GRAPH_WRITE_COMPUTE);
    if (!input->spheres_only) graph_use_buffer(pass, data.in_view.reaches, GRAPH_WRITE_COMPUTE);
    return data.in_view;
}

/* ---- counts of the frame ---- */

struct totals_data {
    graph_buffer sums, overflow, lights, totals;
    uint64_t sums_offset, lights_offset;
};

static void execute_totals(const struct graph_context *context, const void *data) {
    const struct totals_data *d = data;
    const struct gpu_buffer *totals = graph_get_buffer(context, d->totals);
    gpu_copy_buffer(context->commands, graph_get_buffer(context, d->lights), d->lights_offset, totals,
                    offsetof(struct light_totals, in_view), 4);
    gpu_copy_buffer(context->commands, graph_get_buffer(context, d->sums), d->sums_offset, totals,
                    offsetof(struct light_totals, entries), 4);
    gpu_copy_buffer(context->commands, graph_get_buffer(context, d->overflow), 0, totals,
                    offsetof(struct light_totals, overflow_cells), 4);
}

graph_buffer light_totals_add(struct graph *graph, const char *pass_name, const char *buffer_name,
                              const struct light_input *input, const struct lights_in_view *in_view, graph_buffer sums,
                              uint32_t sum_count, graph_buffer overflow) {
    struct totals_data totals = {.sums = sums,
                                 .overflow = overflow,
                                 .lights = in_view->sums,
                                 .totals = graph_create_buffer(graph, buffer_name, sizeof(struct light_totals)),
                                 .sums_offset = (sum_count - 1) * 4ull,
                                 .lights_offset = input->local_count * 4ull};
    struct graph_pass *pass = graph_add_pass(graph, pass_name, input->queue, execute_totals, &totals, sizeof totals);
    graph_use_buffer(pass, totals.sums, GRAPH_COPY_FROM);
    graph_use_buffer(pass, totals.overflow, GRAPH_COPY_FROM);
    graph_use_buffer(pass, totals.lights, GRAPH_COPY_FROM);
    graph_use_buffer(pass, totals.totals, GRAPH_COPY_TO);
    return totals.totals;
}
