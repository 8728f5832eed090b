/* SPDX-License-Identifier: MIT */
/** The requests of work groups, against those of every pixel by itself. */
#include "passes/shadow/requests.h"
#include "passes/shadow/requests_shared.h"
#include "shaders.h"
#include "tests/list_bench.h"

struct asked {
    uint32_t *wanted; /* and the word behind, which counts */
    uint32_t words;
};

struct ask {
    const struct gpu_view *view;
    const struct list_light *lights;
    uint32_t light_count, pool_capacity;
    const float *depth;
    bool simple;
    const struct gpu_shader *shader;
    bool tiles;
};

static struct asked ask(const struct ask *a) {
    struct list_lab lab = list_lab_open(a->view, a->lights, a->light_count);
    graph_image depth = list_lab_depth(&lab, a->depth);
    list_lab_begin(&lab);
    struct gpu_slice maps = gpu_frame_allocate(harness_device(), sizeof(struct gpu_shadow_maps));
    assert_non_null(maps.data);
    *(struct gpu_shadow_maps *)maps.data = (struct gpu_shadow_maps){.widest = SHADOW_BLOCK_TEXELS, .first_row = 0 - lab.input.set.directional_count};
    struct tiled_params tiled = tiled_params_default();
    tiled.pool_capacity = a->pool_capacity;
    struct light_list list = a->tiles ? tiled_add(lab.graph, harness_device(), &lab.input, &lab.in_view, depth, &tiled)
                                      : light_list_all_add(lab.graph, harness_device(), &lab.input);
    struct lighting scopes = {.lights = lab.input.set, .view = lab.input.view, .shadows.maps.address = maps.address};
    scopes.lights.simple = a->simple;
    struct lighting lighting = lighting_add(lab.graph, harness_device(), &scopes, &list);
    lighting.bits &= ~GPU_LIGHTING_MAPS;
    lighting.shadows.maps = (struct shadow_maps){0};
    struct asked out = {.words = a->light_count * SHADOW_ROW_WORDS};
    graph_buffer wanted = graph_create_buffer(lab.graph, "wanted", out.words * 4ull + 4);
    graph_add_clear(lab.graph, "clear", GRAPH_QUEUE_GRAPHICS, (struct graph_clear){.buffers = {wanted}});
    struct gpu_shadow_requests_push push = {.lighting = lighting.address};
    struct graph_pass *pass =
        graph_dispatch(lab.graph, &(struct graph_dispatch){.name = "ask",
                                                           .pipeline = {a->shader, 2, {lighting.bits, 1}},
                                                           .groups = {DIVIDE_UP(a->view->size.x, 8u), DIVIDE_UP(a->view->size.y, 8u)},
                                                           GRAPH_PUSH(push),
                                                           GRAPH_ROWS(graph_samples(&push.depth, depth), graph_changes(&push.wanted, wanted))});
    lighting_use(pass, &lighting, GRAPH_READ_COMPUTE);
    list_lab_run(&lab, &wanted, 1);
    out.wanted = list_reads_take(&lab.reads, 0);
    list_lab_close(&lab);
    return out;
}

enum { LIGHTS = 300 };
static fnl_light_params params[LIGHTS];
static struct list_light lights[LIGHTS];

struct work {
    uint64_t reached, visited; /* pixels and lights */
};

/* Groups ask for the same pages, whatever the list; `out_work` receives what they took. */
static void expect_alike(struct ask *a, struct work *work) {
    a->shader = &shader_requests_test_comp;
    a->tiles = false;
    struct asked alone = ask(a);
    uint32_t pages = 0;
    for (uint32_t i = 0; i < alone.words; i++) pages += (uint32_t)__builtin_popcount(alone.wanted[i]);
    work->reached += alone.wanted[alone.words];
    a->shader = &shader_requests_count_comp;
    for (uint32_t tiles = 0; tiles < 2; tiles++) {
        a->tiles = tiles;
        struct asked together = ask(a);
        for (uint32_t i = 0; i < alone.words; i++)
            if (alone.wanted[i] != together.wanted[i])
                fail_msg("light %u, word %u: pixels ask for %08x, groups for %08x", i / SHADOW_ROW_WORDS, i % SHADOW_ROW_WORDS, alone.wanted[i],
                         together.wanted[i]);
        if (tiles) work->visited += together.wanted[together.words];
        free(together.wanted);
    }
    free(alone.wanted);
    assert_true(pages > 0 || a->light_count == 0);
}

