/* SPDX-License-Identifier: MIT */
/** Clusters filled from the tree: entry by entry what the flat count of all lights gives. */
#include "tests/list_bench.h"


enum { LIGHTS = 400, MOST = 100000, WIDTH = 301, HEIGHT = 173 };

static fnl_light_params params[MOST];
static struct list_light lights[MOST];

static struct list_request request_of(const struct gpu_view *view, uint32_t light_count) {
    struct list_request r = {.builder = LIST_BVH,
                             .view = *view,
                             .lights = lights,
                             .light_count = light_count,
                             .tiled = tiled_params_default(),
                             .clustered = clustered_params_default()};
    r.clustered.tile_size = 32;
    return r;
}

/* Builds with the tree, again, and flat; all three must be equal to the byte. Returns the number of entries. */
static uint64_t check_equal(struct list_request r) {
    r.builder = LIST_BVH;
    struct list_copy tree = list_build(&r), again = list_build(&r);
    r.builder = LIST_CLUSTERED;
    struct list_copy flat = list_build(&r);
    list_check_form(&tree, r.light_count);
    assert_true(list_equal(&tree, &again));
    assert_true(list_equal(&tree, &flat));
    uint64_t entries = list_entries(&tree);
    list_free(&tree);
    list_free(&again);
    list_free(&flat);
    return entries;
}

static void test_sets_ES_53_ES_55(void **state) {
    UNUSED(state);
    struct random_state random = {21};
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++) {
        struct gpu_view view = list_random_view(kind, &random, WIDTH - 3 * kind, HEIGHT + kind);
        list_random_lights(&view, &random, LIGHTS, params, lights);
        struct list_request r = request_of(&view, LIGHTS);
        for (int options = 0; options < 4; options++) {
            r.clustered.linear = options & 1;
            r.clustered.cone_tests = options & 2;
            assert_true(check_equal(r) > 1000);
        }
        struct list_copy list = list_build(&r);
        reference_check(&r, &list);
        list_free(&list);
    }
}

static void test_sizes_and_counts_ES_55(void **state) {
    UNUSED(state);
    static const uint32_t counts[] = {0, 1, 2, 31, 32, 33, 255, 257, 1023, 1025, 5000, 33000};
    static const struct {
        uint32_t width, height, tile_size, slices;
        float near, far;
    } grids[] = {
        {1, 1, 64, 24, 0.5f, 100}, {65, 3, 64, 1, 0.5f, 100}, {97, 61, 16, 2, 1, 2}, {120, 67, 40, 64, 0.01f, 1000}};
    struct random_state random = {4};
    for (uint32_t g = 0; g < COUNT_OF(grids); g++)
        for (uint32_t c = 0; c < COUNT_OF(counts); c++) {
            if (g < 3 && counts[c] > 300) continue;
            struct gpu_view view = list_random_view(g, &random, grids[g].width, grids[g].height);
            list_random_lights(&view, &random, counts[c], params, lights);
            struct list_request r = request_of(&view, counts[c]);
            r.clustered.tile_size = grids[g].tile_size;
            r.clustered.slices = grids[g].slices;
            r.clustered.near = grids[g].near;
            r.clustered.far = grids[g].far;
            r.clustered.pool_capacity = 1 << 22;
            check_equal(r);
        }
}

/* Lists that are sorted by rank, in one block of the radix sort and in several; ids of one digit and of many. */
static void test_long_lists_ascend(void **state) {
    UNUSED(state);
    static const uint32_t counts[] = {12, 127, 128, 129, 250, 1024, 1025, 3000, 70000};
    struct random_state random = {6};
    fnl_camera camera = fnl_camera_default();
    camera.target = vec3_make(camera.position.x, camera.position.y, camera.position.z - 1);
    struct gpu_view view = view_from_camera(&camera, 64, 64);
    for (uint32_t c = 0; c < COUNT_OF(counts); c++) {
        for (uint32_t i = 0; i < counts[c]; i++) { /* all in one place */
            params[i] = fnl_light_params_default();
            params[i].position = vec3_add(camera.position, vec3_make(random_float(&random), random_float(&random), -10));
            params[i].range = 2;
            lights[i] = list_light_of(&params[i], i);
        }
        struct list_request r = request_of(&view, counts[c]);
        r.clustered.pool_capacity = 1 << 23;
        struct list_copy list = list_build(&r);
        list_check_form(&list, counts[c]);
        assert_int_equal(list_longest(&list), counts[c]);
        list_free(&list);
    }
}

static void test_overflow_CL_10(void **state) {
    UNUSED(state);
    struct random_state random = {5};
    struct gpu_view view = list_random_view(0, &random, WIDTH, HEIGHT);
    list_random_lights(&view, &random, LIGHTS, params, lights);
    struct list_request r = request_of(&view, LIGHTS);
    uint32_t entries = (uint32_t)check_equal(r);
    const uint32_t capacities[] = {0, 1, entries / 2, entries - 1, entries, entries + 1};
    for (uint32_t k = 0; k < COUNT_OF(capacities); k++) {
        r.builder = LIST_BVH;
        r.clustered.pool_capacity = capacities[k];
        struct list_copy list = list_build(&r);
        assert_int_equal(list.totals.entries, entries);
        assert_true((list.totals.overflow_cells > 0) == (capacities[k] < entries));
        list_free(&list);
        check_equal(r);
    }
}

/* Lights of NaN and infinity lie somewhere in the tree and spoil neither its boxes nor the others' places. */
static void test_broken_lights(void **state) {
    UNUSED(state);
    struct random_state random = {9};
    struct gpu_view view = list_random_view(0, &random, WIDTH, HEIGHT);
    list_random_lights(&view, &random, LIGHTS, params, lights);
    lights[17].bounds.radius = 0;
    lights[40].bounds.center.y = NAN;
    lights[41].bounds.radius = INFINITY;
    lights[42].bounds.center.x = INFINITY;
    lights[43].bounds.center.z = 3e38f;
    lights[43].bounds.radius = 3e38f;
    check_equal(request_of(&view, LIGHTS));
}

/* Very many lights in the same room, of which each cell has few. That cells ask few leaves is shown by bvh_tree_test.c. */
static void test_100k_lights_ES_55(void **state) {
    UNUSED(state);
    struct random_state random = {12};
    struct gpu_view view = list_random_view(0, &random, WIDTH, HEIGHT);
    list_random_lights(&view, &random, MOST, params, lights);
    for (uint32_t i = 0; i < MOST; i++) {
        params[i].range = 0.02f * vec3_distance(params[i].position, view.eye);
        lights[i] = list_light_of(&params[i], i);
    }
    struct list_request many = request_of(&view, MOST);
    many.clustered.pool_capacity = 1 << 20;
    assert_true(check_equal(many) > MOST / 2);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_sets_ES_53_ES_55, harness_check),
        cmocka_unit_test_teardown(test_sizes_and_counts_ES_55, harness_check),
        cmocka_unit_test_teardown(test_long_lists_ascend, harness_check),
        cmocka_unit_test_teardown(test_overflow_CL_10, harness_check),
        cmocka_unit_test_teardown(test_broken_lights, harness_check),
        cmocka_unit_test_teardown(test_100k_lights_ES_55, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
