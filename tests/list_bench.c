/* SPDX-License-Identifier: MIT */
#include "tests/list_bench.h"

#include "tests/light_reference.h"

/* ---- reading back ---- */

struct read_data {
    graph_buffer from[LIST_READS], to[LIST_READS];
    uint64_t sizes[LIST_READS];
    uint32_t count;
};

static void execute_reads(const struct graph_context *context, const void *data) {
    const struct read_data *d = data;
    for (uint32_t i = 0; i < d->count; i++)
        gpu_copy_buffer(context->commands, graph_get_buffer(context, d->from[i]), 0, graph_get_buffer(context, d->to[i]), 0,
                        d->sizes[i]);
}

static void execute_nothing(const struct graph_context *context, const void *data) {
    UNUSED(context);
    UNUSED(data);
}

void list_reads_add(struct graph *graph, const graph_buffer *buffers, uint32_t count, struct list_reads *out) {
    static const char *const names[LIST_READS] = {"test read 0", "test read 1", "test read 2", "test read 3",
                                                  "test read 4", "test read 5", "test read 6", "test read 7"};
    struct read_data data = {.count = count};
    assert_true(count <= LIST_READS);
    out->count = count;
    for (uint32_t i = 0; i < count; i++) {
        data.from[i] = buffers[i];
        data.sizes[i] = graph_buffer_size(graph, buffers[i]);
        assert_int_equal(gpu_buffer_create(harness_device(), names[i], data.sizes[i], GPU_MEMORY_READBACK, &out->buffers[i]),
                         FNL_OK);
        data.to[i] = graph_import_buffer(graph, names[i], &out->buffers[i]);
    }
    struct graph_pass *pass = graph_add_pass(graph, "test reads", GRAPH_QUEUE_GRAPHICS, execute_reads, &data, sizeof data);
    struct graph_pass *host = graph_add_pass(graph, "test to host", GRAPH_QUEUE_GRAPHICS, execute_nothing, NULL, 0);
    graph_keep(host);
    for (uint32_t i = 0; i < count; i++) {
        graph_use_buffer(pass, data.from[i], GRAPH_COPY_FROM);
        graph_use_buffer(pass, data.to[i], GRAPH_COPY_TO);
        graph_use_buffer(host, data.to[i], GRAPH_READ_HOST);
    }
}

static void *copy_bytes(const void *data, size_t size) {
    void *copy = malloc(MAX(size, 1u));
    assert_non_null(copy);
    if (size) memcpy(copy, data, size);
    return copy;
}

void *list_reads_take(const struct list_reads *reads, uint32_t index) {
    return copy_bytes(reads->buffers[index].mapped, reads->buffers[index].size);
}

void list_reads_free(struct list_reads *reads) {
    for (uint32_t i = 0; i < reads->count; i++) gpu_buffer_destroy(harness_device(), &reads->buffers[i]);
}

void list_readback_add(struct graph *graph, const struct light_list *list, struct list_readback *out) {
    const graph_buffer buffers[] = {list->cells, list->ids, list->totals, list->extra};
    list_reads_add(graph, buffers, list->extra.id ? 4 : 3, &out->reads);
    out->cell_count = list->cell_count;
}

struct list_copy list_readback_take(struct list_readback *readback, const struct gpu_light_list *grid) {
    struct list_copy list = {.grid = *grid, .cell_count = readback->cell_count};
    assert_int_equal(list.cell_count, grid->tiles_x * grid->tiles_y * grid->slices);
    list.cells = list_reads_take(&readback->reads, 0);
    list.ids = list_reads_take(&readback->reads, 1);
    memcpy(&list.totals, readback->reads.buffers[2].mapped, sizeof list.totals);
    if (readback->reads.count > 3) list.extra = list_reads_take(&readback->reads, 3);
    list_reads_free(&readback->reads);
    return list;
}

struct list_copy list_copy_of_cpu(const struct clustered_cpu *builder, const struct gpu_light_list *grid) {
    struct list_copy list = {.grid = *grid, .cell_count = builder->cells.count};
    list.cells = copy_bytes(builder->cells.data, list.cell_count * sizeof *list.cells);
    list.ids = copy_bytes(builder->ids.data, builder->ids.count * 4ull);
    list.totals = (struct light_totals){builder->in_view, (uint32_t)builder->entry_count, 0};
    return list;
}

/* ---- building ---- */

struct list_light list_light_of(const fnl_light_params *light, uint32_t slot) {
    struct gpu_light device;
    struct list_light out;
    device_light(light, slot, &device, &out.bounds);
    out.shape = device.shape;
    return out;
}

struct gpu_entity_bounds *list_bounds_of(const struct list_light *lights, uint32_t count) {
    struct gpu_entity_bounds *bounds = calloc(MAX(count, 1u), sizeof *bounds);
    assert_non_null(bounds);
    for (uint32_t i = 0; i < count; i++) bounds[i] = lights[i].bounds;
    return bounds;
}

static bool is_tiled(const struct list_request *request) { return request->builder <= LIST_ENHANCED; }
static bool has_halves(const struct list_request *request) { return request->builder == LIST_HALFZ && request->depth; }

