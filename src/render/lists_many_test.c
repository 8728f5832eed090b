/* SPDX-License-Identifier: MIT */
/**
 * Lists when there are very many lights or very little room: pools are large enough from the first frame on, a million lights are visited
 * as a million lights must be, cells that overflow visit a small part of the lights, and points that no cell serves are few.
 */
#include "passes/lights/cells_shared.h"
#include "render/light_reach.h"
#include "render/shading.h"
#include "tests/list_bench.h"
#include "tests/vulkan_spy.h"

/* Kinds with a pool on the device. */
static bool has_pool(fnl_light_lists lists) {
    return lists != FNL_LISTS_ALL && lists != FNL_LISTS_TREE && lists != FNL_LISTS_CLUSTERED_CPU && lists != FNL_LISTS_GRID2D &&
           lists != FNL_LISTS_WORLD && lists != FNL_LISTS_BATCHES && lists != FNL_LISTS_MULTIPASS;
}

static bool needs_items(fnl_light_lists lists) {
    return lists == FNL_LISTS_MESH || lists == FNL_LISTS_BATCHES || lists == FNL_LISTS_MULTIPASS;
}

/* ---- how much room lists take ---- */

/* Of so few lights the estimate sees each, so no list finds more; and it is not idle: at most so many times what they find. */
static void test_estimates_are_bounds(void **state) {
    UNUSED(state);
    enum { LIGHTS = 1500 };
    static fnl_light_params params[LIGHTS];
    static struct list_light lights[LIGHTS];
    struct random_state random = {8};
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++) {
        struct gpu_view view = list_random_view(kind, &random, 301 - kind, 173);
        list_random_lights(&view, &random, LIGHTS, params, lights);
        struct list_request r = {.builder = LIST_ENHANCED,
                                 .view = view,
                                 .lights = lights,
                                 .light_count = LIGHTS,
                                 .tiled = tiled_params_default(),
                                 .clustered = clustered_params_default()};
        r.tiled.cone_tests = r.clustered.cone_tests = false;
        r.clustered.tile_size = r.tiled.tile_size;
        struct list_copy tiles = list_build(&r);
        r.builder = LIST_CLUSTERED;
        struct list_copy clusters = list_build(&r);
        struct gpu_entity_bounds *bounds = list_bounds_of(lights, LIGHTS);
        struct light_reach reach = light_reach_estimate(&view, bounds, LIGHTS, &r.clustered);
        free(bounds);
        print_message("%s: lights %.0f of %u, tiles %.0f of %u, clusters %.0f of %u\n", list_view_names[kind], reach.in_view,
                      tiles.totals.in_view, reach.tiles, tiles.totals.entries, reach.clusters, clusters.totals.entries);
        assert_true(reach.in_view >= tiles.totals.in_view && reach.in_view <= 1.2 * tiles.totals.in_view);
        assert_true(reach.tiles >= tiles.totals.entries && reach.tiles <= 1.5 * tiles.totals.entries);
        assert_true(reach.clusters >= clusters.totals.entries && reach.clusters <= 3.0 * clusters.totals.entries);
        list_free(&tiles);
        list_free(&clusters);
    }
}

/* Of very many it sees some: the sum is near that of all, for lights of which one in a hundred is large, in a pattern. */
static void test_estimates_of_samples(void **state) {
    UNUSED(state);
    enum { LIGHTS = 200000 };
    struct gpu_entity_bounds *lights = calloc(LIGHTS, sizeof *lights);
    assert_non_null(lights);
    struct random_state random = {9};
    struct gpu_view view = list_random_view(0, &random, 640, 360);
    struct clustered_params grid = clustered_params_default();
    for (uint32_t i = 0; i < LIGHTS; i++) {
        double at[3], seen[3];
        view_of_pixel(&view, (double)random_range(&random, -200, 840), (double)random_range(&random, -100, 460),
                      (double)random_range(&random, 1, 60), seen);
        view_to_world(&view, seen, at);
        lights[i].center = vec3_make((float)at[0], (float)at[1], (float)at[2]);
        lights[i].radius = i % 100 == 0 ? 5 : 0.2f;
    }
    struct light_reach sampled = light_reach_estimate(&view, lights, LIGHTS, &grid), all = {0};
    for (uint32_t i = 0; i < LIGHTS; i += 4000) {
        struct light_reach part = light_reach_estimate(&view, lights + i, 4000, &grid);
        all.in_view += part.in_view;
        all.tiles += part.tiles;
        all.slices += part.slices;
        all.clusters += part.clusters;
    }
    print_message("tiles %.0f, estimated %.0f; clusters %.0f, estimated %.0f\n", all.tiles, sampled.tiles, all.clusters,
                  sampled.clusters);
    const double pairs[][2] = {
        {all.in_view, sampled.in_view}, {all.tiles, sampled.tiles}, {all.slices, sampled.slices}, {all.clusters, sampled.clusters}};
    for (uint32_t k = 0; k < COUNT_OF(pairs); k++)
        assert_true(pairs[k][1] >= pairs[k][0] && pairs[k][1] <= 2.5 * pairs[k][0]);
    free(lights);
}

