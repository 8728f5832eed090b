/* SPDX-License-Identifier: MIT */
#include "passes/lights/cells_shared.h"
#include "passes/lights/clustered.h"
#include "passes/lights/zbin_shared.h"

#include "passes/geometry/prefix_sum.h"
#include "shaders.h"

enum { HEAD_WORDS = 4, TABLE_MAX_RECORDS = 1 << 23, TILE_MAX = 1024 };
enum step { STEP_CLEAR, STEP_MARK, STEP_COUNT, STEP_PLACE, STEP_FILL };

struct zbin_params zbin_params_default(void) {
    return (struct zbin_params){.tile_size = 16, .bins = 128, .near = 0.5f, .far = 100, .pool_capacity = 1u << 20};
}

struct step_data {
    struct light_input input;
    struct lights_in_view in_view;
    struct gpu_light_list *header;
    VkDeviceAddress header_address;
    graph_buffer table, sums, pool, overflow;
    uint32_t cell_count, table_words, capacity;
    enum step step;
};

static void execute_step(const struct graph_context *context, const void *data) {
    const struct step_data *d = data;
    static const struct gpu_shader *const shaders[] = {&shader_zbin_clear_comp, &shader_zbin_scatter_comp,
                                                       &shader_zbin_count_comp, &shader_zbin_place_comp,
                                                       &shader_zbin_scatter_comp};
    uint32_t words = DIVIDE_UP(d->input.local_count, 32u);
    const uint32_t groups[] = {DIVIDE_UP(DIVIDE_UP(d->table_words, 4u), 64u), words, d->cell_count / 64 + 1, d->cell_count,
                               words};
    bool scatters = d->step == STEP_MARK || d->step == STEP_FILL, pools = d->step >= STEP_PLACE;
    struct gpu_zbin_push push = {
        .view = d->input.view,
        .list = d->header_address,
        .visible_sums = graph_address(context, d->in_view.sums),
        .bounds = scatters ? graph_address(context, d->in_view.bounds) : 0,
        .table = graph_address(context, d->table),
        .sums = d->step == STEP_COUNT || d->step == STEP_PLACE ? graph_address(context, d->sums) : 0,
        .pool = pools ? graph_address(context, d->pool) : 0,
        .overflow = d->step == STEP_COUNT || d->step == STEP_PLACE ? graph_address(context, d->overflow) : 0,
        .light_count = d->input.local_count,
        .cell_count = d->cell_count,
        .capacity = d->capacity};
    if (d->step == STEP_FILL && d->header) {
        d->header->cells = push.table;
        d->header->ids = push.pool;
        d->header->extra = graph_address(context, d->in_view.ids);
    }
    if (!groups[d->step]) return;
    struct gpu_compute_params params = {
        .shader = shaders[d->step], .constant_count = 2, .constants = {GPU_LIST_ALL, d->step == STEP_FILL}};
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    gpu_dispatch_linear(context->commands, groups[d->step]);
}

static struct graph_pass *add_step(struct graph *graph, const char *name, struct step_data *data, enum step step) {
    data->step = step;
    struct graph_pass *pass = graph_add_pass(graph, name, data->input.queue, execute_step, data, sizeof *data);
    graph_use_buffer(pass, data->in_view.sums, GRAPH_READ_COMPUTE);
    return pass;
}

/* The table has a record for each cell and 1024 lights, whether they touch or not: tiles grow before it does. */
static uint32_t tile_size_of(const struct light_input *input, const struct zbin_params *params, uint64_t group_count) {
    uint32_t size = params->tile_size;
    while (size < TILE_MAX &&
           (uint64_t)DIVIDE_UP(input->width, size) * DIVIDE_UP(input->height, size) * group_count > TABLE_MAX_RECORDS)
        size *= 2;
    return size;
}

struct light_list zbin_add(struct graph *graph, gpu_device *device, const struct light_input *input,
                           const struct lights_in_view *in_view, const struct zbin_params *params) {
    struct step_data data = {.input = *input, .in_view = *in_view, .cell_count = 1, .capacity = params->pool_capacity};
    uint64_t group_count = DIVIDE_UP(input->local_count, ZBIN_GROUP);
    data.header = light_list_header(device, input, &data.header_address);
    if (data.header) {
        clustered_grid(data.header, input->width, input->height,
                       &(struct clustered_params){.tile_size = tile_size_of(input, params, group_count),
                                                  .slices = params->bins,
                                                  .near = params->near,
                                                  .far = params->far,
                                                  .linear = params->linear});
        data.cell_count = data.header->tiles_x * data.header->tiles_y + data.header->slices;
    }
    data.table_words =
        (uint32_t)(HEAD_WORDS + data.cell_count * (DIVIDE_UP(group_count, 32u) + 1) + data.cell_count * group_count * 2);
    data.table = graph_create_buffer(graph, "zbin table", data.table_words * 4ull);
    data.sums = graph_create_buffer(graph, "zbin sums", (data.cell_count + 1) * 4ull);
    data.pool = graph_create_buffer(graph, "zbin words", MAX(params->pool_capacity, 1u) * 4ull);
    data.overflow = graph_create_buffer(graph, "zbin overflow", 4);

    struct graph_pass *pass = add_step(graph, "zbin clear", &data, STEP_CLEAR);
    graph_use_buffer(pass, data.table, GRAPH_WRITE_COMPUTE);
    pass = add_step(graph, "zbin mark", &data, STEP_MARK);
    graph_use_buffer(pass, in_view->bounds, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data.table, GRAPH_READ_WRITE_COMPUTE);
    pass = add_step(graph, "zbin count", &data, STEP_COUNT);
    graph_use_buffer(pass, data.table, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data.sums, GRAPH_WRITE_COMPUTE);
    graph_use_buffer(pass, data.overflow, GRAPH_WRITE_COMPUTE);
    prefix_sum_add(graph, "zbin", input->queue, data.sums, data.cell_count + 1);
    pass = add_step(graph, "zbin place", &data, STEP_PLACE);
    graph_use_buffer(pass, data.table, GRAPH_READ_WRITE_COMPUTE);
    graph_use_buffer(pass, data.sums, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data.overflow, GRAPH_READ_WRITE_COMPUTE);
    graph_use_buffer(pass, data.pool, GRAPH_WRITE_COMPUTE);
    pass = add_step(graph, "zbin fill", &data, STEP_FILL);
    graph_use_buffer(pass, in_view->bounds, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, in_view->ids, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data.table, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data.pool, GRAPH_READ_WRITE_COMPUTE);

    return (struct light_list){.kind = GPU_LIST_BINS,
                               .lights = input->buffer,
                               .header = data.header_address,
                               .cells = data.table,
                               .ids = data.pool,
                               .extra = in_view->ids,
                               .spare = light_spare_add(graph, "zbin", input, in_view,
                                                        data.overflow, &data.header, &data.header_address, 1, false),
                               .cell_count = data.cell_count,
                               .byte_count = data.table_words * 4ull + params->pool_capacity * 4ull,
                               .fixed_bytes = data.table_words * 4ull,
                               .entry_bytes = 4,
                               .totals = light_totals_add(graph, "zbin", input, in_view,
                                                          data.sums, data.cell_count + 1, data.overflow)};
}