struct gpu_light_list list_grid(const struct list_request *request) {
    struct gpu_light_list grid = {.local_count = request->light_count, .slices = 1};
    uint32_t width = request->view.size.x, height = request->view.size.y;
    if (is_tiled(request)) {
        grid.slices = has_halves(request) ? 2 : 1;
        grid.tile_size = request->tiled.tile_size;
        grid.tiles_x = DIVIDE_UP(width, grid.tile_size);
        grid.tiles_y = DIVIDE_UP(height, grid.tile_size);
    } else {
        clustered_grid(&grid, width, height, &request->clustered);
    }
    return grid;
}

static struct list_copy build_on_cpu(const struct list_request *request) {
    gpu_device *device = harness_device();
    const struct gpu_view *v = &request->view;
    struct clustered_cpu builder;
    clustered_cpu_init(&builder, gpu_host(device));
    struct light_input input = {.kinds = 1u << GPU_ENTITY_LIGHT,
                                .local_count = request->light_count,
                                .width = v->size.x,
                                .height = v->size.y};
    struct gpu_entity_bounds *bounds = list_bounds_of(request->lights, request->light_count);
    struct clustered_cpu_view view = {v->ndc_scale, v->ndc_offset, v->orthographic > 0.5f, v->size.x, v->size.y};
    struct gpu_light_list grid = list_grid(request);
    assert_int_equal(gpu_frame_begin(device), FNL_OK);
    struct light_list list =
        clustered_cpu_add(&builder, device, &input, bounds, &v->world_to_view, &view, &request->clustered);
    assert_int_equal(gpu_frame_end(device, NULL, 0, NULL), FNL_OK);
    struct list_copy copy = list_copy_of_cpu(&builder, &grid);
    assert_true(list.totals_known);
    copy.totals = list.known;
    clustered_cpu_finish(&builder);
    free(bounds);
    return copy;
}

struct list_lab list_lab_open(const struct gpu_view *view, const struct list_light *lights, uint32_t light_count) {
    gpu_device *device = harness_device();
    struct list_lab lab = {.view = *view};
    const uint64_t shapes = light_count * sizeof(struct gpu_light), bounds = shapes + light_count * sizeof(struct gpu_shape),
                   size = bounds + light_count * sizeof(struct gpu_entity_bounds);
    assert_int_equal(graph_create(gpu_host(device), device, &lab.graph), FNL_OK);
    assert_int_equal(gpu_buffer_create(device, "test lights", size, GPU_MEMORY_UPLOAD, &lab.lights), FNL_OK);
    char *mapped = lab.lights.mapped;
    for (uint32_t i = 0; i < light_count; i++) {
        struct gpu_entity_bounds placed = lights[i].bounds;
        if (placed.shape != GPU_NO_SHAPE) placed.shape = i * (uint32_t)sizeof(struct gpu_shape);
        memcpy(mapped + shapes + i * sizeof(struct gpu_shape), &lights[i].shape, sizeof(struct gpu_shape));
        memcpy(mapped + bounds + i * sizeof placed, &placed, sizeof placed);
        if (placed.kind != GPU_ENTITY_LIGHT) continue;
        struct gpu_light light = {.shape = lights[i].shape, .color = {1, 1, 1}};
        assert_true(placed.user < light_count);
        memcpy(mapped + placed.user * sizeof light, &light, sizeof light);
    }
    graph_begin(lab.graph);
    lab.input = (struct light_input){.entities = lab.lights.address + bounds,
                                     .shapes = lab.lights.address + shapes,
                                     .lights = lab.lights.address,
                                     .kinds = 1u << GPU_ENTITY_LIGHT,
                                     .local_count = light_count,
                                     .width = view->size.x,
                                     .height = view->size.y};
    return lab;
}

