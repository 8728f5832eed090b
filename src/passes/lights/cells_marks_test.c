/* SPDX-License-Identifier: MIT */
/** Marks of blocks of cells: the lists are the bytes that testing every light gives, and few lights are tested. */
#include "tests/list_bench.h"
#include "tests/vulkan_spy.h"

enum { LIGHTS = 2500, WIDTH = 333, HEIGHT = 205, LEAST = 2048 };

static fnl_light_params params[LIGHTS];
static struct list_light lights[LIGHTS];

struct built {
    struct list_copy list;
    uint64_t tests, all_tests; /* of a light against a cell, in the count alone; without marks */
    uint32_t mark_work, extra_words;
};

/* Overwritten with ones before it is read: nothing; the marks, so that every block has every light; the bounds of the first cell, which are no
   numbers then. With zeros, once lights are counted: the bounds of all cells. */
enum spoiled { SPOIL_NOTHING, SPOIL_MARKS, SPOIL_BOUNDS, SPOIL_COUNTED };

static struct built build(const struct list_request *r, enum spoiled spoiled) {
    static const char *const names[] = {[LIST_TILED] = "tiled", [LIST_HALFZ] = "halfz", [LIST_25D] = "2.5d",
                                        [LIST_ENHANCED] = "enhanced", [LIST_CLUSTERED] = "clustered"};
    const char *what = r->front ? "tiled blend" : names[r->builder];
    char pass[32], name[32], count[32], cell_bounds[32];
    snprintf(pass, sizeof pass, "%s mark", what);
    snprintf(name, sizeof name, "%s marks", what);
    snprintf(count, sizeof count, "%s count", what);
    snprintf(cell_bounds, sizeof cell_bounds, "%s cell bounds", what);
    gpu_device *device = harness_device();
    struct list_lab lab = list_lab_open(&r->view, r->lights, r->light_count);
    struct tiled_params tiled = r->tiled;
    graph_image depth = list_lab_depth(&lab, r->depth);
    if (r->front) tiled.front = list_lab_depth(&lab, r->front);
    list_lab_begin(&lab);
    struct light_list list;
    switch (r->builder) {
    case LIST_TILED:
        list = tiled_add(lab.graph, device, &lab.input, &lab.in_view, depth, &tiled);
        break;
    case LIST_HALFZ:
        list = halfz_add(lab.graph, device, &lab.input, &lab.in_view, depth, &tiled);
        break;
    case LIST_25D:
        list = tiled25d_add(lab.graph, device, &lab.input, &lab.in_view, depth, &tiled);
        break;
    case LIST_ENHANCED:
        list = enhanced_add(lab.graph, device, &lab.input, &lab.in_view, &tiled);
        break;
    default:
        list = clustered_add(lab.graph, device, &lab.input, &lab.in_view, &r->clustered);
        break;
    }
    struct built b = {.list = {.grid = list_grid(r), .cell_count = list.cell_count}};
    struct gpu_buffer marks, ones;
    assert_int_equal(gpu_buffer_create(device, "captured marks", 1 << 20, GPU_MEMORY_READBACK, &marks), FNL_OK);
    assert_int_equal(gpu_buffer_create(device, "all marks", marks.size, GPU_MEMORY_UPLOAD, &ones), FNL_OK);
    memset(ones.mapped, spoiled == SPOIL_COUNTED ? 0 : 0xff, ones.size);
    spy_begin(device);
    spy_clear();
    if (spoiled == SPOIL_MARKS) spy_overwrite(lab.graph, pass, name, 0, ones.size, &ones);
    if (spoiled == SPOIL_BOUNDS)
        spy_overwrite(lab.graph, "tiled bounds", "tiled cell bounds", 0, sizeof(struct gpu_cell_bounds), &ones);
    if (spoiled == SPOIL_COUNTED)
        spy_overwrite(lab.graph, count, cell_bounds, 0, MIN(ones.size, list.cell_count * sizeof(struct gpu_cell_bounds)), &ones);
    spy_capture(lab.graph, pass, name, &marks);
    list_lab_run(&lab, (graph_buffer[]){list.cells, list.ids, list.totals, list.extra}, list.extra.id ? 4 : 3);
    b.mark_work = spy_count_work(pass);
    spy_end();
    b.list.cells = list_reads_take(&lab.reads, 0);
    b.list.ids = list_reads_take(&lab.reads, 1);
    memcpy(&b.list.totals, lab.reads.buffers[2].mapped, sizeof b.list.totals);
    if (list.extra.id) b.list.extra = list_reads_take(&lab.reads, 3);
    if (list.extra.id)
        b.extra_words = r->builder == LIST_ENHANCED ? b.list.totals.entries : (uint32_t)(lab.reads.buffers[3].size / 4);
    if (b.mark_work) {
        const struct gpu_light_list *g = &b.list.grid;
        const uint32_t side = g->slices > 2 ? 2 : 4, words = DIVIDE_UP(r->light_count, 32u), *bits = marks.mapped;
        for (uint32_t z = 0; z < g->slices; z++)
            for (uint32_t y = 0; y < g->tiles_y; y++)
                for (uint32_t x = 0; x < g->tiles_x; x++) {
                    uint32_t block = (z / 4 * DIVIDE_UP(g->tiles_y, side) + y / side) * DIVIDE_UP(g->tiles_x, side) + x / side;
                    for (uint32_t i = 0; i < b.list.totals.in_view; i++) b.tests += bits[block * words + i / 32] >> i % 32 & 1;
                }
    }
    b.all_tests = (uint64_t)list.cell_count * b.list.totals.in_view;
    list_lab_close(&lab);
    gpu_buffer_destroy(device, &marks);
    gpu_buffer_destroy(device, &ones);
    return b;
}