static void test_groups_ask_as_pixels_do(void **state) {
    UNUSED(state);
    struct random_state random = {77};
    struct work work = {0};
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++)
        for (uint32_t simple = 0; simple < 2; simple++) {
            struct gpu_view view = list_random_view(kind, &random, 157, 83);
            (simple ? list_random_lights : list_random_shapes)(&view, &random, LIGHTS, params, lights);
            float *depth = list_random_depth(&view, &random);
            expect_alike(&(struct ask){&view, lights, LIGHTS, kind == 2 ? 0 : 1 << 20, depth, .simple = simple}, &work);
            free(depth);
        }
    print_message("%.1f M times a light reaches a pixel; %.2f M visits\n", (double)work.reached * 1e-6, (double)work.visited * 1e-6);
    assert_true(work.visited < work.reached);
}

/* A flat floor far from its lights: their pages are large there, and single pixels have next to nothing to do. */
static void test_floors_take_few_visits(void **state) {
    UNUSED(state);
    fnl_camera camera = fnl_camera_default();
    struct gpu_view view = view_from_camera(&camera, 320, 180);
    struct random_state random = {5};
    float *depth = malloc(320 * 180 * sizeof *depth);
    assert_non_null(depth);
    for (uint32_t i = 0; i < 320 * 180; i++) depth[i] = depth_of_view_depth(&view, 10);
    for (uint32_t i = 0; i < 64; i++) {
        double at[3] = {(double)random_range(&random, -4, 4), (double)random_range(&random, -2, 2), -7}, world[3];
        view_to_world(&view, at, world);
        params[i] = fnl_light_params_default();
        params[i].position = vec3_make((float)world[0], (float)world[1], (float)world[2]);
        params[i].range = 20;
        lights[i] = list_light_of(&params[i], i);
    }
    struct work work = {0};
    expect_alike(&(struct ask){&view, lights, 64, 1 << 20, depth, .simple = true}, &work);
    print_message("%.2f M times a light reaches a pixel; %.3f M visits\n", (double)work.reached * 1e-6, (double)work.visited * 1e-6);
    assert_int_equal(work.reached, 64 * 320 * 180);
    assert_true(work.visited * 20 < work.reached);
    free(depth);
}

static void test_few_pixels_and_lights(void **state) {
    UNUSED(state);
    struct random_state random = {9};
    struct work work = {0};
    struct gpu_view view = list_random_view(0, &random, 1, 1);
    list_random_lights(&view, &random, LIGHTS, params, lights);
    float near = depth_of_view_depth(&view, 2), sky = 0;
    expect_alike(&(struct ask){&view, lights, LIGHTS, 1 << 20, &near, .simple = false}, &work);
    struct asked none = ask(&(struct ask){&view, lights, LIGHTS, 1 << 20, &sky, .shader = &shader_requests_count_comp, .tiles = true});
    for (uint32_t i = 0; i <= none.words; i++) assert_int_equal(none.wanted[i], 0);
    free(none.wanted);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_groups_ask_as_pixels_do, harness_check),
        cmocka_unit_test_teardown(test_floors_take_few_visits, harness_check),
        cmocka_unit_test_teardown(test_few_pixels_and_lights, harness_check),
    };
    return cmocka_run_group_tests_name("shadow_requests", tests, harness_begin, harness_end);
}
