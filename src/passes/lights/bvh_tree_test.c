/* SPDX-License-Identifier: MIT */
/**
 * The tree over the lights from inside: order, boxes and masks against what they are made of, how few lights cells ask, and that cells find
 * nothing but by way of the tree.
 */
#include "passes/lights/bvh.h"
#include "passes/lights/bvh_shared.h"
#include "passes/lights/clustered.h"
#include "tests/list_bench.h"
#include "tests/vulkan_spy.h"

enum { LIGHTS = 3000, WIDTH = 301, HEIGHT = 173, BLOCK_X = 2, BLOCK_Y = 2, BLOCK_Z = 4 };

static fnl_light_params params[LIGHTS];
static struct list_light lights[LIGHTS];


struct node_box {
    float low[3], high[3];
};
_Static_assert(sizeof(struct node_box) == sizeof(struct gpu_bvh_box), "the same bytes");

/* All that building left behind. */
struct built {
    struct bvh tree;
    struct list_copy list;
    uint32_t *pairs, *sums, light_count;
    struct gpu_bound *spheres, *bounds;
    struct node_box *boxes;
    void *captured;
};

static void built_free(struct built *b) {
    list_free(&b->list);
    free(b->pairs);
    free(b->sums);
    free(b->spheres);
    free(b->bounds);
    free(b->boxes);
    free(b->captured);
}

/*
 * With the buffer `name` as it is after `pass`, unless that is NULL; and with one box of the tree overwritten after its level is made,
 * unless `spoiled` is NULL.
 */
static struct built build(const struct gpu_view *view, const char *pass, const char *name, uint32_t level, uint32_t node,
                          const struct node_box *spoiled) {
    gpu_device *device = harness_device();
    struct built b = {0};
    struct list_lab lab = list_lab_open(view, lights, LIGHTS);
    list_lab_begin(&lab);
    struct clustered_params grid = clustered_params_default();
    grid.tile_size = 32;
    VkDeviceAddress address;
    struct gpu_light_list *header = light_list_header(device, &lab.input, &address);
    clustered_grid(header, view->size.x, view->size.y, &grid);
    b.list.grid = *header;
    b.tree = bvh_tree_add(lab.graph, &lab.input, &lab.in_view, address);
    struct light_list list =
        bvh_clusters_add(lab.graph, device, &lab.input, &lab.in_view, &b.tree, "tested", header, address, &grid);
    struct gpu_buffer captured, box;
    assert_int_equal(gpu_buffer_create(device, "captured", 1 << 22, GPU_MEMORY_READBACK, &captured), FNL_OK);
    assert_int_equal(gpu_buffer_create(device, "spoiled box", sizeof *spoiled, GPU_MEMORY_UPLOAD, &box), FNL_OK);
    static const char *const levels[] = {"bvh leaves", "bvh nodes"};
    spy_begin(device);
    if (pass) spy_capture(lab.graph, pass, name, &captured);
    if (spoiled) {
        memcpy(box.mapped, spoiled, sizeof *spoiled);
        spy_overwrite(lab.graph, levels[level], "bvh boxes", (b.tree.firsts[level] + node) * sizeof *spoiled,
                      sizeof *spoiled, &box);
    }
    list_lab_run(&lab,
                 (graph_buffer[]){b.tree.pairs, b.tree.spheres, b.tree.boxes, lab.in_view.bounds, lab.in_view.sums,
                                  list.cells, list.ids, list.totals},
                 8);
    spy_end();
    b.pairs = list_reads_take(&lab.reads, 0);
    b.spheres = list_reads_take(&lab.reads, 1);
    b.boxes = list_reads_take(&lab.reads, 2);
    b.bounds = list_reads_take(&lab.reads, 3);
    b.sums = list_reads_take(&lab.reads, 4);
    b.list.cells = list_reads_take(&lab.reads, 5);
    b.list.ids = list_reads_take(&lab.reads, 6);
    memcpy(&b.list.totals, lab.reads.buffers[7].mapped, sizeof b.list.totals);
    b.list.cell_count = list.cell_count;
    b.light_count = b.sums[LIGHTS];
    b.captured = malloc(captured.size);
    assert_non_null(b.captured);
    memcpy(b.captured, captured.mapped, captured.size);
    list_lab_close(&lab);
    gpu_buffer_destroy(device, &captured);
    gpu_buffer_destroy(device, &box);
    return b;
}

