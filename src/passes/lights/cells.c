/* SPDX-License-Identifier: MIT */
#include "passes/lights/cells.h"

#include "passes/geometry/prefix_sum.h"
#include "shaders.h"

enum { MAX_SUMS = 1 << 24, MAX_CHUNKS = 65535 };
enum { MAX_TESTS = 1 << 26 }; /* of lights against cells in a dispatch: a fraction of a second on a slow device */
enum step { STEP_BOUNDS, STEP_COUNT, STEP_FILL };

struct step_data {
    struct light_input input;
    struct lights_in_view in_view;
    struct cells_build build;
    graph_buffer bounds, sums, cells, ids, overflow, extra;
    uint32_t cell_count, chunk_size, chunk_count;
    enum step step;
};

static void execute_step(const struct graph_context *context, const void *data) {
    const struct step_data *d = data;
    struct gpu_cells_push push = {.view = d->input.view,
                                  .list = d->build.header_address,
                                  .cells = graph_address(context, d->bounds),
                                  .light_count = d->input.local_count,
                                  .cell_count = d->cell_count,
                                  .chunk_size = d->chunk_size,
                                  .chunk_count = d->chunk_count,
                                  .capacity = d->build.pool_capacity,
                                  .flags = d->build.flags,
                                  .depth = GPU_NO_DEPTH,
                                  .front = GPU_NO_DEPTH};
    if (d->extra.id && (d->step == STEP_FILL || !(d->build.flags & CELLS_RANGES)))
        push.extra = graph_address(context, d->extra);
    if (d->step == STEP_BOUNDS) {
        struct gpu_compute_params params = {
            .shader = d->build.bounds_shader, .constant_count = 2, .constants = {GPU_LIST_ALL, d->build.bounds_samples}};
        if (d->build.depth.id) push.depth = graph_sampled(context, d->build.depth);
        if (d->build.front.id) push.front = graph_sampled(context, d->build.front);
        gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
        gpu_push(context->commands, &push, sizeof push);
        if (d->build.bounds_groups_y)
            gpu_dispatch(context->commands, d->build.bounds_groups_x, d->build.bounds_groups_y, 1);
        else
            gpu_dispatch_linear(context->commands, d->build.bounds_groups_x);
        return;
    }
    const struct gpu_shader *fill = d->build.refine.add ? d->build.refine.fill_shader : &shader_cells_fill_comp;
    struct gpu_compute_params params = {.shader = d->step == STEP_COUNT ? &shader_cells_count_comp : fill};
    if (d->build.refine.add) push.extra = d->build.refine.address;
    push.visible_sums = graph_address(context, d->in_view.sums);
    push.bounds = graph_address(context, d->in_view.bounds);
    if (cells_use_reaches(d->build.flags)) push.reaches = graph_address(context, d->in_view.reaches);
    push.sums = graph_address(context, d->sums);
    push.overflow = graph_address(context, d->overflow);
    if (d->step == STEP_FILL) {
        push.visible_ids = graph_address(context, d->in_view.ids);
        push.ids = graph_address(context, d->ids);
        if (d->build.header) {
            d->build.header->cells = graph_address(context, d->cells);
            d->build.header->ids = push.ids;
            if (d->input.scattered) d->build.header->bounds = graph_address(context, d->bounds);
            if (d->extra.id) d->build.header->extra = push.extra;
        }
    }
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    /* Systems reset a device that stays with one piece of work for seconds. */
    uint32_t groups = DIVIDE_UP(d->cell_count + 1, 64u);
    uint32_t cells = 64 * (uint32_t)CLAMP(MAX_TESTS / (64ull * d->chunk_size), 1u, (uint64_t)groups);
    uint32_t chunks = (uint32_t)MAX(MAX_TESTS / ((uint64_t)cells * d->chunk_size), 1u);
    for (push.first_cell = 0; push.first_cell <= d->cell_count; push.first_cell += cells)
        for (push.first_chunk = 0; push.first_chunk < d->chunk_count; push.first_chunk += chunks) {
            gpu_push(context->commands, &push, sizeof push);
            gpu_dispatch(context->commands, MIN(cells / 64, groups - push.first_cell / 64),
                         MIN(chunks, d->chunk_count - push.first_chunk), 1);
        }
}