/* ---- work of a dispatch ---- */

/* Dispatches under a label, of which none has more than `most` of the work of so much a group; so many groups they have together. */
static uint32_t check_dispatches(const char *label, uint64_t group_work, uint64_t most, uint64_t groups) {
    uint32_t count = 0;
    uint64_t sum = 0;
    for (uint32_t i = 0; i < spy.work_count; i++) {
        const struct spy_work *work = &spy.work[i];
        if (strcmp(work->label, label) != 0) continue;
        uint64_t here = (uint64_t)work->count[0] * work->count[1] * work->count[2];
        assert_true(here * group_work <= most);
        sum += here;
        count++;
    }
    assert_int_equal(sum, groups);
    return count;
}

/* Testing many lights against cells, or lights against many cells, takes several dispatches, and finds what a tree finds. */
static void test_tests_of_a_dispatch_are_bounded(void **state) {
    UNUSED(state);
    enum { LIGHTS = 120000 };
    fnl_light_params *params = calloc(LIGHTS, sizeof *params);
    struct list_light *lights = calloc(LIGHTS, sizeof *lights);
    assert_non_null(params);
    assert_non_null(lights);
    struct random_state random = {10};
    struct gpu_view view = list_random_view(0, &random, 640, 360);
    list_random_lights(&view, &random, LIGHTS, params, lights);
    for (uint32_t i = 0; i < LIGHTS; i++) {
        params[i].range = 0.02f * vec3_distance(params[i].position, view.eye);
        lights[i] = list_light_of(&params[i], i);
    }
    struct list_request r = {.builder = LIST_CLUSTERED,
                             .view = view,
                             .lights = lights,
                             .light_count = LIGHTS,
                             .tiled = tiled_params_default(),
                             .clustered = clustered_params_default()};
    for (int few = 0; few < 2; few++) {
        if (few) r.light_count = CELL_CHUNK;
        r.clustered.tile_size = few ? 8 : 32;
        r.clustered.slices = few ? 80 : 8;
        r.builder = LIST_CLUSTERED;
        spy_begin(harness_device());
        spy_clear();
        struct list_copy flat = list_build(&r);
        const uint32_t chunk = few ? CELL_CHUNK : CELL_MARKED_CHUNK, chunks = DIVIDE_UP(r.light_count, chunk);
        uint64_t groups = DIVIDE_UP(flat.cell_count + 1, 64u) * (uint64_t)chunks;
        assert_true(check_dispatches("clustered count", 64ull * chunk, 1ull << 26, groups) > 1);
        groups = DIVIDE_UP(flat.cell_count, 64u) * (uint64_t)chunks;
        assert_true(check_dispatches("clustered fill", 64ull * chunk, 1ull << 26, groups) > 1);
        const uint32_t blocks = DIVIDE_UP(20u, 2u) * DIVIDE_UP(12u, 2u) * DIVIDE_UP(8u, CELLS_BLOCK_SLICES);
        uint32_t marking = check_dispatches("clustered mark", 64ull * chunk, 1ull << 26, few ? 0 : DIVIDE_UP(blocks, 64u) * (uint64_t)chunks);
        assert_int_equal(marking, few ? 0 : 1);
        spy_end();
        r.builder = LIST_BVH;
        struct list_copy tree = list_build(&r);
        print_message("%u lights, %u in view, %u cells: %u entries, %u cells overflow\n", r.light_count, flat.totals.in_view,
                      flat.cell_count, flat.totals.entries, flat.totals.overflow_cells);
        /* Those in view are more than the first dispatch takes, or a cell of the second one has some. */
        assert_true(flat.totals.entries > flat.totals.in_view && (few || flat.totals.in_view > 36000));
        assert_true(list_equal(&flat, &tree));
        list_free(&flat);
        list_free(&tree);
    }
    free(params);
    free(lights);
}