static void built_free(struct built *b) { list_free(&b->list); }

static bool same_lists(const struct built *a, const struct built *b) {
    return list_equal(&a->list, &b->list) && a->extra_words == b->extra_words &&
           (!a->extra_words || memcmp(a->list.extra, b->list.extra, a->extra_words * 4ull) == 0);
}

/* Returns the part of the tests that marks leave. */
static double check_marks(const struct list_request *r) {
    struct built marked = build(r, SPOIL_NOTHING), direct = build(r, SPOIL_MARKS);
    assert_true(marked.mark_work > 0);
    assert_int_equal(direct.tests, direct.all_tests); /* the marks are what decides */
    list_check_form(&marked.list, r->light_count);
    assert_int_equal(marked.list.totals.overflow_cells, 0);
    assert_true(same_lists(&marked, &direct));
    double part = (double)marked.tests / (double)marked.all_tests;
    built_free(&marked);
    built_free(&direct);
    return part;
}

static struct list_request request_of(enum list_builder builder, const struct gpu_view *view, const float *depth) {
    struct list_request r = {.builder = builder,
                             .view = *view,
                             .lights = lights,
                             .light_count = LIGHTS,
                             .depth = depth,
                             .tiled = tiled_params_default(),
                             .clustered = clustered_params_default()};
    r.clustered.tile_size = 32;
    return r;
}

/* Every kind of cells in every kind of view: lights of all sizes, round the viewer and behind; some that are not numbers. */
static void test_lists_are_those_of_all_tests(void **state) {
    UNUSED(state);
    struct random_state random = {21};
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++) {
        struct gpu_view view = list_random_view(kind, &random, WIDTH + kind, HEIGHT);
        list_random_lights(&view, &random, LIGHTS, params, lights);
        lights[40].bounds.center.y = NAN;
        lights[41].bounds.radius = INFINITY;
        float *depth = list_random_depth(&view, &random), *front = list_random_depth(&view, &random);
        depth[WIDTH * 30 + 70] = NAN;
        for (int bounds = TILE_PLANES; bounds <= TILE_RECTANGLE; bounds++) {
            struct list_request r = request_of(LIST_TILED, &view, bounds == (int)kind % 3 ? NULL : depth);
            r.tiled.bounds = (enum tile_bounds)bounds;
            check_marks(&r);
        }
        struct list_request blended = request_of(LIST_TILED, &view, depth);
        blended.front = front;
        check_marks(&blended);
        for (int builder = LIST_HALFZ; builder <= LIST_CLUSTERED; builder++) {
            struct list_request r = request_of((enum list_builder)builder, &view, depth);
            check_marks(&r);
        }
        free(depth);
        free(front);
    }
}

/* Small lights, as many lights must be: a cell looks at few of them, and where it has no depth at few more than it takes. Fewer lights than are
   worth it are not marked. */
