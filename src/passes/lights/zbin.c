/* SPDX-License-Identifier: MIT */
#include "passes/lights/cells_shared.h"
#include "passes/lights/clustered.h"
#include "passes/lights/zbin_shared.h"

#include "passes/geometry/prefix_sum.h"
#include "shaders.h"

enum { HEAD_WORDS = 4, TABLE_MAX_RECORDS = 1 << 23, TILE_MAX = 1024 };
/* Zones: one for each so many lights, up to ZONES, while tiles have no more records than this. */
enum { ZONE_LIGHTS = 4096, ZONES = 16, ZONE_MAX_RECORDS = 1 << 21 };

struct zbin_params zbin_params_default(void) {
    return (struct zbin_params){.tile_size = 16, .bins = 128, .near = 0.5f, .far = 100, .pool_capacity = 1u << 20};
}

/* The table has a record for each cell and 1024 lights, whether they touch or not: tiles grow before it does. */
static uint32_t tile_size_of(const struct light_input *input, const struct zbin_params *params, uint64_t group_count) {
    uint32_t size = params->tile_size;
    while (size < TILE_MAX &&
           (uint64_t)DIVIDE_UP(input->width, size) * DIVIDE_UP(input->height, size) * group_count > TABLE_MAX_RECORDS)
        size *= 2;
    return size;
}

uint32_t zbin_zones(const struct light_input *input, const struct zbin_params *params) {
    const uint64_t group_count = DIVIDE_UP(input->set.local_count, ZBIN_GROUP);
    const uint32_t size = tile_size_of(input, params, group_count);
    const uint64_t records = (uint64_t)DIVIDE_UP(input->width, size) * DIVIDE_UP(input->height, size) * group_count;
    uint32_t zones = CLAMP(input->set.local_count / ZONE_LIGHTS, 1u, MIN((uint32_t)ZONES, params->bins));
    while (zones > 1 && records * zones > ZONE_MAX_RECORDS) zones /= 2;
    return zones;
}

struct light_list zbin_add(struct graph *graph, gpu_device *device, const struct light_input *input,
                           const struct lights_in_view *in_view, const struct zbin_params *params) {
    uint64_t group_count = DIVIDE_UP(input->set.local_count, ZBIN_GROUP);
    VkDeviceAddress address;
    struct gpu_light_list *header = light_list_header(device, input, &address);
    uint32_t cell_count = 1;
    if (header) {
        clustered_grid(header, input->width, input->height,
                       &(struct clustered_params){.tile_size = tile_size_of(input, params, group_count),
                                                  .slices = params->bins,
                                                  .near = params->near,
                                                  .far = params->far,
                                                  .linear = params->linear});
        header->zone_slices = DIVIDE_UP(header->slices, zbin_zones(input, params));
        cell_count = header->tiles_x * header->tiles_y * DIVIDE_UP(header->slices, header->zone_slices) + header->slices;
    }
    const uint32_t table_words =
        (uint32_t)(HEAD_WORDS + cell_count * (DIVIDE_UP(group_count, 32u) + 1) + cell_count * group_count * 2);
    graph_buffer table = graph_create_buffer(graph, "zbin table", table_words * 4ull);
    graph_buffer sums = graph_create_buffer(graph, "zbin sums", (cell_count + 1) * 4ull);
    graph_buffer pool = graph_create_buffer(graph, "zbin words", MAX(params->pool_capacity, 1u) * 4ull);
    graph_buffer overflow = graph_create_buffer(graph, "zbin overflow", 4);
    if (header) {
        graph_put_address(graph, &header->cells, table);
        graph_put_address(graph, &header->ids, pool);
        graph_put_address(graph, &header->extra, in_view->ids);
    }

    const uint32_t light_words = DIVIDE_UP(input->set.local_count, 32u);
    const struct gpu_zbin_push common = {.view = input->view,
                                         .list = address,
                                         .light_count = input->set.local_count,
                                         .cell_count = cell_count,
                                         .capacity = params->pool_capacity};
    struct gpu_zbin_push push = common;
#define ADD_STEP(name_, shader_, fills_, groups_, ...)                                                                      \
    push = common;                                                                                                          \
    graph_dispatch(graph,                                                                                                   \
                   &(struct graph_dispatch){.name = name_,                                                                  \
                                            .queue = input->queue,                                                          \
                                            .pipeline = {&shader_, 2, {GPU_LIST_ALL, fills_}},                              \
                                            .groups = {groups_},                                                            \
                                            GRAPH_PUSH(push),                                                               \
                                            GRAPH_ROWS(graph_reads(&push.visible_sums, in_view->sums), __VA_ARGS__)})
    ADD_STEP("zbin clear", shader_zbin_clear_comp, 0, DIVIDE_UP(DIVIDE_UP(table_words, 4u), 64u),
             graph_writes(&push.table, table));
    ADD_STEP("zbin mark", shader_zbin_scatter_comp, 0, light_words, graph_reads(&push.bounds, in_view->bounds),
             graph_changes(&push.table, table));
    ADD_STEP("zbin count", shader_zbin_count_comp, 0, cell_count / 64 + 1, graph_reads(&push.table, table),
             graph_writes(&push.sums, sums), graph_writes(&push.overflow, overflow));
    prefix_sum_add(graph, "zbin", input->queue, sums, cell_count + 1);
    ADD_STEP("zbin place", shader_zbin_place_comp, 0, DIVIDE_UP(cell_count, 64u), graph_changes(&push.table, table),
             graph_reads(&push.sums, sums), graph_changes(&push.overflow, overflow), graph_writes(&push.pool, pool));
    ADD_STEP("zbin fill", shader_zbin_scatter_comp, 1, light_words, graph_reads(&push.bounds, in_view->bounds),
             graph_reads(NULL, in_view->ids), graph_reads(&push.table, table), graph_changes(&push.pool, pool));

    return (struct light_list){.kind = GPU_LIST_BINS,
                               .lights = input->set.buffer,
                               .header = address,
                               .cells = table,
                               .ids = pool,
                               .extra = in_view->ids,
                               .spare =
                                   light_spare_add(graph, "zbin", input, in_view, overflow, &header, &address, 1, false),
                               .cell_count = cell_count,
                               .byte_count = table_words * 4ull + params->pool_capacity * 4ull,
                               .fixed_bytes = table_words * 4ull,
                               .entry_bytes = 4,
                               .totals = light_totals_add(graph, "zbin", input, in_view, sums, cell_count + 1, overflow)};
}