/* Many small lights: more than one level of nodes in view. */
static struct gpu_view many_lights(uint32_t kind) {
    struct random_state random = {12 + kind};
    struct gpu_view view = list_random_view(kind, &random, WIDTH, HEIGHT);
    list_random_lights(&view, &random, LIGHTS, params, lights);
    for (uint32_t i = 0; i < LIGHTS; i++) {
        params[i].range = 0.02f * vec3_distance(params[i].position, view.eye);
        lights[i] = list_light_of(&params[i], i);
    }
    return view;
}

/* ---- the tree ---- */

static uint32_t every_third_bit(uint32_t key, uint32_t first) {
    uint32_t value = 0;
    for (uint32_t i = 0; i < 8; i++) value |= (key >> (3 * i + first) & 1) << i;
    return value;
}

static double quantised(double part) { return fmin(fmax(part, 0), 1) * 255; }

/* Lights lie along the curve through the grid; boxes hold what is below them, and are hardly any larger. */
static void test_order_and_boxes_ES_55(void **state) {
    UNUSED(state);
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++) {
        struct gpu_view view = many_lights(kind);
        struct built b = build(&view, NULL, NULL, 0, 0, NULL);
        const struct gpu_light_list *g = &b.list.grid;
        assert_int_equal(b.tree.level_count, 2);
        assert_int_equal(b.tree.counts[0], DIVIDE_UP(LIGHTS, BVH_WIDTH));
        assert_int_equal(b.tree.counts[1], DIVIDE_UP(b.tree.counts[0], BVH_WIDTH));
        assert_true(b.light_count > 100);
        bool *seen = calloc(b.light_count, sizeof *seen);
        assert_non_null(seen);
        for (uint32_t k = 0; k < b.light_count; k++) {
            uint32_t key = b.pairs[2 * k], index = b.pairs[2 * k + 1];
            assert_true(index < b.light_count && !seen[index]);
            seen[index] = true;
            assert_true(k == 0 || b.pairs[2 * k - 2] <= key);
            assert_memory_equal(&b.spheres[k], &b.bounds[index], sizeof *b.bounds);
            const struct gpu_bound *s = &b.spheres[k];
            double depth = -(double)s->center.z,
                   spread = view.orthographic > 0.5f ? 1 : fmax(depth, (double)view.near_distance);
            double x = ((double)s->center.x / spread - (double)view.ndc_offset.x) / (double)view.ndc_scale.x,
                   y = ((double)s->center.y / spread - (double)view.ndc_offset.y) / (double)view.ndc_scale.y,
                   slice = depth > 0 ? log2(depth) * (double)g->slice_scale + (double)g->slice_bias : 0;
            assert_true(fabs(every_third_bit(key, 0) - quantised(x * 0.5 + 0.5)) < 1.01);
            assert_true(fabs(every_third_bit(key, 1) - quantised(y * 0.5 + 0.5)) < 1.01);
            assert_true(fabs(every_third_bit(key, 2) - quantised(slice / g->slices)) < 1.01);
        }
        free(seen);
        for (uint32_t leaf = 0; leaf * BVH_WIDTH < b.light_count; leaf++)
            for (int axis = 0; axis < 3; axis++) {
                double low = INFINITY, high = -INFINITY, low_wide = INFINITY, high_wide = -INFINITY;
                for (uint32_t k = leaf * BVH_WIDTH; k < MIN((leaf + 1) * BVH_WIDTH, b.light_count); k++) {
                    const float *center = &b.spheres[k].center.x;
                    double c = center[axis], r = b.spheres[k].radius, slack = 3e-4 * r + 1e-5;
                    for (int i = 0; i < 3; i++) slack += 1e-5 * fabs((double)center[i]);
                    low = fmin(low, c - r);
                    high = fmax(high, c + r);
                    low_wide = fmin(low_wide, c - r - slack);
                    high_wide = fmax(high_wide, c + r + slack);
                }
                assert_true((double)b.boxes[leaf].low[axis] <= low && (double)b.boxes[leaf].low[axis] >= low_wide);
                assert_true((double)b.boxes[leaf].high[axis] >= high && (double)b.boxes[leaf].high[axis] <= high_wide);
            }
        for (uint32_t node = 0; node < b.tree.counts[1]; node++)
            for (int axis = 0; axis < 3; axis++) {
                float low = 3e38f, high = -3e38f; /* of what holds nothing */
                for (uint32_t c = node * BVH_WIDTH; c < MIN((node + 1) * BVH_WIDTH, b.tree.counts[0]); c++) {
                    low = fminf(low, b.boxes[c].low[axis]);
                    high = fmaxf(high, b.boxes[c].high[axis]);
                }
                assert_true(b.boxes[b.tree.firsts[1] + node].low[axis] == low);
                assert_true(b.boxes[b.tree.firsts[1] + node].high[axis] == high);
            }
        built_free(&b);
    }
}