graph_image list_lab_image(struct list_lab *lab, VkFormat format, uint32_t texel_bytes, const void *texels) {
    if (!texels) return (graph_image){0};
    static const char *const names[] = {"test image 0", "test image 1"};
    assert_true(lab->image_count < COUNT_OF(lab->images));
    struct gpu_image *image = &lab->images[lab->image_count];
    struct gpu_image_params params = {.name = names[lab->image_count++],
                                      .format = format,
                                      .width = lab->view.size.x,
                                      .height = lab->view.size.y,
                                      .layers = 1,
                                      .mips = 1,
                                      .samples = 1,
                                      .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT};
    uint64_t size = (uint64_t)params.width * params.height * texel_bytes;
    assert_int_equal(gpu_image_create(harness_device(), &params, image), FNL_OK);
    assert_int_equal(gpu_upload_image(harness_device(), image, texels, size, false, false), FNL_OK);
    assert_int_equal(gpu_upload_flush(harness_device()), FNL_OK);
    return graph_import_image(lab->graph, image, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                              VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
}

void list_lab_begin(struct list_lab *lab) {
    gpu_device *device = harness_device();
    assert_int_equal(gpu_frame_begin(device), FNL_OK);
    struct gpu_slice view = gpu_frame_allocate(device, sizeof lab->view);
    assert_non_null(view.data);
    memcpy(view.data, &lab->view, sizeof lab->view);
    lab->input.buffer = graph_import_buffer(lab->graph, "test lights", &lab->lights);
    lab->input.view = view.address;
    lab->in_view = lights_in_view_add(lab->graph, device, &lab->input);
}

static void run_graph(struct graph *graph, const struct graph_execute_params *params) {
    assert_int_equal(graph_compile(graph), FNL_OK);
    assert_int_equal(graph_execute_frame(graph, params), FNL_OK);
    assert_int_equal(gpu_wait_idle(harness_device()), FNL_OK);
}

void list_lab_run(struct list_lab *lab, const graph_buffer *reads, uint32_t read_count) {
    list_reads_add(lab->graph, reads, read_count, &lab->reads);
    run_graph(lab->graph, &(struct graph_execute_params){.record_threads = 1}); /* for vulkan_spy.h */
}

void list_lab_close(struct list_lab *lab) {
    list_reads_free(&lab->reads);
    graph_destroy(&lab->graph);
    gpu_buffer_destroy(harness_device(), &lab->lights);
    for (uint32_t i = 0; i < lab->image_count; i++) gpu_image_destroy(harness_device(), &lab->images[i]);
}

struct list_copy list_build(const struct list_request *request) {
    if (request->builder == LIST_CLUSTERED_CPU) return build_on_cpu(request);
    struct list_lab lab = list_lab_open(&request->view, request->lights, request->light_count);
    struct tiled_params tiled = request->tiled;
    graph_image depth = list_lab_depth(&lab, request->depth);
    if (request->front) tiled.front = list_lab_depth(&lab, request->front);
    list_lab_begin(&lab);
    gpu_device *device = harness_device();
    const struct light_input *input = &lab.input;
    const struct lights_in_view *in_view = &lab.in_view;
    struct light_list list;
    switch (request->builder) {
    case LIST_TILED:
        list = tiled_add(lab.graph, device, input, in_view, depth, &tiled);
        break;
    case LIST_HALFZ:
        list = halfz_add(lab.graph, device, input, in_view, depth, &tiled);
        break;
    case LIST_25D:
        list = tiled25d_add(lab.graph, device, input, in_view, depth, &tiled);
        break;
    case LIST_ENHANCED:
        list = enhanced_add(lab.graph, device, input, in_view, &tiled);
        break;
    case LIST_BVH:
        list = bvh_add(lab.graph, device, input, in_view, &request->clustered);
        break;
    default:
        list = clustered_add(lab.graph, device, input, in_view, &request->clustered);
        break;
    }
    struct list_readback readback;
    list_readback_add(lab.graph, &list, &readback);
    run_graph(lab.graph, &(struct graph_execute_params){.record_threads = 1}); /* for vulkan_spy.h */
    struct gpu_light_list grid = list_grid(request);
    struct list_copy copy = list_readback_take(&readback, &grid);
    list_lab_close(&lab);
    return copy;
}

void list_free(struct list_copy *list) {
    free(list->cells);
    free(list->ids);
    free(list->extra);
    *list = (struct list_copy){0};
}

/* ---- looking at lists ---- */

uint64_t list_entries(const struct list_copy *list) {
    uint64_t sum = 0;
    for (uint32_t c = 0; c < list->cell_count; c++)
        if (list->cells[c].count != GPU_CELL_ALL) sum += list->cells[c].count;
    return sum;
}

uint32_t list_longest(const struct list_copy *list) {
    uint32_t longest = 0;
    for (uint32_t c = 0; c < list->cell_count; c++)
        if (list->cells[c].count != GPU_CELL_ALL) longest = MAX(longest, list->cells[c].count);
    return longest;
}

bool list_holds(const struct list_copy *list, uint32_t cell, uint32_t light) {
    if (list->cells[cell].count == GPU_CELL_ALL) return true;
    const uint32_t *ids = list->ids + list->cells[cell].offset;
    uint32_t low = 0, high = list->cells[cell].count; /* they ascend */
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (ids[middle] < light)
            low = middle + 1;
        else
            high = middle;
    }
    return low < list->cells[cell].count && ids[low] == light;
}

void list_check_form(const struct list_copy *list, uint32_t light_count) {
    uint64_t sum = 0;
    uint32_t overflowed = 0;
    for (uint32_t c = 0; c < list->cell_count; c++) {
        struct gpu_cell cell = list->cells[c];
        if (cell.count == GPU_CELL_ALL) {
            overflowed++;
            continue;
        }
        if (!overflowed) assert_int_equal(cell.offset, sum);
        sum += cell.count;
        for (uint32_t i = 0; i < cell.count; i++) {
            assert_true(list->ids[cell.offset + i] < light_count);
            assert_true(i == 0 || list->ids[cell.offset + i - 1] < list->ids[cell.offset + i]);
        }
    }
    assert_int_equal(list->totals.overflow_cells, overflowed);
    if (overflowed)
        assert_true(list->totals.entries > sum);
    else
        assert_int_equal(list->totals.entries, sum);
    assert_true(list->totals.in_view <= light_count);
}

bool list_equal(const struct list_copy *a, const struct list_copy *b) {
    if (a->cell_count != b->cell_count || memcmp(&a->totals, &b->totals, sizeof a->totals) != 0) return false;
    for (uint32_t c = 0; c < a->cell_count; c++) {
        if (a->cells[c].count != b->cells[c].count || a->cells[c].offset != b->cells[c].offset) return false;
        if (a->cells[c].count == GPU_CELL_ALL) continue;
        if (memcmp(a->ids + a->cells[c].offset, b->ids + b->cells[c].offset, a->cells[c].count * sizeof *a->ids) != 0)
            return false;
    }
    return true;
}

