/* SPDX-License-Identifier: MIT */
/** Tiled light trees: their walks against plain loops, their cost, and that threads make no difference. */
#include "passes/lights/tree.h"
#include "tests/list_bench.h"

enum { LIGHTS = 600, WIDTH = 157, HEIGHT = 93 };

static fnl_light_params params[4096];
static struct list_light lights[4096];

static struct gpu_light_list grid_of(const struct gpu_view *view, uint32_t tile_size) {
    return (struct gpu_light_list){.tile_size = tile_size,
                                   .tiles_x = DIVIDE_UP(view->size.x, tile_size),
                                   .tiles_y = DIVIDE_UP(view->size.y, tile_size),
                                   .slices = 1};
}

static struct light_tree build(const struct gpu_view *view, const struct gpu_light_list *grid, uint32_t count,
                               uint32_t capacity, bool hybrid) {
    struct light_tree tree;
    light_tree_init(&tree, gpu_host(harness_device()));
    if (capacity) tree.capacity = capacity;
    struct gpu_entity_bounds *bounds = list_bounds_of(lights, count);
    assert_int_equal(light_tree_see(&tree, bounds, count, 1u << GPU_ENTITY_LIGHT, view), FNL_OK);
    free(bounds);
    assert_int_equal(light_tree_build(&tree, gpu_jobs(harness_device()), grid, view, hybrid), FNL_OK);
    return tree;
}

/* A walk finds exactly the entries whose range holds the depth, ascending. Returns how many. */
static uint32_t check_walk(const struct light_tree *tree, uint32_t cell, float view_depth, uint64_t *visited) {
    static uint32_t found[1 << 16];
    struct gpu_cell c = tree->cells.data[cell];
    uint32_t code = light_tree_depth_code(view_depth), count = light_tree_walk(tree, cell, view_depth, found, visited),
             next = 0;
    for (uint32_t i = 0; i < c.count; i++) {
        uint32_t range = tree->ranges.data[c.offset + i];
        if (code < (range & 0xffff) || code > range >> 16) continue;
        assert_true(next < count);
        assert_int_equal(found[next++], i);
    }
    assert_int_equal(next, count);
    return count;
}

/* Points in the air of every tile: no light that reaches one is missing, and ids ascend. */
static void test_sets_ES_66(void **state) {
    UNUSED(state);
    struct random_state random = {71};
    uint64_t lit = 0, visited = 0;
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++)
        for (int hybrid = 0; hybrid < 2; hybrid++) {
            struct gpu_view view = list_random_view(kind, &random, WIDTH, HEIGHT + kind);
            list_random_lights(&view, &random, LIGHTS, params, lights);
            struct gpu_light_list grid = grid_of(&view, 8u << (kind + (uint32_t)hybrid) % 4);
            struct light_tree tree = build(&view, &grid, LIGHTS, 0, hybrid);
            assert_int_equal(tree.overflow_cells, 0);
            uint64_t sum = 0;
            for (uint32_t c = 0; c < tree.cells.count; c++) {
                struct gpu_cell cell = tree.cells.data[c];
                assert_int_equal(cell.offset, sum);
                sum += cell.count;
                for (uint32_t i = 1; i < cell.count; i++)
                    assert_true(tree.ids.data[cell.offset + i - 1] < tree.ids.data[cell.offset + i]);
            }
            assert_int_equal(sum, tree.entry_count);
            for (uint32_t p = 0; p < 4000; p++) {
                double x = (double)random_range(&random, 0, (float)WIDTH),
                       y = (double)random_range(&random, 0, (float)HEIGHT), at[3], point[3],
                       depth = exp2((double)random_range(&random, -3, 7));
                view_of_pixel(&view, x, y, depth, at);
                view_to_world(&view, at, point);
                uint32_t cell = (uint32_t)y / grid.tile_size * grid.tiles_x + (uint32_t)x / grid.tile_size;
                check_walk(&tree, cell, (float)depth, &visited);
                const struct gpu_cell *c = &tree.cells.data[cell];
                uint32_t code = light_tree_depth_code((float)depth);
                for (uint32_t i = 0, k = 0; i < LIGHTS; i++) {
                    while (k < c->count && tree.ids.data[c->offset + k] < i) k++;
                    if (!light_reaches(&params[i], point)) continue;
                    assert_true(k < c->count && tree.ids.data[c->offset + k] == i);
                    uint32_t range = tree.ranges.data[c->offset + k];
                    assert_true(code >= (range & 0xffff) && code <= range >> 16);
                    lit++;
                }
            }
            light_tree_finish(&tree);
        }
    assert_true(lit > 10000);
}

static void place_in_tile(const struct gpu_view *view, struct random_state *random, uint32_t count, float range) {
    for (uint32_t i = 0; i < count; i++) {
        double at[3], world[3];
        view_of_pixel(view, (double)random_range(random, 4, 12), (double)random_range(random, 4, 12),
                      exp2((double)random_range(random, 1, 8)), at);
        view_to_world(view, at, world);
        params[i] = fnl_light_params_default();
        params[i].position = vec3_make((float)world[0], (float)world[1], (float)world[2]);
        params[i].range = range * -(float)at[2];
        lights[i] = list_light_of(&params[i], i);
    }
}