/* ---- the walk ---- */

static bool boxes_touch(const float *low_a, const float *high_a, const float *low_b, const float *high_b) {
    bool touch = true;
    for (int axis = 0; axis < 3; axis++) touch = touch && low_a[axis] <= high_b[axis] && low_b[axis] <= high_a[axis];
    return touch;
}

static uint32_t group_of(const struct gpu_light_list *g, uint32_t cell) {
    uint32_t x = cell % g->tiles_x, y = cell / g->tiles_x % g->tiles_y, slice = cell / (g->tiles_x * g->tiles_y);
    return (slice / BLOCK_Z * DIVIDE_UP(g->tiles_y, BLOCK_Y) + y / BLOCK_Y) * DIVIDE_UP(g->tiles_x, BLOCK_X) + x / BLOCK_X;
}

static uint32_t group_count_of(const struct gpu_light_list *g) {
    return group_of(g, g->tiles_x * g->tiles_y * g->slices - 1) + 1;
}

/* Box against box and planes, as cells ask leaves; the box is `slack` metres larger. */
static bool cell_touches_box(const struct gpu_cell_bounds *cell, const struct node_box *box, double slack) {
    for (int axis = 0; axis < 3; axis++)
        if ((double)(&cell->low.x)[axis] > (double)box->high[axis] + slack ||
            (double)box->low[axis] > (double)(&cell->high.x)[axis] + slack)
            return false;
    for (int i = 0; i < 4; i++) {
        double most = cell->planes[i].w;
        for (int axis = 0; axis < 3; axis++) {
            double n = (double)(&cell->planes[i].x)[axis];
            most += n * (double)(n > 0 ? box->high[axis] : box->low[axis]);
        }
        if (most < -slack) return false;
    }
    return true;
}

/*
 * Groups are boxes round their cells, and carry a bit for just those nodes that they touch and whose parent they touch. What cells then
 * have to ask is a small part of all pairs of cells and lights.
 */
