/* SPDX-License-Identifier: MIT */
/** The limits of light lists: numbers of lights, pools that overflow, runs that must be equal. */
#include "fanal/options.h"
#include "tests/list_pairs.h"
#include "tests/frame_plain.h"

/* ---- numbers of lights ---- */

static void test_light_counts(void **state) {
    UNUSED(state);
    static const uint32_t counts[] = {0, 1, 255, 256, 257, 4096, 65536};
    for (uint32_t i = 0; i < COUNT_OF(counts); i++) {
        struct stage stage = stage_open("builtin:spheres?lights=0", counts[i]);
        fnl_frame frame = stage.frame;
        frame.width = 39;
        frame.height = 23;
        frame.shading = FNL_SHADING_DEFERRED;
        struct shot shot = pairs_check_lists(&stage, frame, 1, 0);
        assert_int_equal(shot.stats.lights_total, counts[i]);
        shot_free(&shot);
        stage_close(&stage);
    }
}

/* ---- what lists share ---- */

static bool heeds(uint32_t lists, const char *key) {
    fnl_option option = {0};
    assert_true(fnl_option_find(key, &option));
    return option.lists >> lists & 1;
}

/* Cones and rectangles of lights are made for the lists that test them, and for no others; the pictures stay the same. */
static void test_reaches_for_those_who_use_them(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:spheres?lights=60", 0);
    fnl_frame frame = stage.frame;
    frame.width = 65;
    frame.height = 37;
    frame.lists = FNL_LISTS_ALL;
    struct shot all = stage_shoot(&stage, &frame);
    char plan[65536];
    uint32_t with = 0, without = 0;
    for (uint32_t l = FNL_LISTS_TILED; l < FNL_LISTS_AUTO; l++) {
        frame.lists = (fnl_light_lists)l;
        if (!fnl_shading_supports(frame.shading, frame.lists, frame.msaa)) continue;
        for (uint32_t v = 0; v < 3; v++) {
            frame.list = frame_plain().list;
            frame.list.cone_tests = v == 0;
            frame.list.normal_cones = v == 0;
            frame.tiles.bounds = v == 2 ? FNL_TILE_BOUNDS_PROJECTED : FNL_TILE_BOUNDS_BOX;
            bool uses = (v == 0 && heeds(l, "list.cone-tests")) || (v == 2 && heeds(l, "tiles.bounds"));
            struct shot shot = stage_shoot(&stage, &frame);
            assert_int_equal(count_differing(&all.radiance, &shot.radiance), 0);
            assert_true(fnl_renderer_print(stage.renderer, FNL_PRINT_PLAN, plan, sizeof plan) < sizeof plan);
            if ((strstr(plan, "light reaches") != NULL) != uses)
                fail_msg("%s, variant %u: reaches %s", pair_name(&frame), v, uses ? "are missing" : "for nobody");
            with += uses;
            without += !uses && strstr(plan, "lights gather");
            shot_free(&shot);
        }
    }
    assert_true(with >= 10 && without >= 10);
    shot_free(&all);
    stage_close(&stage);
}

/* ---- overflow ---- */

static void check_overflow(struct stage *stage, fnl_frame frame, uint32_t capacity) {
    frame.lists = FNL_LISTS_ALL;
    struct shot all = stage_shoot(stage, &frame);
    for (uint32_t l = FNL_LISTS_TILED; l < FNL_LISTS_COUNT; l++) {
        frame.lists = (fnl_light_lists)l;
        /* These count before they store, and need no pool. */
        if (l == FNL_LISTS_TREE || l == FNL_LISTS_CLUSTERED_CPU || l == FNL_LISTS_GRID2D || l == FNL_LISTS_WORLD) continue;
        if (l == FNL_LISTS_AUTO || !fnl_shading_supports(frame.shading, frame.lists, frame.msaa)) continue;
        uint32_t small = l == FNL_LISTS_ZBIN ? capacity / 40 : capacity; /* entries of z-bins are words of 32 lights */
        harness_set_pool(stage, 1u << 22);
        struct shot fits = stage_shoot(stage, &frame);
        assert_int_equal(fits.stats.overflow_cells, 0);
        if (fits.stats.list_entries <= small) fail_msg("%s: nothing can overflow", pair_name(&frame));
        assert_int_equal(count_differing(&all.radiance, &fits.radiance), 0);

        harness_set_pool(stage, small);
        struct shot over = stage_shoot(stage, &frame);
        if (count_differing(&all.radiance, &over.radiance)) fail_msg("%s differs in overflow", pair_name(&frame));
        if (over.stats.overflow_cells == 0 || over.stats.list_entries != fits.stats.list_entries)
            fail_msg("%s: %u cells overflow, %llu entries instead of %llu", pair_name(&frame), over.stats.overflow_cells,
                     (unsigned long long)over.stats.list_entries, (unsigned long long)fits.stats.list_entries);

        struct shot next = stage_shoot(stage, &frame); /* the pool has grown */
        assert_true(stage->renderer->lists.pool_capacity >= fits.stats.list_entries / 2);
        if (next.stats.overflow_cells) fail_msg("%s: the pool has not grown", pair_name(&frame));
        assert_int_equal(next.stats.list_entries, fits.stats.list_entries);
        assert_int_equal(count_differing(&all.radiance, &next.radiance), 0);
        shot_free(&fits);
        shot_free(&over);
        shot_free(&next);
    }
    shot_free(&all);
}