void list_cells_of(const struct list_copy *list, uint32_t x, uint32_t y, double view_depth, uint32_t out[2]) {
    const struct gpu_light_list *g = &list->grid;
    uint32_t tile = y / g->tile_size * g->tiles_x + x / g->tile_size;
    if (list->extra && g->slices == 2 && g->slice_scale == 0) { /* halves */
        float split;
        memcpy(&split, &list->extra[tile], sizeof split);
        out[0] = view_depth < (double)split * (1 - 1e-5) ? tile : g->tiles_x * g->tiles_y + tile;
        out[1] = view_depth < (double)split * (1 + 1e-5) ? tile : g->tiles_x * g->tiles_y + tile;
        return;
    }
    for (int i = 0; i < 2; i++) {
        double slice = 0;
        if (g->slices > 1) {
            slice = (g->linear ? view_depth : log2(view_depth)) * (double)g->slice_scale + (double)g->slice_bias;
            slice += (i ? 2e-5 : -2e-5) * (g->linear ? g->slices : 1);
            slice = fmin(fmax(slice, 0), g->slices - 1);
        }
        out[i] = (uint32_t)slice * g->tiles_x * g->tiles_y + tile;
    }
}

/* ---- the reference ---- */

static void transform(const mat4 *m, const double p[3], double out[3]) {
    for (int row = 0; row < 3; row++)
        out[row] =
            (double)m->m[row] * p[0] + (double)m->m[4 + row] * p[1] + (double)m->m[8 + row] * p[2] + (double)m->m[12 + row];
}

void world_to_view(const struct gpu_view *view, const double from[3], double out[3]) {
    transform(&view->world_to_view, from, out);
}

void view_to_world(const struct gpu_view *view, const double from[3], double out[3]) {
    /* The inverse of what the GPU multiplies with, not the stored inverse: rigid, but perhaps mirrored. */
    double d[3] = {from[0] - (double)view->world_to_view.m[12], from[1] - (double)view->world_to_view.m[13],
                   from[2] - (double)view->world_to_view.m[14]};
    for (int i = 0; i < 3; i++) {
        const float *column = &view->world_to_view.m[i * 4];
        out[i] = (double)column[0] * d[0] + (double)column[1] * d[1] + (double)column[2] * d[2];
    }
}

static double screen_edge(const struct gpu_view *view, int axis, double pixel) {
    double size = axis ? view->size.y : view->size.x, ndc = axis ? 1 - 2 * pixel / size : 2 * pixel / size - 1;
    return axis ? ndc * (double)view->ndc_scale.y + (double)view->ndc_offset.y
                : ndc * (double)view->ndc_scale.x + (double)view->ndc_offset.x;
}

void view_of_pixel(const struct gpu_view *view, double x, double y, double view_depth, double out[3]) {
    double spread = view->orthographic > 0.5f ? 1 : view_depth;
    out[0] = screen_edge(view, 0, x) * spread;
    out[1] = screen_edge(view, 1, y) * spread;
    out[2] = -view_depth;
}

float depth_of_view_depth(const struct gpu_view *view, double view_depth) {
    /* view depth = (x + y d) / (z + w d) */
    double x = view->depth_decode.x, y = view->depth_decode.y, z = view->depth_decode.z, w = view->depth_decode.w;
    return (float)((x - view_depth * z) / (view_depth * w - y));
}

double view_depth_of_depth(const struct gpu_view *view, float depth) {
    double d = depth;
    return ((double)view->depth_decode.x + (double)view->depth_decode.y * d) /
           ((double)view->depth_decode.z + (double)view->depth_decode.w * d);
}

bool list_position_of(const struct gpu_view *view, const float *depth, uint32_t x, uint32_t y, double out[3]) {
    float stored = depth[(size_t)y * view->size.x + x];
    if (stored <= 0) return false;
    double seen[3];
    view_of_pixel(view, x + 0.5, y + 0.5, view_depth_of_depth(view, stored), seen);
    view_to_world(view, seen, out);
    return true;
}

void pack_normal(const double n[3], uint16_t out[4]) {
    double sum = fabs(n[0]) + fabs(n[1]) + fabs(n[2]), e[2] = {n[0] / sum, n[1] / sum};
    if (n[2] < 0) {
        double x = (1 - fabs(e[1])) * (e[0] < 0 ? -1 : 1), y = (1 - fabs(e[0])) * (e[1] < 0 ? -1 : 1);
        e[0] = x;
        e[1] = y;
    }
    for (int i = 0; i < 2; i++) out[i] = (uint16_t)lrint((e[i] * 0.5 + 0.5) * 65535);
    out[2] = out[3] = 0;
}

void unpack_normal(const uint16_t in[4], double n[3]) {
    double x = in[0] / 65535.0 * 2 - 1, y = in[1] / 65535.0 * 2 - 1;
    n[2] = 1 - fabs(x) - fabs(y);
    n[0] = n[2] < 0 ? (1 - fabs(y)) * (x < 0 ? -1 : 1) : x;
    n[1] = n[2] < 0 ? (1 - fabs(x)) * (y < 0 ? -1 : 1) : y;
    double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int i = 0; i < 3; i++) n[i] /= length;
}

uint32_t list_slice_at(const struct gpu_light_list *g, double depth) {
    double slice = (g->linear ? depth : log2(fmax(depth, 1e-30))) * (double)g->slice_scale + (double)g->slice_bias;
    return (uint32_t)fmin(fmax(slice, 0), g->slices - 1);
}