static void test_few_lights_are_tested(void **state) {
    UNUSED(state);
    struct random_state random = {22};
    struct gpu_view view = list_random_view(0, &random, WIDTH, HEIGHT);
    list_random_lights(&view, &random, LIGHTS, params, lights);
    for (uint32_t i = 0; i < LIGHTS; i++) lights[i].bounds.radius = fminf(lights[i].bounds.radius, 0.5f);
    float *depth = list_random_depth(&view, &random);
    static const struct { enum list_builder builder; double most; } kinds[] = {
        {LIST_TILED, 0.1}, {LIST_HALFZ, 0.1}, {LIST_25D, 0.1}, {LIST_ENHANCED, 0.5}, {LIST_CLUSTERED, 0.1}};
    for (uint32_t k = 0; k < COUNT_OF(kinds); k++) {
        struct list_request r = request_of(kinds[k].builder, &view, depth);
        double part = check_marks(&r);
        print_message("kind %d: %.4f of the tests\n", (int)kinds[k].builder, part);
        assert_true(part > 0 && part < kinds[k].most);
    }
    struct list_request r = request_of(LIST_TILED, &view, depth);
    r.light_count = LEAST - 1;
    struct built few = build(&r, SPOIL_NOTHING);
    assert_int_equal(few.mark_work, 0);
    built_free(&few);
    free(depth);
}

/* What the count finds is copied: the fill does not look at the cells again, with few lights and with many. Where a bit for each cell and light
   takes too much memory it does, and finds the same. */
static void test_lights_are_tested_once(void **state) {
    UNUSED(state);
    struct random_state random = {24};
    struct gpu_view view = list_random_view(0, &random, WIDTH, HEIGHT);
    list_random_lights(&view, &random, LIGHTS, params, lights);
    float *depth = list_random_depth(&view, &random), *front = list_random_depth(&view, &random);
    for (int n = 0; n < 2 * 5; n++) {
        static const enum list_builder builders[] = {LIST_TILED, LIST_TILED, LIST_HALFZ, LIST_25D, LIST_CLUSTERED};
        struct list_request r = request_of(builders[n / 2], &view, depth);
        if (n / 2 == 1) r.front = front;
        if (n % 2) r.light_count = 100;
        struct built plain = build(&r, SPOIL_NOTHING), spoiled = build(&r, SPOIL_COUNTED);
        assert_true(plain.list.totals.entries > 50);
        assert_true(same_lists(&plain, &spoiled));
        built_free(&plain);
        built_free(&spoiled);
    }
    struct list_request r = request_of(LIST_CLUSTERED, &view, depth);
    r.clustered.tile_size = 16;
    r.clustered.slices = 1024;
    r.clustered.pool_capacity = 1 << 24;
    for (uint32_t i = 0; i < LIGHTS; i++) lights[i].bounds.radius = fminf(lights[i].bounds.radius, 0.5f);
    struct built plain = build(&r, SPOIL_NOTHING), spoiled = build(&r, SPOIL_COUNTED);
    assert_true(plain.list.cell_count * (uint64_t)DIVIDE_UP(LIGHTS, 32) * 4 > 64 << 20);
    list_check_form(&plain.list, LIGHTS);
    assert_int_equal(plain.list.totals.overflow_cells, 0);
    assert_false(same_lists(&plain, &spoiled)); /* it looked */
    built_free(&plain);
    built_free(&spoiled);
    free(depth);
    free(front);
}

/* Such a cell takes every light, so every light is marked for it. */
static void test_bounds_that_are_no_numbers(void **state) {
    UNUSED(state);
    struct random_state random = {23};
    struct gpu_view view = list_random_view(0, &random, WIDTH, HEIGHT);
    list_random_lights(&view, &random, LIGHTS, params, lights);
    float *depth = list_random_depth(&view, &random);
    struct list_request r = request_of(LIST_TILED, &view, depth);
    r.tiled.cone_tests = false;
    struct built b = build(&r, SPOIL_BOUNDS);
    assert_int_equal(b.list.cells[0].count, b.list.totals.in_view);
    built_free(&b);
    free(depth);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_bounds_that_are_no_numbers, spy_tear_down),
        cmocka_unit_test_teardown(test_lists_are_those_of_all_tests, spy_tear_down),
        cmocka_unit_test_teardown(test_few_lights_are_tested, spy_tear_down),
        cmocka_unit_test_teardown(test_lights_are_tested_once, spy_tear_down),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