/* A thousand lights in one tile, in no order of depth: a walk visits few nodes. */
static void test_visited_nodes_ES_66(void **state) {
    UNUSED(state);
    fnl_camera camera = fnl_camera_default();
    camera.vertical_fov = 0.1f;
    struct gpu_view view = view_from_camera(&camera, 16, 16);
    struct gpu_light_list grid = grid_of(&view, 16);
    struct random_state random = {81};
    for (int hybrid = 0; hybrid < 2; hybrid++) {
        place_in_tile(&view, &random, 1000, 0.01f);
        struct light_tree tree = build(&view, &grid, 1000, 0, hybrid);
        assert_int_equal(tree.cells.data[0].count, 1000);
        uint64_t visited = 0, found = 0, most = 0;
        enum { WALKS = 2000 };
        for (uint32_t i = 0; i < WALKS; i++) {
            uint64_t before = visited;
            found += check_walk(&tree, 0, exp2f(random_range(&random, 0, 9)), &visited);
            most = MAX(most, visited - before);
        }
        print_message("1000 lights in a tile: %.1f nodes visited, %.1f lights found; at most %llu\n",
                      (double)visited / WALKS, (double)found / WALKS, (unsigned long long)most);
        assert_true(visited < 150 * (uint64_t)WALKS && most < 300);
        light_tree_finish(&tree);
    }
}

/* Where lights reach through the whole depth the hybrid visits each once, a tree nearly twice as many nodes. */
static void test_hybrid_ES_66(void **state) {
    UNUSED(state);
    fnl_camera camera = fnl_camera_default();
    camera.vertical_fov = 0.1f;
    struct gpu_view view = view_from_camera(&camera, 16, 16);
    struct gpu_light_list grid = grid_of(&view, 16);
    struct random_state random = {91};
    place_in_tile(&view, &random, 1000, 0.9f);
    for (uint32_t i = 0; i < 1000; i++) lights[i].bounds.radius = 500;
    uint64_t visited[2] = {0};
    for (int hybrid = 0; hybrid < 2; hybrid++) {
        struct light_tree tree = build(&view, &grid, 1000, 0, hybrid);
        assert_int_equal(check_walk(&tree, 0, 20, &visited[hybrid]), 1000);
        light_tree_finish(&tree);
    }
    assert_int_equal(visited[1], 1000);
    assert_true(visited[0] > 1900);
}

static void test_overflow_and_threads_ES_66(void **state) {
    UNUSED(state);
    struct random_state random = {5};
    struct gpu_view view = list_random_view(0, &random, WIDTH, HEIGHT);
    list_random_lights(&view, &random, LIGHTS, params, lights);
    lights[3].bounds.radius = INFINITY; /* everywhere */
    lights[4].bounds.center.y = NAN;
    lights[5].bounds.radius = 0; /* nowhere */
    struct gpu_light_list grid = grid_of(&view, 16);
    struct light_tree full = build(&view, &grid, LIGHTS, 0, true);
    uint32_t entries = (uint32_t)full.entry_count;
    const uint32_t capacities[] = {1, entries / 2, entries - 1, entries};
    for (uint32_t k = 0; k < COUNT_OF(capacities); k++) {
        struct light_tree tree = build(&view, &grid, LIGHTS, capacities[k], true);
        assert_int_equal(tree.entry_count, entries);
        assert_true((tree.overflow_cells > 0) == (capacities[k] < entries));
        assert_true(tree.ids.count <= capacities[k]);
        if (capacities[k] == entries) {
            assert_memory_equal(tree.ids.data, full.ids.data, entries * 4ull);
            assert_memory_equal(tree.nodes.data, full.nodes.data, entries * 16ull);
        }
        light_tree_finish(&tree);
    }
    for (uint32_t c = 0; c < full.cells.count; c++) {
        uint64_t visited = 0;
        assert_true(check_walk(&full, c, 3, &visited) > 0);
        uint32_t i = full.cells.data[c].offset;
        while (full.ids.data[i] < 3) i++;
        assert_int_equal(full.ids.data[i], 3);
    }
    light_tree_finish(&full);
    for (uint32_t count = 0; count < 2; count++) {
        struct gpu_view small = list_random_view(0, &random, 1, 1);
        struct gpu_light_list one = grid_of(&small, 64);
        struct light_tree tree = build(&small, &one, count, 0, true);
        assert_int_equal(tree.cells.count, 1);
        light_tree_finish(&tree);
    }
}

/* On the device: the same lights as from enhanced lists, and fewer evaluations than plain tiles without depth. */
static void test_evaluations_ES_66(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:onetile?lights=1000", 0);
    fnl_frame frame = stage.frame;
    frame.shading = FNL_SHADING_FORWARD;
    frame.count_lights = true;
    uint64_t evaluations[3];
    static const fnl_light_lists lists[] = {FNL_LISTS_TILED, FNL_LISTS_ENHANCED, FNL_LISTS_TREE};
    for (uint32_t i = 0; i < 3; i++) {
        frame.lists = lists[i];
        struct shot shot = stage_shoot(&stage, &frame);
        evaluations[i] = shot.stats.evaluations;
        shot_free(&shot);
    }
    print_message("evaluations: tiled without depth %llu, enhanced %llu, tree %llu\n", (unsigned long long)evaluations[0],
                  (unsigned long long)evaluations[1], (unsigned long long)evaluations[2]);
    assert_true((double)evaluations[2] < 0.8 * (double)evaluations[0]);
    assert_true(fabs((double)evaluations[2] - (double)evaluations[1]) < 0.01 * (double)evaluations[1]);
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_visited_nodes_ES_66, harness_check),
        cmocka_unit_test_teardown(test_hybrid_ES_66, harness_check),
        cmocka_unit_test_teardown(test_sets_ES_66, harness_check),
        cmocka_unit_test_teardown(test_overflow_and_threads_ES_66, harness_check),
        cmocka_unit_test_teardown(test_evaluations_ES_66, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