static const double FAR_AWAY = 1e9;

static double slice_start(const struct gpu_light_list *grid, double slice) {
    double start = (slice - (double)grid->slice_bias) / (double)grid->slice_scale;
    return grid->linear ? start : exp2(start);
}

struct reference_cell reference_cell_of(const struct list_request *request, const struct gpu_light_list *grid, uint32_t cell,
                                        double slack) {
    const struct gpu_view *v = &request->view;
    struct reference_cell r = {0};
    uint32_t tile_x = cell % grid->tiles_x, tile_y = cell / grid->tiles_x % grid->tiles_y,
             slice = cell / (grid->tiles_x * grid->tiles_y);
    uint32_t x0 = tile_x * grid->tile_size, y0 = tile_y * grid->tile_size;
    uint32_t x1 = MIN(x0 + grid->tile_size, v->size.x), y1 = MIN(y0 + grid->tile_size, v->size.y);
    double near = 0, far = FAR_AWAY;
    if (is_tiled(request)) {
        if (request->depth && request->builder != LIST_ENHANCED) {
            double nearest = FAR_AWAY, farthest = 0;
            for (uint32_t y = y0; y < y1; y++)
                for (uint32_t x = x0; x < x1; x++) {
                    float d = request->depth[(size_t)y * v->size.x + x], f = d;
                    if (request->front) f = request->front[(size_t)y * v->size.x + x];
                    if (request->front ? f <= d : d <= 0) continue;
                    nearest = fmin(nearest, view_depth_of_depth(v, f));
                    farthest = fmax(farthest, d <= 0 ? FAR_AWAY : view_depth_of_depth(v, d));
                }
            r.empty = farthest == 0;
            if (has_halves(request)) { /* each from its nearest to its farthest pixel */
                double split = 0.5 * (nearest * (1 - 1e-4) + farthest * (1 + 1e-4)), ends[2] = {FAR_AWAY, 0};
                for (uint32_t y = y0; y < y1; y++)
                    for (uint32_t x = x0; x < x1; x++) {
                        float d = request->depth[(size_t)y * v->size.x + x];
                        double z = d <= 0 ? 0 : view_depth_of_depth(v, d);
                        if (d <= 0 || (slice == 0 ? z > split * (1 + slack) : z < split * (1 - slack))) continue;
                        ends[0] = fmin(ends[0], z);
                        ends[1] = fmax(ends[1], z);
                    }
                r.empty = r.empty || ends[1] == 0;
                nearest = ends[0];
                farthest = ends[1];
            }
            if (request->tiled.min_depth) near = nearest * (1 - slack);
            if (request->tiled.max_depth && farthest < FAR_AWAY) far = farthest * (1 + slack);
        }
    } else {
        if (slice > 0) near = slice_start(grid, slice) * (1 - slack);
        if (slice + 1 < grid->slices) far = slice_start(grid, slice + 1.0) * (1 + slack);
    }
    double *edges = r.edges;
    edges[0] = screen_edge(v, 0, x0);
    edges[1] = screen_edge(v, 0, x1);
    edges[2] = screen_edge(v, 1, y1);
    edges[3] = screen_edge(v, 1, y0);
    bool orthographic = v->orthographic > 0.5f;
    for (int i = 0; i < 4; i++) {
        double sign = i & 1 ? -1 : 1, length = orthographic ? 1 : sqrt(1 + edges[i] * edges[i]);
        r.planes[i][i / 2] = sign / length;
        if (orthographic)
            r.planes[i][3] = -sign * edges[i];
        else
            r.planes[i][2] = sign * edges[i] / length;
    }
    double spread_near = orthographic ? 1 : near, spread_far = orthographic ? 1 : far;
    for (int axis = 0; axis < 2; axis++) {
        r.low[axis] = fmin(edges[axis * 2] * spread_near, edges[axis * 2] * spread_far);
        r.high[axis] = fmax(edges[axis * 2 + 1] * spread_near, edges[axis * 2 + 1] * spread_far);
    }
    r.low[2] = -far;
    r.high[2] = -near;
    return r;
}

static double bound_in_view(const struct list_request *request, uint32_t light, double center[3]) {
    const struct list_light *l = &request->lights[light];
    double world[3] = {l->bounds.center.x, l->bounds.center.y, l->bounds.center.z};
    transform(&request->view.world_to_view, world, center);
    return l->bounds.radius;
}

bool reference_touches(const struct reference_cell *cell, const struct list_request *request, uint32_t light, double slack,
                       bool box) {
    double c[3], radius = bound_in_view(request, light, c), outside2 = 0;
    if (!(radius > 0) || cell->empty) return false;
    radius = radius * (1 + slack) + slack * (1e-2 + sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]) * 1e-2);
    for (int i = 0; i < 4; i++)
        if (cell->planes[i][0] * c[0] + cell->planes[i][1] * c[1] + cell->planes[i][2] * c[2] + cell->planes[i][3] < -radius)
            return false;
    for (int i = box ? 0 : 2; i < 3; i++) {
        double d = fmax(fmax(cell->low[i] - c[i], c[i] - cell->high[i]), 0);
        outside2 += d * d;
    }
    return outside2 <= radius * radius;
}

