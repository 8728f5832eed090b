/* SPDX-License-Identifier: MIT */
#include "passes/lights/sparse.h"

#include "passes/lights/clustered.h"
#include "passes/lights/sparse_shared.h"
#include "shaders.h"

enum { BUCKETS = 54, CELLS_LEAST = 4096 };
struct sparse_data {
    const struct light_input *input;
    const struct gbuffer *gbuffer; /* NULL: none */
    graph_image depth;
    graph_buffer table, keys, extents;
    struct gpu_sparse_push push; /* without addresses */
    uint32_t samples;
};

/* Steps that look at each pixel: SPARSE_… */
static void add_pixels(struct graph *graph, const char *name, const struct sparse_data *d, uint32_t step) {
    struct gpu_sparse_push push = d->push;
    struct gpu_compute_params pipeline = {
        .shader = &shader_sparse_mark_comp, .constant_count = 3, .constants = {GPU_LIST_ALL, d->samples, step}};
    if (d->gbuffer) {
        push.gbuffer = gbuffer_block(d->gbuffer);
        gbuffer_specialise(d->gbuffer, pipeline.constants, &pipeline.constant_count);
    }
    struct graph_pass *pass = graph_dispatch(
        graph, &(struct graph_dispatch){
                   .name = name,
                   .queue = d->input->queue,
                   .pipeline = pipeline,
                   .groups = {DIVIDE_UP(d->input->width, 8u), DIVIDE_UP(d->input->height, 8u)},
                   GRAPH_PUSH(push),
                   GRAPH_ROWS(graph_samples(&push.gbuffer.depth, d->depth),
                              graph_buffer_row(&push.table, d->table,
                                               step == SPARSE_MARK ? GRAPH_READ_WRITE_COMPUTE : GRAPH_READ_COMPUTE),
                              graph_row_if(step != SPARSE_MARK, graph_changes(&push.extents, d->extents)))});
    if (d->gbuffer) gbuffer_add_normal_rows(pass, &push.gbuffer, d->gbuffer, GRAPH_SAMPLE_COMPUTE);
}

struct sparse_lists sparse_add(struct graph *graph, gpu_device *device, const struct light_input *input,
                               const struct lights_in_view *in_view, const struct sparse_params *params) {
    struct sparse_lists lists = {0};
    struct sparse_data data = {.input = input,
                               .gbuffer = params->gbuffer,
                               .depth = params->depth,
                               .samples = MAX(graph_image_info(graph, params->depth).samples, 1u)};
    const uint32_t buckets = params->gbuffer ? BUCKETS : 1;
    uint32_t key_count = 1;
    VkDeviceAddress header_address;
    struct gpu_light_list *header = light_list_header(device, input, &header_address);
    if (header) {
        clustered_grid(header, input->width, input->height, &params->grid);
        key_count = header->tiles_x * header->tiles_y * header->slices * buckets;
    }
    /* Hardly more cells than pixels: only those at borders have several. */
    uint64_t pixels = MAX((uint64_t)input->width * input->height * data.samples, (uint64_t)CELLS_LEAST);
    const uint32_t cell_limit = (uint32_t)MIN((uint64_t)key_count, pixels);
    data.table = graph_create_buffer(graph, "sparse table", (key_count + 1) * 4ull);
    data.keys = graph_create_buffer(graph, "sparse keys", cell_limit * 4ull);
    data.extents = graph_create_buffer(graph, "sparse extents", (uint64_t)cell_limit * SPARSE_EXTENTS(buckets) * 4);
    graph_buffer bounds = graph_create_buffer(graph, "sparse bounds", cell_limit * sizeof(struct gpu_cell_bounds)),
                 facings = {0};
    if (params->gbuffer) facings = graph_create_buffer(graph, "sparse facings", cell_limit * sizeof(struct gpu_facing));
    if (header) {
        header->buckets = buckets;
        header->cell_limit = cell_limit;
        graph_put_address(graph, &header->extra, data.table);
    }
    data.push = (struct gpu_sparse_push){.view = input->view,
                                         .list = header_address,
                                         .key_count = key_count,
                                         .buckets = buckets,
                                         .cell_limit = cell_limit,
                                         .gbuffer.depth = GPU_NO_DEPTH};

    graph_add_clear(graph, "sparse clear", input->queue, (struct graph_clear){.buffers = {data.table}});
    add_pixels(graph, "sparse mark", &data, SPARSE_MARK);
    prefix_sum_add(graph, "sparse table", input->queue, data.table, key_count + 1);
    struct gpu_sparse_push push = data.push;
    graph_dispatch(
        graph, &(struct graph_dispatch){.name = "sparse compact",
                                        .queue = input->queue,
                                        .pipeline = {&shader_sparse_compact_comp, 2, {GPU_LIST_ALL, data.samples}},
                                        .groups = {DIVIDE_UP(key_count, 64u)},
                                        GRAPH_PUSH(push),
                                        GRAPH_ROWS(graph_reads(&push.table, data.table), graph_writes(&push.keys, data.keys),
                                                   graph_writes(&push.extents, data.extents))});
    add_pixels(graph, "sparse measure", &data, SPARSE_MEASURE);
    if (facings.id) add_pixels(graph, "sparse face", &data, SPARSE_FACE);
    push = data.push;
    graph_dispatch(graph, &(struct graph_dispatch){
                              .name = "sparse bounds",
                              .queue = input->queue,
                              .pipeline = {&shader_sparse_bounds_comp, 2, {GPU_LIST_ALL, data.samples}},
                              .groups = {DIVIDE_UP(cell_limit, 64u)},
                              GRAPH_PUSH(push),
                              GRAPH_ROWS(graph_reads(&push.table, data.table), graph_reads(&push.keys, data.keys),
                                         graph_reads(&push.extents, data.extents), graph_writes(&push.bounds, bounds),
                                         graph_row_if(facings.id, graph_writes(&push.facings, facings)))});

    struct bvh tree = bvh_tree_add(graph, input, in_view, header_address);
    struct bvh_query query = {.what = "sparse",
                              .bounds = bounds,
                              .cell_count = cell_limit,
                              .cell_counter = data.table,
                              .cell_counter_offset = key_count * 4ull,
                              .facings = facings,
                              .cone_tests = params->grid.cone_tests,
                              .occupied = true,
                              .pool_capacity = params->grid.pool_capacity,
                              .header = header,
                              .header_address = header_address};
    lists.lights = bvh_query_add(graph, device, input, in_view, &tree, &query);
    lists.lights.kind = GPU_LIST_SPARSE;
    lists.lights.extra = data.table;
    lists.lights.byte_count += (key_count + 1) * 4ull;
    lists.lights.fixed_bytes += (key_count + 1) * 4ull;
    if (params->blend) {
        header = light_list_header(device, input, &header_address);
        if (header) clustered_grid(header, input->width, input->height, &params->grid);
        lists.blend =
            bvh_clusters_add(graph, device, input, in_view, &tree, "sparse blend", header, header_address, &params->grid);
    }
    return lists;
}
