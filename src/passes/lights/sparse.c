/* SPDX-License-Identifier: MIT */
#include "passes/lights/sparse.h"

#include "passes/lights/clustered.h"
#include "passes/lights/sparse_shared.h"
#include "shaders.h"

enum { BUCKETS = 54, CELLS_LEAST = 4096 };
enum sparse_step {
    STEP_MARK = SPARSE_MARK,
    STEP_MEASURE = SPARSE_MEASURE,
    STEP_FACE = SPARSE_FACE,
    STEP_COMPACT,
    STEP_BOUNDS
};

struct sparse_data {
    VkDeviceAddress view, header_address;
    struct gpu_light_list *header;
    graph_image depth;
    struct gbuffer gbuffer; /* form and normal, where has_normals */
    bool has_normals;
    graph_buffer table, keys, extents, bounds, facings;
    uint32_t width, height, samples, key_count, buckets, cell_limit;
    enum sparse_step step;
};

static VkDeviceAddress address_or_zero(const struct graph_context *context, graph_buffer buffer) {
    return buffer.id ? graph_address(context, buffer) : 0;
}

static void execute_step(const struct graph_context *context, const void *data) {
    const struct sparse_data *d = data;
    bool by_pixel = d->step <= STEP_FACE;
    struct gpu_compute_params params = {.shader = by_pixel                  ? &shader_sparse_mark_comp
                                                  : d->step == STEP_COMPACT ? &shader_sparse_compact_comp
                                                                            : &shader_sparse_bounds_comp,
                                        .constant_count = by_pixel ? 3 : 2,
                                        .constants = {GPU_LIST_ALL, d->samples, (uint32_t)d->step}};
    struct gpu_sparse_push push = {.view = d->view,
                                   .list = d->header_address,
                                   .table = graph_address(context, d->table),
                                   .keys = by_pixel ? 0 : graph_address(context, d->keys),
                                   .extents = d->step == STEP_MARK ? 0 : graph_address(context, d->extents),
                                   .key_count = d->key_count,
                                   .buckets = d->buckets,
                                   .cell_limit = d->cell_limit,
                                   .gbuffer.depth = by_pixel ? graph_sampled(context, d->depth) : GPU_NO_DEPTH};
    if (by_pixel && d->has_normals) {
        push.gbuffer = gbuffer_normal_handles(context, &d->gbuffer);
        gbuffer_specialise(&d->gbuffer, params.constants, &params.constant_count);
    }
    if (d->step == STEP_BOUNDS) {
        push.bounds = graph_address(context, d->bounds);
        push.facings = address_or_zero(context, d->facings);
        if (d->header) d->header->extra = push.table;
    }
    gpu_bind(context->commands, gpu_compute_pipeline(context->device, &params));
    gpu_push(context->commands, &push, sizeof push);
    if (by_pixel)
        gpu_dispatch(context->commands, DIVIDE_UP(d->width, 8u), DIVIDE_UP(d->height, 8u), 1);
    else
        gpu_dispatch_linear(context->commands, DIVIDE_UP(d->step == STEP_COMPACT ? d->key_count : d->cell_limit, 64u));
}

static struct graph_pass *add_step(struct graph *graph, const char *name, enum graph_queue queue, struct sparse_data *data,
                                   enum sparse_step step) {
    data->step = step;
    struct graph_pass *pass = graph_add_pass(graph, name, queue, execute_step, data, sizeof *data);
    graph_use_buffer(pass, data->table, step == STEP_MARK ? GRAPH_READ_WRITE_COMPUTE : GRAPH_READ_COMPUTE);
    if (step <= STEP_FACE) {
        graph_use_image(pass, data->depth, GRAPH_SAMPLE_COMPUTE);
        if (data->has_normals) gbuffer_use_normal(pass, &data->gbuffer, GRAPH_SAMPLE_COMPUTE);
    }
    return pass;
}

