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

struct gpu_light_set light_set_block(const struct light_set *set) {
    return (struct gpu_light_set){.directional_count = set->directional_count,
                                  .local_count = set->local_count,
                                  .lights = set->lights,
                                  .entities = set->entities,
                                  .shapes = set->shapes,
                                  .planes = set->planes,
                                  .masks = set->masks,
                                  .profiles = set->profiles,
                                  .lobes = set->lobes};
}

void light_set_send(gpu_device *device, struct light_set *set) {
    const struct gpu_slice slice = gpu_frame_allocate(device, sizeof(struct gpu_light_set));
    set->address = slice.address;
    if (slice.data) *(struct gpu_light_set *)slice.data = light_set_block(set);
}

struct gpu_light_list *light_list_header(gpu_device *device, const struct light_input *input, VkDeviceAddress *out_address) {
    struct light_set set = input->set;
    const struct gpu_slice slice = gpu_frame_allocate(device, sizeof(struct gpu_light_list));
    *out_address = slice.address;
    if (!set.address) light_set_send(device, &set);
    if (slice.data)
        *(struct gpu_light_list *)slice.data = (struct gpu_light_list){.directional_count = set.directional_count,
                                                                       .local_count = set.local_count,
                                                                       .tile_size = 1,
                                                                       .tiles_x = 1,
                                                                       .tiles_y = 1,
                                                                       .slices = 1,
                                                                       .lights = set.address,
                                                                       .view = input->view};
    return slice.data;
}

struct light_list light_list_all_add(struct graph *graph, gpu_device *device, const struct light_input *input) {
    UNUSED(graph);
    struct light_list list = {.kind = GPU_LIST_ALL,
                              .lights = input->set.buffer,
                              .totals_known = true,
                              .known = {.in_view = input->set.local_count - input->set.unlit_count}};
    light_list_header(device, input, &list.header);
    return list;
}

/* ---- lights in view ---- */

struct lights_in_view lights_in_view_add(struct graph *graph, gpu_device *device, const struct light_input *input) {
    uint64_t count = MAX(input->set.local_count, 1u);
    bool reaches = !input->spheres_only;
    struct lights_in_view in_view = {
        .sums = graph_create_buffer(graph, "light sums", (input->set.local_count + 1) * 4ull),
        .ids = graph_create_buffer(graph, "lights in view", count * 4),
        .bounds = graph_create_buffer(graph, "light bounds", count * sizeof(struct gpu_bound)),
        .reaches =
            reaches ? graph_create_buffer(graph, "light reaches", count * sizeof(struct gpu_reach)) : (graph_buffer){0}};
    struct gpu_lights_push push = {.view = input->view, .light_count = input->set.local_count, .cull = !input->keep_unseen, .kinds = input->kinds};
    const uint32_t groups = DIVIDE_UP(input->set.local_count + 1, 64u);
    light_list_header(device, input, &push.list);
    graph_dispatch(graph, &(struct graph_dispatch){
                              .name = "lights mark",
                              .queue = input->queue,
                              .pipeline = {.shader = &shader_lights_mark_comp},
                              .groups = {groups},
                              GRAPH_PUSH(push),
                              GRAPH_ROWS(graph_reads(NULL, input->set.buffer), graph_writes(&push.sums, in_view.sums))});
    prefix_sum_add(graph, "lights", input->queue, in_view.sums, input->set.local_count + 1);
    push.reach = reaches;
    graph_dispatch(graph, &(struct graph_dispatch){
                              .name = "lights gather",
                              .queue = input->queue,
                              .pipeline = {.shader = &shader_lights_gather_comp},
                              .groups = {groups},
                              GRAPH_PUSH(push),
                              GRAPH_ROWS(graph_reads(NULL, input->set.buffer), graph_reads(&push.sums, in_view.sums),
                                         graph_writes(&push.ids, in_view.ids), graph_writes(&push.bounds, in_view.bounds),
                                         graph_row_if(reaches, graph_writes(&push.reaches, in_view.reaches)))});
    return in_view;
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
    struct totals_data totals = {
        .sums = sums,
        .overflow = overflow,
        .lights = in_view->sums,
        .totals = graph_create_buffer(graph, graph_name(graph, "%s list totals", what), sizeof(struct light_totals)),
        .sums_offset = (sum_count - 1) * 4ull,
        .lights_offset = input->set.local_count * 4ull};
    struct graph_pass *pass =
        graph_add_pass(graph, graph_name(graph, "%s totals", what), input->queue, execute_totals, &totals, sizeof totals);
    graph_use_buffer(pass, totals.sums, GRAPH_COPY_FROM);
    graph_use_buffer(pass, totals.overflow, GRAPH_COPY_FROM);
    graph_use_buffer(pass, totals.lights, GRAPH_COPY_FROM);
    graph_use_buffer(pass, totals.totals, GRAPH_COPY_TO);
    return totals.totals;
}

/* ---- the spare list ---- */

enum { SPARE_GROUPS = 256 };

graph_buffer light_spare_add(struct graph *graph, const char *what, const struct light_input *input,
                             const struct lights_in_view *in_view, graph_buffer overflow,
                             struct gpu_light_list *const headers[], const VkDeviceAddress addresses[],
                             uint32_t header_count, bool always) {
    if (input->set.local_count == 0) return (graph_buffer){0};
    uint32_t words = DIVIDE_UP(input->set.local_count, 32u), size = 16;
    while (DIVIDE_UP(input->width, size) * DIVIDE_UP(input->height, size) > SPARE_ROWS - SPARE_BINS) size += 16;
    graph_buffer spare =
        graph_create_buffer(graph, graph_name(graph, "%s spare list", what), (1 + (uint64_t)SPARE_ROWS * words) * 4);
    for (uint32_t i = 0; i < header_count; i++) {
        if (!headers[i]) continue;
        headers[i]->spare_words = words;
        headers[i]->spare_tile_size = size;
        headers[i]->spare_tiles = (uvec2){DIVIDE_UP(input->width, size), DIVIDE_UP(input->height, size)};
        graph_put_address(graph, &headers[i]->spare, spare);
    }
    struct gpu_spare_push push = {
        .view = input->view, .list = addresses[0], .light_count = input->set.local_count, .always = always};
    graph_dispatch(graph,
                   &(struct graph_dispatch){
                       .name = graph_name(graph, "%s spare", what),
                       .queue = input->queue,
                       .pipeline = {.shader = &shader_light_spare_comp},
                       .groups = {MIN(words, (uint32_t)SPARE_GROUPS)},
                       GRAPH_PUSH(push),
                       GRAPH_ROWS(graph_reads(&push.visible_sums, in_view->sums), graph_reads(&push.bounds, in_view->bounds),
                                  graph_reads(&push.overflow, overflow), graph_writes(&push.spare, spare))});
    return spare;
}