/* Deferred shading of so many pixels with so many lights takes several dispatches, each of some rows: not a bit changes. */
static void check_bands(struct stage *stage) {
    fnl_frame frame = stage->frame;
    frame.width = 96;
    frame.height = 54;
    frame.shading = FNL_SHADING_DEFERRED;
    frame.lists = FNL_LISTS_WORLD; /* visits few */
    frame.record_threads = 1;
    spy_begin(harness_device());
    spy_clear();
    struct shot bands = stage_shoot(stage, &frame);
    uint64_t lights = stage->scene->lights.count;
    uint32_t count = check_dispatches("deferred", 64 * lights, 1ull << 32, 12 * 7);
    spy_end();
    assert_true(count > 1);
    frame.deferred.class_blocks = 8; /* indirect dispatches of all blocks of a class */
    struct shot blocks = stage_shoot(stage, &frame);
    assert_int_equal(count_differing(&bands.radiance, &blocks.radiance), 0);
    shot_free(&bands);
    shot_free(&blocks);
}

/* ---- very many lights ---- */

struct many {
    uint64_t evaluations;
    struct shot shot;
};

/* The first frame of a kind has room for all. */
static struct many shoot_many(struct stage *stage, fnl_shading shading, fnl_light_lists lists) {
    fnl_frame frame = stage->frame;
    frame.shading = shading;
    frame.lists = lists;
    frame.count_lights = true;
    struct many many = {.shot = stage_shoot(stage, &frame)};
    const fnl_frame_stats *stats = &many.shot.stats;
    if (stats->overflow_cells)
        fail_msg("%s lists of %u lights: %u cells overflow in the first frame, %llu entries", fnl_value_name(FNL_ENUM_LISTS, lists),
                 stats->lights_total, stats->overflow_cells, (unsigned long long)stats->list_entries);
    many.evaluations = stats->evaluations;
    return many;
}

/* Every other kind, and those whose pools fill first. */
static void check_many(const char *scene, uint32_t phase) {
    enum { FEW, MANY };
    static const uint32_t counts[] = {16384, 1048576};
    struct stage stages[2];
    struct many all[2][2] = {0}; /* of objects or not */
    for (int n = FEW; n <= MANY; n++) {
        char source[64];
        snprintf(source, sizeof source, "builtin:%slights=%u", scene, counts[n]);
        stages[n] = stage_open(source, 0);
        stages[n].frame.width = 16;
        stages[n].frame.height = 9;
        stages[n].frame.ev = 0;
        all[n][0] = shoot_many(&stages[n], FNL_SHADING_DEFERRED, FNL_LISTS_ALL);
        if (FNL_LISTS_MESH % 2 == phase) all[n][1] = shoot_many(&stages[n], FNL_SHADING_FORWARD_PREPASS, FNL_LISTS_ALL);
    }
    for (uint32_t l = FNL_LISTS_TILED; l < FNL_LISTS_COUNT; l++) {
        fnl_light_lists lists = (fnl_light_lists)l;
        fnl_shading shading = needs_items(lists) ? FNL_SHADING_FORWARD_PREPASS : FNL_SHADING_DEFERRED;
        if (lists == FNL_LISTS_AUTO || lists == FNL_LISTS_MULTIPASS || lists == FNL_LISTS_BATCHES) continue;
        if (l % 2 != phase && lists != FNL_LISTS_ZBIN && lists != FNL_LISTS_ENHANCED) continue;
        struct many built[2];
        for (int n = FEW; n <= MANY; n++) {
            built[n] = shoot_many(&stages[n], shading, lists);
            assert_int_equal(count_differing(&all[n][needs_items(lists)].shot.radiance, &built[n].shot.radiance), 0);
            shot_free(&built[n].shot);
        }
        double parts[2];
        for (int n = FEW; n <= MANY; n++)
            parts[n] = (double)built[n].evaluations / (double)all[n][needs_items(lists)].evaluations;
        print_message("%s, %s: %.4f and %.4f of what all visit\n", scene, fnl_value_name(FNL_ENUM_LISTS, lists), parts[FEW], parts[MANY]);
        assert_true(parts[MANY] <= 1.05 * parts[FEW]);
    }
    if (phase) check_bands(&stages[MANY]);
    for (int n = FEW; n <= MANY; n++) {
        for (int k = 0; k < 2; k++) shot_free(&all[n][k].shot);
        stage_close(&stages[n]);
    }
}

static void test_a_million_lights_in_the_city(void **state) {
    UNUSED(state);
    check_many("city?blocks=1&", 0);
}

static void test_a_million_lights_in_the_hall(void **state) {
    UNUSED(state);
    check_many("hall?", 1);
}

/* ---- cells that overflow ---- */

