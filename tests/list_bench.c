/* SPDX-License-Identifier: MIT */
#include "tests/list_bench.h"

#include "render/device/light_shapes.h"

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

struct gpu_light_list list_grid(const struct list_request *request) {
    struct gpu_light_list grid = {.local_count = request->light_count, .slices = 1};
    uint32_t width = request->view.size.x, height = request->view.size.y;
    if (list_is_tiled(request)) {
        grid.slices = list_has_halves(request) ? 2 : 1;
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
                                .set.local_count = request->light_count,
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
    lab.input = (struct light_input){.set = {.entities = lab.lights.address + bounds,
                                             .shapes = lab.lights.address + shapes,
                                             .lights = lab.lights.address,
                                             .local_count = light_count},
                                     .kinds = 1u << GPU_ENTITY_LIGHT,
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
    lab->input.set.buffer = graph_import_buffer(lab->graph, "test lights", &lab->lights);
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
