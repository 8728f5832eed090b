/* SPDX-License-Identifier: MIT */
#include "passes/lights/light_list.h"

#include "passes/geometry/prefix_sum.h"
#include "passes/lights/cells_shared.h"
#include "shaders.h"

void light_list_use(struct graph_pass *pass, const struct light_list *list, enum graph_use use) {
    graph_use_buffer(pass, list->lights, use);
    if (list->cells.id) graph_use_buffer(pass, list->cells, use);
    if (list->ids.id) graph_use_buffer(pass, list->ids, use);
    if (list->extra.id) graph_use_buffer(pass, list->extra, use);
    if (list->bounds.id) graph_use_buffer(pass, list->bounds, use);
    if (list->spare.id) graph_use_buffer(pass, list->spare, use);
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
                                                                       .lights = input->lights,
                                                                       .planes = input->planes,
                                                                       .view = input->view};
    return slice.data;
}

struct light_list light_list_all_add(struct graph *graph, gpu_device *device, const struct light_input *input) {
    UNUSED(graph);
    struct light_list list = {
        .kind = GPU_LIST_ALL, .lights = input->buffer, .totals_known = true, .known = {.in_view = input->local_count - input->unlit_count}};
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
    uint64_t count = MAX(input->local_count, 1u);
    struct view_data data = {.input = *input, .shader = &shader_lights_mark_comp};
    data.in_view.sums = graph_create_buffer(graph, "light sums", (input->local_count + 1) * 4ull);
    data.in_view.ids = graph_create_buffer(graph, "lights in view", count * 4);
    data.in_view.bounds = graph_create_buffer(graph, "light bounds", count * sizeof(struct gpu_bound));
    if (!input->spheres_only)
        data.in_view.reaches = graph_create_buffer(graph, "light reaches", count * sizeof(struct gpu_reach));
    light_list_header(device, input, &data.header);
    struct graph_pass *pass = graph_add_pass(graph, "lights mark", input->queue, execute_lights, &data, sizeof data);
    graph_use_buffer(pass, input->buffer, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data.in_view.sums, GRAPH_WRITE_COMPUTE);
    prefix_sum_add(graph, "lights", input->queue, data.in_view.sums, input->local_count + 1);
    data.shader = &shader_lights_gather_comp;
    pass = graph_add_pass(graph, "lights gather", input->queue, execute_lights, &data, sizeof data);
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

graph_buffer light_totals_add(struct graph *graph, const char *what, const struct light_input *input,
                              const struct lights_in_view *in_view, graph_buffer sums, uint32_t sum_count,
                              graph_buffer overflow) {
    struct totals_data totals = {.sums = sums,
                                 .overflow = overflow,
                                 .lights = in_view->sums,
                                 .totals = graph_create_buffer(graph, graph_name(graph, "%s list totals", what),
                                                               sizeof(struct light_totals)),
                                 .sums_offset = (sum_count - 1) * 4ull,
                                 .lights_offset = input->local_count * 4ull};
    struct graph_pass *pass = graph_add_pass(graph, graph_name(graph, "%s totals", what), input->queue, execute_totals,
                                             &totals, sizeof totals);
    graph_use_buffer(pass, totals.sums, GRAPH_COPY_FROM);
    graph_use_buffer(pass, totals.overflow, GRAPH_COPY_FROM);
    graph_use_buffer(pass, totals.lights, GRAPH_COPY_FROM);
    graph_use_buffer(pass, totals.totals, GRAPH_COPY_TO);
    return totals.totals;
}

/* ---- the spare list ---- */

enum { SPARE_HEADERS = 4, SPARE_GROUPS = 2048 };

struct spare_data {
    struct light_input input;
    struct lights_in_view in_view;
    graph_buffer overflow, spare;
    struct gpu_light_list *headers[SPARE_HEADERS];
    VkDeviceAddress address;
    uint32_t header_count;
    bool always;
};

static void execute_spare(const struct graph_context *context, const void *data) {
    const struct spare_data *d = data;
    struct gpu_compute_params params = {.shader = &shader_light_spare_comp};
    struct gpu_spare_push push = {.view = d->input.view,
                                  .list = d->address,
                                  .visible_sums = graph_address(context, d->in_view.sums),
                                  .bounds = graph_address(context, d->in_view.bounds),
                                  .overflow = graph_address(context, d->overflow),
                                  .spare = graph_address(context, d->spare),
                                  .light_count = d->input.local_count,
                                  .always = d->always};
    for (uint32_t i = 0; i < d->header_count; i++)
        if (d->headers[i]) d->headers[i]->spare = push.spare;
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_dispatch_linear(context->commands, MIN(DIVIDE_UP(d->input.local_count, 32u), (uint32_t)SPARE_GROUPS));
}

graph_buffer light_spare_add(struct graph *graph, const char *what, const struct light_input *input,
                             const struct lights_in_view *in_view, graph_buffer overflow,
                             struct gpu_light_list *const headers[], const VkDeviceAddress addresses[], uint32_t header_count,
                             bool always) {
    if (input->local_count == 0) return (graph_buffer){0};
    struct spare_data data = {.input = *input,
                              .in_view = *in_view,
                              .overflow = overflow,
                              .address = addresses[0],
                              .header_count = header_count,
                              .always = always};
    uint32_t words = DIVIDE_UP(input->local_count, 32u), size = 16;
    while (DIVIDE_UP(input->width, size) * DIVIDE_UP(input->height, size) > SPARE_ROWS - SPARE_BINS) size += 16;
    for (uint32_t i = 0; i < header_count; i++) {
        data.headers[i] = headers[i];
        if (!headers[i]) continue;
        headers[i]->spare_words = words;
        headers[i]->spare_tile_size = size;
        headers[i]->spare_tiles = (uvec2){DIVIDE_UP(input->width, size), DIVIDE_UP(input->height, size)};
    }
    data.spare = graph_create_buffer(graph, graph_name(graph, "%s spare list", what), (1 + (uint64_t)SPARE_ROWS * words) * 4);
    struct graph_pass *pass =
        graph_add_pass(graph, graph_name(graph, "%s spare", what), input->queue, execute_spare, &data, sizeof data);
    graph_use_buffer(pass, in_view->sums, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, in_view->bounds, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, overflow, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data.spare, GRAPH_WRITE_COMPUTE);
    return data.spare;
}