void reference_slopes(double x, double depth, double radius, double near, double out[2]) {
    out[0] = INFINITY;
    out[1] = -INFINITY;
    double distance2 = x * x + depth * depth, candidates[4][2];
    double half = sqrt(fmax(radius * radius - (near - depth) * (near - depth), 0));
    for (int i = 0; i < 2; i++) { /* the ends of the cut, and where tangents from the viewer touch */
        double sign = i ? 1 : -1, tangent = sqrt(fmax(distance2 - radius * radius, 0)), scale = tangent / distance2;
        candidates[i][0] = x + sign * half;
        candidates[i][1] = depth - radius <= near ? near : 0;
        candidates[2 + i][0] = (tangent * x + sign * radius * depth) * scale;
        candidates[2 + i][1] = (tangent * depth - sign * radius * x) * scale;
    }
    for (int i = 0; i < 4; i++)
        if (candidates[i][1] >= near) {
            out[0] = fmin(out[0], candidates[i][0] / candidates[i][1]);
            out[1] = fmax(out[1], candidates[i][0] / candidates[i][1]);
        }
}

bool reference_takes(const struct reference_cell *cell, const struct list_request *request, uint32_t light, double slack) {
    bool box = !is_tiled(request) || request->tiled.bounds == TILE_BOX;
    if (box || request->tiled.bounds == TILE_PLANES) return reference_touches(cell, request, light, slack, box);
    double c[3], radius = bound_in_view(request, light, c), slopes[2];
    if (!(radius > 0) || cell->empty) return false;
    radius = radius * (1 + slack) + slack * (1e-2 + sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]) * 1e-2);
    for (int axis = 0; axis < 2; axis++) {
        if (request->view.orthographic > 0.5f) {
            slopes[0] = c[axis] - radius;
            slopes[1] = c[axis] + radius;
        } else {
            reference_slopes(c[axis], -c[2], radius, (double)request->view.near_distance, slopes);
        }
        if (slopes[0] > cell->edges[axis * 2 + 1] || slopes[1] < cell->edges[axis * 2]) return false;
    }
    return c[2] - radius <= cell->high[2] && c[2] + radius >= cell->low[2];
}