struct sparse_lists sparse_add(struct graph *graph, gpu_device *device, const struct light_input *input,
                               const struct lights_in_view *in_view, const struct sparse_params *params) {
    struct sparse_lists lists = {0};
    struct sparse_data data = {.view = input->view,
                               .depth = params->depth,
                               .has_normals = params->gbuffer != NULL,
                               .width = input->width,
                               .height = input->height,
                               .samples = MAX(graph_image_info(graph, params->depth).samples, 1u),
                               .buckets = params->gbuffer ? BUCKETS : 1,
                               .key_count = 1};
    if (params->gbuffer) data.gbuffer = *params->gbuffer;
    data.header = light_list_header(device, input, &data.header_address);
    if (data.header) {
        clustered_grid(data.header, input->width, input->height, &params->grid);
        data.key_count = data.header->tiles_x * data.header->tiles_y * data.header->slices * data.buckets;
    }
    /* Hardly more cells than pixels: only those at borders have several. */
    uint64_t pixels = MAX((uint64_t)input->width * input->height * data.samples, (uint64_t)CELLS_LEAST);
    data.cell_limit = (uint32_t)MIN((uint64_t)data.key_count, pixels);
    if (data.header) {
        data.header->buckets = data.buckets;
        data.header->cell_limit = data.cell_limit;
    }
    data.table = graph_create_buffer(graph, "sparse table", (data.key_count + 1) * 4ull);
    data.keys = graph_create_buffer(graph, "sparse keys", data.cell_limit * 4ull);
    data.extents =
        graph_create_buffer(graph, "sparse extents", (uint64_t)data.cell_limit * SPARSE_EXTENTS(data.buckets) * 4);
    data.bounds = graph_create_buffer(graph, "sparse bounds", data.cell_limit * sizeof(struct gpu_cell_bounds));
    if (data.has_normals)
        data.facings = graph_create_buffer(graph, "sparse facings", data.cell_limit * sizeof(struct gpu_facing));

    graph_add_clear(graph, "sparse clear", input->queue, (struct graph_clear){.buffers = {data.table}});
    add_step(graph, "sparse mark", input->queue, &data, STEP_MARK);
    prefix_sum_add(graph, "sparse table", input->queue, data.table, data.key_count + 1);
    struct graph_pass *pass = add_step(graph, "sparse compact", input->queue, &data, STEP_COMPACT);
    graph_use_buffer(pass, data.keys, GRAPH_WRITE_COMPUTE);
    graph_use_buffer(pass, data.extents, GRAPH_WRITE_COMPUTE);
    pass = add_step(graph, "sparse measure", input->queue, &data, STEP_MEASURE);
    graph_use_buffer(pass, data.extents, GRAPH_READ_WRITE_COMPUTE);
    if (data.facings.id) {
        pass = add_step(graph, "sparse face", input->queue, &data, STEP_FACE);
        graph_use_buffer(pass, data.extents, GRAPH_READ_WRITE_COMPUTE);
    }
    pass = add_step(graph, "sparse bounds", input->queue, &data, STEP_BOUNDS);
    graph_use_buffer(pass, data.keys, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data.extents, GRAPH_READ_COMPUTE);
    graph_use_buffer(pass, data.bounds, GRAPH_WRITE_COMPUTE);
    if (data.facings.id) graph_use_buffer(pass, data.facings, GRAPH_WRITE_COMPUTE);

    struct bvh tree = bvh_tree_add(graph, input, in_view, data.header_address);
    struct bvh_query query = {.what = "sparse",
                              .bounds = data.bounds,
                              .cell_count = data.cell_limit,
                              .cell_counter = data.table,
                              .cell_counter_offset = data.key_count * 4ull,
                              .facings = data.facings,
                              .cone_tests = params->grid.cone_tests,
                              .occupied = true,
                              .pool_capacity = params->grid.pool_capacity,
                              .header = data.header,
                              .header_address = data.header_address};
    lists.lights = bvh_query_add(graph, device, input, in_view, &tree, &query);
    lists.lights.kind = GPU_LIST_SPARSE;
    lists.lights.extra = data.table;
    lists.lights.byte_count += (data.key_count + 1) * 4ull;
    lists.lights.fixed_bytes += (data.key_count + 1) * 4ull;
    if (params->blend) {
        VkDeviceAddress address;
        struct gpu_light_list *header = light_list_header(device, input, &address);
        if (header) clustered_grid(header, input->width, input->height, &params->grid);
        lists.blend = bvh_clusters_add(graph, device, input, in_view, &tree, "sparse blend", header, address, &params->grid);
    }
    return lists;
}