struct light_list cells_add(struct graph *graph, const struct light_input *input, const struct lights_in_view *in_view,
                            const struct cells_build *build) {
    const char *what = build->what;
    struct step_data data = {.input = *input, .in_view = *in_view, .build = *build};
    /* Without memory for the header the device already carries a sticky error; the grid only has to be valid. */
    data.cell_count = build->header ? build->header->tiles_x * build->header->tiles_y * build->header->slices : 1;
    /* Chunks keep a big device busy; there need not be more than a few million of them. */
    data.chunk_size = CELL_CHUNK;
    for (uint32_t chunks; (chunks = DIVIDE_UP(input->local_count, data.chunk_size)) > MAX_CHUNKS ||
                          (chunks > 1 && (uint64_t)data.cell_count * chunks > MAX_SUMS);)
        data.chunk_size *= 2;
    data.chunk_count = MAX(DIVIDE_UP(input->local_count, data.chunk_size), 1u);
    uint32_t sum_count = data.cell_count * data.chunk_count + 1;
    data.bounds = graph_create_buffer(graph, graph_name(graph, "%s cell bounds", what), data.cell_count * sizeof(struct gpu_cell_bounds));
    data.sums = graph_create_buffer(graph, graph_name(graph, "%s sums", what), sum_count * 4ull);
    data.cells = graph_create_buffer(graph, graph_name(graph, "%s cells", what), data.cell_count * sizeof(struct gpu_cell));
    data.ids = graph_create_buffer(graph, graph_name(graph, "%s ids", what), MAX(build->pool_capacity, 1u) * 4ull);
    data.overflow = graph_create_buffer(graph, graph_name(graph, "%s overflow", what), 4);
    if (build->extra_bytes) data.extra = graph_create_buffer(graph, graph_name(graph, "%s extra", what), build->extra_bytes);
    bool ranges = build->flags & CELLS_RANGES; /* then fill writes what is extra, else the bounds do */

    struct graph_pass *pass = graph_add_pass(graph, graph_name(graph, "%s bounds", what), input->queue, execute_step, &data, sizeof data);
    if (build->depth.id) graph_use_image(pass, build->depth, GRAPH_SAMPLE_COMPUTE);
    if (build->front.id) graph_use_image(pass, build->front, GRAPH_SAMPLE_COMPUTE);
    if (build->bounds_input.id) graph_use_buffer(pass, build->bounds_input, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data.bounds, GRAPH_WRITE_COMPUTE);
    if (data.extra.id && !ranges) graph_use_buffer(pass, data.extra, GRAPH_WRITE_COMPUTE);

    data.step = STEP_COUNT;
    pass = graph_add_pass(graph, graph_name(graph, "%s count", what), input->queue, execute_step, &data, sizeof data);
    graph_use_buffer(pass, data.bounds, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, in_view->sums, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, in_view->bounds, GRAPH_READ_COMPUTE);
    if (cells_use_reaches(build->flags)) graph_use_buffer(pass, in_view->reaches, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data.sums, GRAPH_WRITE_COMPUTE);
    graph_use_buffer(pass, data.overflow, GRAPH_WRITE_COMPUTE);
    if (data.extra.id && !ranges) graph_use_buffer(pass, data.extra, GRAPH_READ_COMPUTE);

    const struct cells_refine *refine = &build->refine;
    if (refine->add)
        refine->add(graph,
                    &(struct cells_counted){input, in_view, build, data.bounds, data.sums, data.cell_count, data.chunk_size,
                                            data.chunk_count},
                    refine->user);

    prefix_sum_add(graph, what, input->queue, data.sums, sum_count);

    data.step = STEP_FILL;
    pass = graph_add_pass(graph, graph_name(graph, "%s fill", what), input->queue, execute_step, &data, sizeof data);
    graph_use_buffer(pass, data.bounds, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data.sums, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, in_view->sums, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, in_view->ids, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, in_view->bounds, GRAPH_READ_COMPUTE);
    if (cells_use_reaches(build->flags)) graph_use_buffer(pass, in_view->reaches, GRAPH_READ_COMPUTE);
    if (refine->add) {
        graph_use_buffer(pass, input->buffer, GRAPH_READ_COMPUTE);
        graph_use_buffer(pass, refine->cones, GRAPH_READ_COMPUTE);
        if (refine->marks.id) graph_use_buffer(pass, refine->marks, GRAPH_READ_WRITE_COMPUTE);
    }
    graph_use_buffer(pass, data.overflow, GRAPH_READ_WRITE_COMPUTE);
    graph_use_buffer(pass, data.cells, GRAPH_WRITE_COMPUTE);
    graph_use_buffer(pass, data.ids, GRAPH_WRITE_COMPUTE);
    if (data.extra.id) graph_use_buffer(pass, data.extra, ranges ? GRAPH_WRITE_COMPUTE : GRAPH_READ_COMPUTE);

    graph_buffer spare =
        light_spare_add(graph, what, input, in_view, data.overflow, &build->header,
                        &build->header_address, 1, input->scattered && (build->depth.id || build->bounds_input.id));
    uint64_t fixed_bytes = data.cell_count * sizeof(struct gpu_cell) + (ranges ? 0 : build->extra_bytes);
    uint32_t entry_bytes = ranges ? 8 : 4;
    return (struct light_list){.lights = input->buffer,
                               .header = build->header_address,
                               .cells = data.cells,
                               .ids = data.ids,
                               .extra = data.extra,
                               .bounds = input->scattered ? data.bounds : (graph_buffer){0},
                               .spare = spare,
                               .cell_count = data.cell_count,
                               .byte_count = fixed_bytes + (uint64_t)build->pool_capacity * entry_bytes,
                               .fixed_bytes = fixed_bytes,
                               .entry_bytes = entry_bytes,
                               .totals = light_totals_add(graph, what, input, in_view,
                                                          data.sums, sum_count, data.overflow)};
}