static void test_overflow_ES_37(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:onetile?lights=1000", 0);
    check_overflow(&stage, stage.frame, 100);
    stage_close(&stage);
    stage = stage_open("builtin:glass?lights=300", 0); /* two lists: opaque and transparent tiles */
    check_overflow(&stage, stage.frame, 100);
    stage_close(&stage);
}

/* Without waiting for stats in between, the pool still grows a few frames later. */
static void test_overflow_in_flight(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:onetile?lights=400", 0);
    stage.frame.lists = FNL_LISTS_TILED;
    harness_set_pool(&stage, 10);
    for (uint32_t i = 0; i <= GPU_FRAMES_IN_FLIGHT; i++)
        assert_int_equal(fnl_renderer_render(stage.renderer, &stage.frame), FNL_OK);
    assert_true(stage.renderer->lists.pool_capacity > 10);
    fnl_frame_stats stats;
    assert_int_equal(fnl_renderer_query_stats(stage.renderer, &stats), FNL_OK);
    assert_int_equal(stats.overflow_cells, 0);
    stage_close(&stage);
}

static void test_4096_lights_in_one_cluster(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:onetile?lights=0", 0);
    for (uint32_t i = 0; i < 4096; i++) {
        fnl_light_params light = fnl_light_params_default();
        fnl_light_id id;
        light.position = (fnl_vec3){0.4f + 1e-5f * (float)i, 0.3f, -19.7f};
        light.range = 0.6f;
        light.intensity = 0.01f;
        assert_int_equal(fnl_scene_add_light(stage.scene, &light, &id), FNL_OK);
    }
    check_overflow(&stage, stage.frame, 4000);
    stage_close(&stage);
}

/* ---- determinism ---- */

static void test_two_runs_and_threads(void **state) {
    UNUSED(state);
    static const fnl_shading orders[] = {FNL_SHADING_FORWARD, FNL_SHADING_FORWARD_PREPASS, FNL_SHADING_DEFERRED};
    struct shot shots[2][COUNT_OF(orders)][FNL_LISTS_COUNT];
    for (uint32_t run = 0; run < 2; run++) {
        struct stage stage = stage_open("builtin:glass?lights=200", 0);
        stage.frame.width = 97;
        stage.frame.height = 55;
        for (uint32_t s = 0; s < COUNT_OF(orders); s++)
            for (uint32_t l = 0; l < FNL_LISTS_COUNT; l++) {
                stage.frame.shading = orders[s];
                stage.frame.lists = (fnl_light_lists)l;
                shots[run][s][l] = (struct shot){0};
                if (!fnl_shading_supports(orders[s], stage.frame.lists, 1)) continue;
                stage.frame.record_threads = run == 0 ? 1 : 4;
                shots[run][s][l] = stage_shoot(&stage, &stage.frame);
            }
        stage_close(&stage);
    }
    for (uint32_t s = 0; s < COUNT_OF(orders); s++)
        for (uint32_t l = 0; l < FNL_LISTS_COUNT; l++) {
            if (!shots[0][s][l].color.pixels) continue;
            assert_int_equal(count_differing(&shots[0][s][l].color, &shots[1][s][l].color), 0);
            assert_int_equal(count_differing(&shots[0][s][l].radiance, &shots[1][s][l].radiance), 0);
            assert_int_equal(shots[0][s][l].stats.list_entries, shots[1][s][l].stats.list_entries);
        }
    for (uint32_t i = 0; i < 2 * COUNT_OF(orders) * FNL_LISTS_COUNT; i++) shot_free(&shots[0][0][0] + i);
}

/* ---- one set of lists for all orders ---- */

static void test_same_lists_forward_and_deferred_ES_58(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:hall?lights=256", 0);
    stage.frame.ev = 3;
    for (uint32_t l = FNL_LISTS_CLUSTERED; l <= FNL_LISTS_CLUSTERED_CPU; l++) {
        stage.frame.lists = (fnl_light_lists)l;
        struct shot shots[FNL_SHADING_DEFERRED + 1];
        for (uint32_t s = 0; s < FNL_SHADING_DEFERRED + 1; s++) {
            stage.frame.shading = (fnl_shading)s;
            shots[s] = stage_shoot(&stage, &stage.frame);
            assert_true(shots[s].stats.list_entries > 100);
            assert_int_equal(shots[s].stats.list_entries, shots[0].stats.list_entries);
            assert_int_equal(shots[s].stats.lights_in_view, shots[0].stats.lights_in_view);
            assert_int_equal(shots[s].stats.cells, shots[0].stats.cells);
            assert_true(greatest_difference(&shots[0].color, &shots[s].color) <= PAIRS_ALLOWED);
        }
        for (uint32_t s = 0; s < FNL_SHADING_DEFERRED + 1; s++) shot_free(&shots[s]);
    }
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_light_counts, harness_check),
        cmocka_unit_test_teardown(test_reaches_for_those_who_use_them, harness_check),
        cmocka_unit_test_teardown(test_overflow_ES_37, harness_check),
        cmocka_unit_test_teardown(test_overflow_in_flight, harness_check),
        cmocka_unit_test_teardown(test_4096_lights_in_one_cluster, harness_check),
        cmocka_unit_test_teardown(test_two_runs_and_threads, harness_check),
        cmocka_unit_test_teardown(test_same_lists_forward_and_deferred_ES_58, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