static void test_masks_and_tests_ES_55(void **state) {
    UNUSED(state);
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++) {
        struct gpu_view view = many_lights(kind);
        struct built cells = build(&view, "tested bounds", "tested cell bounds", 0, 0, NULL),
                     groups = build(&view, "tested groups", "tested group boxes", 0, 0, NULL),
                     b = build(&view, "tested leaves touched", "tested masks", 0, 0, NULL);
        const struct gpu_light_list *g = &b.list.grid;
        const struct gpu_cell_bounds *bounds = cells.captured;
        const struct node_box *boxes = groups.captured;
        uint32_t group_count = group_count_of(g), words[2];
        const uint32_t *masks[2];
        for (uint32_t level = 0, first = 0; level < 2; first += group_count * words[level++]) {
            words[level] = DIVIDE_UP(b.tree.counts[level], 32u);
            masks[level] = (const uint32_t *)b.captured + first;
        }
        for (uint32_t group = 0; group < group_count; group++) {
            struct node_box box = {{3e38f, 3e38f, 3e38f}, {-3e38f, -3e38f, -3e38f}};
            for (uint32_t c = 0; c < b.list.cell_count; c++)
                for (int axis = 0; axis < 3 && group_of(g, c) == group; axis++) {
                    box.low[axis] = fminf(box.low[axis], (&bounds[c].low.x)[axis]);
                    box.high[axis] = fmaxf(box.high[axis], (&bounds[c].high.x)[axis]);
                }
            assert_memory_equal(&boxes[group], &box, sizeof box);
            for (uint32_t level = 0; level < 2; level++)
                for (uint32_t node = 0; node < b.tree.counts[level]; node++) {
                    const struct node_box *n = &b.boxes[b.tree.firsts[level] + node];
                    bool bit = masks[level][group * words[level] + node / 32] >> node % 32 & 1,
                         want = node * (level ? BVH_WIDTH * BVH_WIDTH : BVH_WIDTH) < b.light_count &&
                                boxes_touch(box.low, box.high, n->low, n->high);
                    if (level == 0) want = want && masks[1][group * words[1] + node / 1024] >> node / 32 % 32 & 1;
                    assert_int_equal(bit, want);
                }
        }
        uint64_t leaves = 0, tests = 0, all = (uint64_t)b.list.cell_count * b.light_count,
                 all_leaves = (uint64_t)b.list.cell_count * DIVIDE_UP(b.light_count, BVH_WIDTH);
        for (uint32_t c = 0; c < b.list.cell_count; c++)
            for (uint32_t leaf = 0; leaf < b.tree.counts[0]; leaf++) {
                if (!(masks[0][group_of(g, c) * words[0] + leaf / 32] >> leaf % 32 & 1)) continue;
                leaves++;
                if (cell_touches_box(&bounds[c], &b.boxes[leaf], 0))
                    tests += MIN((leaf + 1) * BVH_WIDTH, b.light_count) - leaf * BVH_WIDTH;
            }
        print_message("%s: cells ask %.3f of all leaves and %.4f of all lights; %.4f touch\n", list_view_names[kind],
                      (double)leaves / (double)all_leaves, (double)tests / (double)all,
                      (double)list_entries(&b.list) / (double)all);
        /* 0.31 and 0.23 at most; both are 1 where boxes or masks leave nothing out. */
        assert_true((double)leaves < 0.4 * (double)all_leaves && (double)tests < 0.3 * (double)all);
        built_free(&cells);
        built_free(&groups);
        built_free(&b);
    }
}

/* Whether the light with this number of those in view is in the list of a cell. */
static bool holds(const struct built *b, uint32_t cell, uint32_t index) {
    for (uint32_t light = 0; light < LIGHTS; light++)
        if (b->sums[light] == index && b->sums[light + 1] == index + 1) return list_holds(&b->list, cell, light);
    fail();
    return false;
}