static void scale_add(double out[3], const double a[3], double s) {
    for (int i = 0; i < 3; i++) out[i] += a[i] * s;
}
static double dot3(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/*
 * The point nearest to the origin of the hull of up to four points: of all their subsets, the one whose plane's nearest point lies between
 * its points. `points` keeps that subset. False when the origin is in the hull or points fall together.
 */
static bool nearest_of_hull(double points[4][3], uint32_t *count, double out[3]) {
    double best = INFINITY;
    uint32_t best_set = 0;
    for (uint32_t set = 1; set < 1u << *count; set++) {
        const double *p[4];
        double m[3][4], weights[4] = {1}, at[3] = {0};
        int n = 0;
        for (uint32_t i = 0; i < *count; i++)
            if (set & 1u << i) p[n++] = points[i];
        for (int i = 1; i < n; i++) {
            for (int j = 1; j < n; j++) {
                m[i - 1][j - 1] = 0;
                for (int k = 0; k < 3; k++) m[i - 1][j - 1] += (p[i][k] - p[0][k]) * (p[j][k] - p[0][k]);
            }
            m[i - 1][3] = 0;
            for (int k = 0; k < 3; k++) m[i - 1][3] -= (p[i][k] - p[0][k]) * p[0][k];
        }
        bool inside = true;
        for (int i = 0; i < n - 1; i++) { /* Gauss; the matrix is positive definite unless points fall together */
            if (!(m[i][i] > 1e-30)) inside = false;
            for (int j = 0; j < n - 1 && inside; j++) {
                double factor = j == i ? 0 : m[j][i] / m[i][i];
                for (int k = 0; k < 4; k++)
                    if (k < n - 1 || k == 3) m[j][k] -= factor * m[i][k];
            }
        }
        for (int i = 1; i < n && inside; i++) {
            weights[i] = m[i - 1][3] / m[i - 1][i - 1];
            weights[0] -= weights[i];
            inside = weights[i] >= 0;
        }
        if (!inside || weights[0] < 0) continue;
        for (int i = 0; i < n; i++) scale_add(at, p[i], weights[i]);
        if (dot3(at, at) < best) {
            best = dot3(at, at);
            best_set = set;
            memcpy(out, at, sizeof at);
        }
    }
    uint32_t kept = 0;
    for (uint32_t i = 0; i < *count; i++)
        if (best_set & 1u << i) memmove(points[kept++], points[i], sizeof points[i]);
    *count = kept;
    return kept > 0 && kept < 4;
}

/* By the algorithm of Gilbert, Johnson and Keerthi (1988) on extreme points of cell and cone. */
double reference_cone_gap(const struct reference_cell *cell, const struct list_request *request, uint32_t light) {
    const struct list_light *l = &request->lights[light];
    if (l->shape.kind != GPU_SHAPE_CONE) return 0;
    const mat4 *m = &request->view.world_to_view;
    double apex[3], tip[3], axis[3], world[3] = {l->shape.position.x, l->shape.position.y, l->shape.position.z}, range = l->shape.range;
    double cosine = fmax(-(double)l->shape.spot_offset / (double)l->shape.spot_scale, 0), sine = sqrt(fmax(1 - cosine * cosine, 0));
    transform(m, world, apex);
    world[0] += (double)l->shape.direction.x;
    world[1] += (double)l->shape.direction.y;
    world[2] += (double)l->shape.direction.z;
    transform(m, world, tip);
    for (int i = 0; i < 3; i++) axis[i] = tip[i] - apex[i];
    double axis_length = sqrt(dot3(axis, axis));
    for (int i = 0; i < 3; i++) axis[i] /= axis_length;
    /* A cell without end is cut where it is out of range. */
    double depths[2] = {fmax(-cell->high[2], -apex[2] - range), fmin(-cell->low[2], -apex[2] + range)};
    if (depths[0] > depths[1]) return depths[0] - depths[1];
    bool orthographic = request->view.orthographic > 0.5f;
    double points[4][3], gap[3] = {-apex[0], -apex[1], -depths[0] - apex[2]};
    uint32_t count = 0;
    for (int step = 0; step < 200; step++) {
        double length = sqrt(dot3(gap, gap));
        if (!(length > 1e-9)) return 0;
        double n[3] = {gap[0] / length, gap[1] / length, gap[2] / length}, least = INFINITY;
        for (int corner = 0; corner < 8; corner++) { /* of the cell, the least along n */
            double depth = depths[corner >> 2], spread = orthographic ? 1 : depth;
            double p[3] = {cell->edges[corner & 1] * spread, cell->edges[2 + (corner >> 1 & 1)] * spread, -depth};
            if (dot3(p, n) < least) {
                least = dot3(p, n);
                memcpy(points[count], p, sizeof p);
            }
        }
        double along = dot3(n, axis), q[3] = {apex[0], apex[1], apex[2]}, across[3] = {n[0], n[1], n[2]};
        scale_add(across, axis, -along);
        double across_length = sqrt(dot3(across, across));
        if (along >= cosine) {
            scale_add(q, n, range);
        } else if (cosine * along + sine * across_length > 1e-12) { /* the rim; else the apex */
            scale_add(q, axis, range * cosine);
            scale_add(q, across, range * sine / across_length);
        }
        if (least - dot3(q, n) > 1e-7) return least - dot3(q, n);
        scale_add(points[count++], q, -1);
        if (!nearest_of_hull(points, &count, gap)) return 0;
    }
    return 0;
}

bool reference_in_view(const struct list_request *request, uint32_t light) {
    double c[3], radius = bound_in_view(request, light, c);
    struct gpu_light_list whole = {
        .tile_size = MAX(request->view.size.x, request->view.size.y), .tiles_x = 1, .tiles_y = 1, .slices = 1};
    struct list_request all = *request;
    all.builder = LIST_TILED;
    all.depth = NULL;
    struct reference_cell frustum = reference_cell_of(&all, &whole, 0, 0);
    return -c[2] + radius >= (double)request->view.near_distance && reference_touches(&frustum, request, light, 0, false);
}

void reference_check(const struct list_request *request, const struct list_copy *list) {
    enum { SAID = 5 };
    uint32_t missing = 0, needless = 0;
    bool cones = is_tiled(request) ? request->tiled.cone_tests : request->clustered.cone_tests;
    bool *in_view = malloc(request->light_count + 1);
    assert_non_null(in_view);
    for (uint32_t light = 0; light < request->light_count; light++) in_view[light] = reference_in_view(request, light);
    for (uint32_t c = 0; c < list->cell_count; c++) {
        if (list->cells[c].count == GPU_CELL_ALL) continue;
        struct reference_cell exact = reference_cell_of(request, &list->grid, c, 0),
                              wide = reference_cell_of(request, &list->grid, c, 2e-4);
        for (uint32_t light = 0; light < request->light_count; light++) {
            bool holds = list_holds(list, c, light);
            if (!holds && in_view[light] && reference_takes(&exact, request, light, 0) &&
                !(cones && reference_cone_gap(&exact, request, light) > 0) && missing++ < SAID)
                print_error("cell %u misses light %u\n", c, light);
            if (holds && !reference_takes(&wide, request, light, 3e-4) && needless++ < SAID)
                print_error("cell %u holds light %u, which is far from it\n", c, light);
        }
    }
    free(in_view);
    assert_int_equal(missing, 0);
    assert_int_equal(needless, 0);
}

bool light_reaches(const fnl_light_params *light, const double point[3]) {
    const double at[3] = {light->position.x, light->position.y, light->position.z};
    double to_light[3];
    if (light->kind == FNL_LIGHT_DIRECTIONAL) return false;
    /* At its very position a light has no direction, but it is there. */
    if (light->kind <= FNL_LIGHT_SPOT && at[0] == point[0] && at[1] == point[1] && at[2] == point[2]) return true;
    return light_reference(light, point, to_light) > 0;
}

/* ---- made-up views, lights and depths ---- */

const char *const list_view_names[LIST_VIEWS] = {"perspective", "orthographic", "off-axis", "mirrored", "wide"};

struct gpu_view list_random_view(uint32_t kind, struct random_state *random, uint32_t width, uint32_t height) {
    fnl_camera camera = fnl_camera_default();
    float yaw = random_range(random, 0, 6.28f);
    camera.position = vec3_make(random_range(random, -20, 20), random_range(random, -5, 5), random_range(random, -20, 20));
    camera.target = vec3_add(camera.position, vec3_make(sinf(yaw), random_range(random, -0.5f, 0.5f), cosf(yaw)));
    camera.vertical_fov = kind == 4 ? 2.4f : random_range(random, 0.5f, 1.3f);
    camera.orthographic = kind == 1;
    camera.vertical_extent = 25;
    if (kind == 2) camera.shift = (fnl_vec2){random_range(random, -1.5f, 1.5f), random_range(random, -1.5f, 1.5f)};
    struct gpu_view view = view_from_camera(&camera, width, height);
    if (kind == 3) { /* the world is mirrored before it is seen */
        mat4 mirror = mat4_scaling(vec3_make(-1, 1, 1));
        view.world_to_view = mat4_mul(view.world_to_view, mirror);
        view.world_to_clip = mat4_mul(view.world_to_clip, mirror);
        mat4_inverse(&view.world_to_view, &view.view_to_world);
        view.eye.x = -view.eye.x;
        view.back.x = -view.back.x;
        for (int i = 0; i < 5; i++) view.planes[i].x = -view.planes[i].x;
    }
    return view;
}

static vec3 world_of(const struct gpu_view *view, double x, double y, double view_depth) {
    double seen[3], world[3];
    view_of_pixel(view, x, y, view_depth, seen);
    view_to_world(view, seen, world);
    return vec3_make((float)world[0], (float)world[1], (float)world[2]);
}

void list_random_lights(const struct gpu_view *view, struct random_state *random, uint32_t count, fnl_light_params *params,
                        struct list_light *lights) {
    for (uint32_t i = 0; i < count; i++) {
        fnl_light_params light = fnl_light_params_default();
        double depth = exp2((double)random_range(random, -2, 6.5f));
        double x = (double)random_range(random, -0.3f, 1.3f) * view->size.x,
               y = (double)random_range(random, -0.3f, 1.3f) * view->size.y;
        light.range = exp2f(random_range(random, -4, 3));
        if (i % 8 == 1) { /* centred on a tile's corner */
            x = floor(x / 16) * 16;
            y = floor(y / 16) * 16;
        } else if (i % 8 == 2) { /* the centre at the near plane */
            depth = (double)view->near_distance;
        } else if (i % 8 == 3) { /* behind */
            depth = -depth * 0.1;
        }
        light.position = world_of(view, x, y, depth);
        if (i % 8 == 4) { /* the rim on the edge of a tile and, to a rounding, on its box */
            vec3 edge = world_of(view, floor(x / 16) * 16, y, depth);
            light.range = fmaxf(vec3_distance(light.position, edge), 1e-3f);
        }
        if (i % 4 == 0) {
            light.kind = FNL_LIGHT_SPOT;
            light.direction = vec3_normalize(
                vec3_make(random_range(random, -1, 1), random_range(random, -1, 1), random_range(random, -1, 1)));
            light.outer_cone_angle = random_range(random, 0.05f, 1.57f);
            light.inner_cone_angle = light.outer_cone_angle * 0.5f;
        }
        params[i] = light;
        lights[i] = list_light_of(&light, i);
    }
}

void list_random_shapes(const struct gpu_view *view, struct random_state *random, uint32_t count, fnl_light_params *params,
                        struct list_light *lights) {
    list_random_lights(view, random, count, params, lights);
    for (uint32_t i = 0; i < count; i += 3) {
        fnl_light_params *p = &params[i];
        p->direction =
            vec3_normalize(vec3_make(random_range(random, -1, 1), random_range(random, -1, 1), random_range(random, -1, 1)));
        switch (i / 3 % 4) {
        case 0:
            p->kind = FNL_LIGHT_CAPSULE;
            p->length = p->range * random_range(random, 0, 3);
            break;
        case 1:
            p->kind = FNL_LIGHT_WEDGE;
            p->wedge_angles[0] = random_range(random, 0.02f, 1.4f);
            p->wedge_angles[1] = random_range(random, 0.02f, 1.4f);
            break;
        case 2:
            p->kind = FNL_LIGHT_BOX;
            p->box_size = vec3_make(p->range * random_range(random, 0.05f, 2), p->range * random_range(random, 0.05f, 2),
                                    p->range * random_range(random, 0.05f, 2));
            break;
        default:
            p->kind = FNL_LIGHT_SPOT;
            p->outer_cone_angle = random_range(random, 0.005f, 0.1f);
            p->inner_cone_angle = 0;
            p->range *= 3;
        }
        lights[i] = list_light_of(p, i);
    }
}

float *list_random_depth(const struct gpu_view *view, struct random_state *random) {
    float *depth = malloc((size_t)view->size.x * view->size.y * sizeof *depth);
    assert_non_null(depth);
    double base = (double)random_range(random, 2, 20), slope = (double)random_range(random, -0.01f, 0.05f);
    for (uint32_t y = 0; y < view->size.y; y++)
        for (uint32_t x = 0; x < view->size.x; x++) {
            double at = base + slope * x + (x / 23 % 3 == 1 ? 15 : 0) + (x % 31 == 7 && y > 9 ? -0.9 * base : 0);
            bool sky = (y < 20 && x > 40) || (x + y) % 57 == 3;
            depth[(size_t)y * view->size.x + x] = sky ? 0 : depth_of_view_depth(view, fmax(at, (double)view->near_distance));
        }
    return depth;
}
