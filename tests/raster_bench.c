/* SPDX-License-Identifier: MIT */
#include "tests/raster_bench.h"

struct raster_request raster_request_of(const struct gpu_view *view, const struct list_light *lights, uint32_t light_count) {
    struct raster_request r = {
        .view = *view, .lights = lights, .light_count = light_count, .raster = raster_params_default()};
    r.raster.grid.tile_size = 32;
    return r;
}

/* Turns linked lists into arrays; fails on links that leave the pool and on lists that are longer than the pool. */
static void walk_links(struct raster_copy *copy, const struct list_light *lights, uint32_t nodes, uint32_t capacity) {
    struct list_copy *list = &copy->list;
    list->cells = malloc(list->cell_count * sizeof *list->cells);
    list->ids = malloc(MAX(capacity, 1u) * 4ull);
    assert_true(list->cells && list->ids);
    uint32_t total = 0;
    for (uint32_t c = 0; c < list->cell_count; c++) {
        uint32_t node = copy->heads[c];
        list->cells[c] = (struct gpu_cell){total, GPU_CELL_ALL};
        if (node == GPU_NODE_ALL) continue;
        list->cells[c].count = 0;
        while (node != GPU_NODE_END) {
            assert_true(node < capacity && total < capacity);
            uint32_t word = copy->words[nodes == GPU_NODES_64 ? 2 * node : node];
            list->ids[total++] = nodes == GPU_NODES_64 ? word & 0xffffff : word >> 20;
            if (nodes == GPU_NODES_64) {
                assert_int_equal(word >> 24, lights[word & 0xffffff].shape.kind);
                node = copy->words[2 * node + 1];
            } else {
                node = (word & GPU_NODE_32_END) == GPU_NODE_32_END ? GPU_NODE_END : word & GPU_NODE_32_END;
            }
            list->cells[c].count++;
        }
    }
}

static struct gpu_buffer upload(const char *name, const void *data, uint64_t size) {
    struct gpu_buffer buffer;
    assert_int_equal(gpu_buffer_create(harness_device(), name, size, GPU_MEMORY_UPLOAD, &buffer), FNL_OK);
    if (size) memcpy(buffer.mapped, data, size);
    return buffer;
}

struct raster_copy raster_build(const struct raster_request *request) {
    struct list_lab lab = list_lab_open(&request->view, request->lights, request->light_count);
    struct gpu_buffer meshes = {0}, points = {0};
    struct raster_params raster = request->raster;
    raster.near = request->view.near_distance;
    if (request->meshes) {
        meshes = upload("test meshes", request->meshes, request->light_count * sizeof *request->meshes);
        points = upload("test points", request->points, request->point_count * sizeof(vec3));
        raster.meshes = meshes.address;
        raster.points = points.address;
    }
    list_lab_begin(&lab);
    struct raster_list built = raster_add(lab.graph, harness_device(), &lab.input, &lab.in_view, &raster);
    list_lab_run(&lab,
                 (graph_buffer[]){built.list.cells, built.list.ids, built.list.totals, built.rectangles, built.slots,
                                  built.slot_sums, lab.in_view.ids},
                 7);
    struct raster_copy copy = {.byte_count = built.list.byte_count, .kind = built.list.kind};
    copy.list.grid.local_count = request->light_count;
    clustered_grid(&copy.list.grid, request->view.size.x, request->view.size.y, &raster.grid);
    copy.list.cell_count = built.list.cell_count;
    memcpy(&copy.list.totals, lab.reads.buffers[2].mapped, sizeof copy.list.totals);
    uint32_t nodes = raster_nodes(&raster, request->light_count);
    if (nodes == GPU_NODES_ARRAY) {
        copy.list.cells = list_reads_take(&lab.reads, 0);
        copy.list.ids = list_reads_take(&lab.reads, 1);
    } else {
        copy.word_count = (uint32_t)(lab.reads.buffers[1].size / 4);
        copy.heads = list_reads_take(&lab.reads, 0);
        copy.words = list_reads_take(&lab.reads, 1);
        walk_links(&copy, request->lights, nodes, copy.word_count / (nodes == GPU_NODES_64 ? 2 : 1));
    }
    copy.rectangles = list_reads_take(&lab.reads, 3);
    copy.slots = list_reads_take(&lab.reads, 4);
    copy.slot_sums = list_reads_take(&lab.reads, 5);
    copy.visible = list_reads_take(&lab.reads, 6);
    list_lab_close(&lab);
    gpu_buffer_destroy(harness_device(), &meshes);
    gpu_buffer_destroy(harness_device(), &points);
    return copy;
}

void raster_copy_free(struct raster_copy *copy) {
    list_free(&copy->list);
    free(copy->words);
    free(copy->heads);
    free(copy->rectangles);
    free(copy->slots);
    free(copy->slot_sums);
    free(copy->visible);
}