/* With room for next to nothing, pixels visit the lights of their hundredth of the screen, not all: the picture is the same. */
static void test_overflow_visits_few(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:city?blocks=1&lights=16384", 0);
    stage.frame.width = 96;
    stage.frame.height = 54;
    stage.frame.count_lights = true;
    uint64_t pixels = (uint64_t)stage.frame.width * stage.frame.height;
    for (int forward = 0; forward < 2; forward++) {
        fnl_frame frame = stage.frame;
        frame.shading = forward ? FNL_SHADING_FORWARD_PREPASS : FNL_SHADING_DEFERRED;
        frame.lists = FNL_LISTS_ALL;
        struct shot all = stage_shoot(&stage, &frame);
        for (uint32_t l = FNL_LISTS_TILED; l < FNL_LISTS_AUTO; l++) {
            frame.lists = (fnl_light_lists)l;
            if (!has_pool(frame.lists) || needs_items(frame.lists) != forward) continue;
            harness_set_pool(&stage, 4);
            struct shot over = stage_shoot(&stage, &frame);
            print_message("%s: %u of %u cells overflow, %llu of %llu points, %.4f of what all visit\n",
                          fnl_value_name(FNL_ENUM_LISTS, frame.lists), over.stats.overflow_cells, over.stats.cells,
                          (unsigned long long)over.stats.unserved_points, (unsigned long long)pixels,
                          (double)over.stats.evaluations / (double)all.stats.evaluations);
            assert_int_equal(count_differing(&all.radiance, &over.radiance), 0);
            assert_true(over.stats.overflow_cells > 0);
            assert_true(over.stats.unserved_points * 2 > pixels);
            assert_true(over.stats.evaluations * 12 < all.stats.evaluations);
            shot_free(&over);
        }
        shot_free(&all);
    }
    stage_close(&stage);
}

/* ---- points off the surfaces that depth shows ---- */

/* With several samples some points lie off what their cell was made for; with one sample none does. They are few, and lose no light. */
static void test_unserved_points_are_few(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:city?blocks=1&lights=1024", 0);
    fnl_frame frame = stage.frame;
    frame.width = 96;
    frame.height = 54;
    frame.shading = FNL_SHADING_FORWARD_PREPASS;
    frame.count_lights = true;
    for (uint32_t msaa = 1; msaa <= 4; msaa += 3) {
        uint64_t unseen = 0; /* points out of the view, which no list serves */
        frame.msaa = msaa;
        frame.lists = FNL_LISTS_ALL;
        struct shot all = stage_shoot(&stage, &frame);
        for (uint32_t l = FNL_LISTS_TILED; l < FNL_LISTS_AUTO; l++) {
            frame.lists = (fnl_light_lists)l;
            if (l == FNL_LISTS_MULTIPASS || l == FNL_LISTS_BATCHES) continue;
            struct shot shot = stage_shoot(&stage, &frame);
            assert_int_equal(shot.stats.overflow_cells, 0);
            if (shot.stats.unserved_points)
                print_message("%s: %llu points without a cell, %.4f of what all visit\n", fnl_value_name(FNL_ENUM_LISTS, frame.lists),
                              (unsigned long long)shot.stats.unserved_points,
                              (double)shot.stats.evaluations / (double)all.stats.evaluations);
            uint64_t differing = count_differing(&all.radiance, &shot.radiance);
            if (differing)
                fail_msg("%s, %u samples: %llu pixels differ", fnl_value_name(FNL_ENUM_LISTS, frame.lists), msaa,
                         (unsigned long long)differing);
            bool by_depth = l == FNL_LISTS_TILED || l == FNL_LISTS_HALFZ || l == FNL_LISTS_25D || l == FNL_LISTS_BACKFACE;
            if (msaa == 1 && l != FNL_LISTS_FINE && l != FNL_LISTS_SPARSE) assert_int_equal(shot.stats.unserved_points, 0);
            if (l == FNL_LISTS_CLUSTERED) unseen = shot.stats.unserved_points;
            if (msaa > 1 && by_depth && unseen) assert_true(shot.stats.unserved_points > unseen);
            /* Objects are smaller than pixels here, and Mesa's CPU driver shades beside them where lights are counted. */
            if (unseen && l != FNL_LISTS_MESH) assert_true(shot.stats.unserved_points < unseen + frame.width * frame.height / 8);
            shot_free(&shot);
        }
        shot_free(&all);
    }
    stage_close(&stage);
}

static int spying_check(void **state) {
    spy_tear_down(state);
    return harness_check(state);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_estimates_are_bounds, harness_check),
        cmocka_unit_test_teardown(test_estimates_of_samples, harness_check),
        cmocka_unit_test_teardown(test_unserved_points_are_few, harness_check),
        cmocka_unit_test_teardown(test_overflow_visits_few, harness_check),
        cmocka_unit_test_teardown(test_tests_of_a_dispatch_are_bounded, spying_check),
        cmocka_unit_test_teardown(test_a_million_lights_in_the_city, harness_check),
        cmocka_unit_test_teardown(test_a_million_lights_in_the_hall, spying_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