/* Without its box an inner node hides all lights below it from all cells, whatever the boxes of its leaves say. */
static void test_inner_boxes_are_walked_ES_55(void **state) {
    UNUSED(state);
    struct gpu_view view = many_lights(0);
    static const struct node_box nothing = {{3e38f, 3e38f, 3e38f}, {-3e38f, -3e38f, -3e38f}};
    struct built full = build(&view, NULL, NULL, 0, 0, NULL), spoiled = build(&view, NULL, NULL, 1, 0, &nothing);
    enum { BELOW = BVH_WIDTH * BVH_WIDTH };
    assert_true(full.light_count > BELOW + 100);
    bool hidden[LIGHTS] = {false};
    for (uint32_t light = 0, index; light < LIGHTS; light++) {
        if (full.sums[light] == full.sums[light + 1]) continue;
        index = full.sums[light];
        for (uint32_t k = 0; k < BELOW; k++) hidden[light] = hidden[light] || full.pairs[2 * k + 1] == index;
    }
    uint64_t gone = 0, left = 0;
    for (uint32_t c = 0; c < full.list.cell_count; c++) {
        struct gpu_cell cell = full.list.cells[c];
        for (uint32_t i = 0; i < cell.count; i++) {
            uint32_t light = full.list.ids[cell.offset + i];
            assert_int_equal(list_holds(&spoiled.list, c, light), !hidden[light]);
            *(hidden[light] ? &gone : &left) += 1;
        }
    }
    assert_true(gone > 100 && left > 100);
    built_free(&full);
    built_free(&spoiled);
}

/* With a box that is a point in one cell, the lights of a leaf are found by cells that hold the point, not by their neighbours. */
static void test_leaf_boxes_are_asked_ES_55(void **state) {
    UNUSED(state);
    struct gpu_view view = many_lights(0);
    struct built full = build(&view, "tested bounds", "tested cell bounds", 0, 0, NULL);
    const struct gpu_cell_bounds *bounds = full.captured;
    const struct gpu_light_list *g = &full.list.grid;
    uint32_t shown = 0;
    for (uint32_t leaf = 0; leaf < 12; leaf++) {
        /* A cell that holds lights of the leaf. */
        uint32_t cell = 0, most = 0, first = leaf * BVH_WIDTH;
        bool *held = calloc((size_t)full.list.cell_count * BVH_WIDTH, sizeof *held);
        assert_non_null(held);
        for (uint32_t c = 0; c < full.list.cell_count; c++) {
            uint32_t count = 0;
            if (full.list.cells[c].count)
                for (uint32_t k = 0; k < BVH_WIDTH; k++)
                    count += held[c * BVH_WIDTH + k] = holds(&full, c, full.pairs[2 * (first + k) + 1]);
            if (count > most) most = count, cell = c;
        }
        assert_true(most > 0);
        struct node_box point;
        uint32_t tile = cell % (g->tiles_x * g->tiles_y);
        double seen[3], depth = 0.5 * -((double)bounds[cell].low.z + (double)bounds[cell].high.z);
        view_of_pixel(&view, (tile % g->tiles_x + 0.5) * g->tile_size, (tile / g->tiles_x + 0.5) * g->tile_size, depth,
                      seen);
        for (int axis = 0; axis < 3; axis++) point.low[axis] = point.high[axis] = (float)seen[axis];
        if (!cell_touches_box(&bounds[cell], &point, -1e-3)) { /* a tile cut short by the edge */
            free(held);
            continue;
        }
        struct built spoiled = build(&view, NULL, NULL, 0, leaf, &point);
        for (uint32_t c = 0; c < full.list.cell_count; c++) {
            bool asked = cell_touches_box(&bounds[c], &point, -1e-3);
            if (asked != cell_touches_box(&bounds[c], &point, 1e-3)) continue; /* rounding decides */
            for (uint32_t k = 0; k < BVH_WIDTH && full.list.cells[c].count; k++) {
                if (!held[c * BVH_WIDTH + k]) continue;
                assert_int_equal(holds(&spoiled, c, full.pairs[2 * (first + k) + 1]), asked);
                shown += !asked && group_of(g, c) == group_of(g, cell); /* a neighbour whose group has the leaf's bit */
            }
        }
        free(held);
        built_free(&spoiled);
    }
    print_message("%u lights are hidden from cells whose group touches their leaf\n", shown);
    assert_true(shown > 5);
    built_free(&full);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_order_and_boxes_ES_55, harness_check),
        cmocka_unit_test_teardown(test_masks_and_tests_ES_55, harness_check),
        cmocka_unit_test_teardown(test_inner_boxes_are_walked_ES_55, harness_check),
        cmocka_unit_test_teardown(test_leaf_boxes_are_asked_ES_55, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
