/* SPDX-License-Identifier: MIT */
/** Orders that write lights into pixels, light-indexed and zioma, against forward shading. */
#include "tests/order_cases.h"

/*
 * Every packing gives the very bits of forward shading: the same loop over lights, ascending, without those that reach nothing. Without `all` the packings
 * after the first are tried with four layers only: what is special about the stage then meets little and much room in the first one.
 */
static void check_packings(struct stage *stage, const char *what, bool all) {
    struct shot forward = order_shoot(stage, FNL_SHADING_FORWARD_PREPASS, FNL_LISTS_ALL);
    for (int p = 0; p < FNL_LIGHT_PACKING_COUNT; p++)
        for (uint32_t layers = 1; layers <= 16; layers *= 4) { /* few pixels, some, and most have room */
            if (!all && layers != 4 && p != FNL_LIGHT_PACKING_IDS) continue;
            stage->frame.light_indexed.packing = (fnl_light_packing)p;
            stage->frame.light_indexed.layers = layers;
            struct shot shot = order_shoot(stage, FNL_SHADING_LIGHT_INDEXED, FNL_LISTS_ALL);
            if (layers == 4 || shot.stats.overflow_cells)
                print_message("  %s, %s, %u layers: %llu of %llu evaluations, %u pixels full\n", what,
                              fnl_value_name(FNL_ENUM_LIGHT_PACKING, (fnl_light_packing)p), layers,
                              (unsigned long long)shot.stats.evaluations, (unsigned long long)forward.stats.evaluations,
                              shot.stats.overflow_cells);
            if (count_differing(&forward.radiance, &shot.radiance))
                fail_msg("%s, %s, %u layers: %llu pixels differ", what, fnl_value_name(FNL_ENUM_LIGHT_PACKING, (fnl_light_packing)p), layers,
                         (unsigned long long)count_differing(&forward.radiance, &shot.radiance));
            assert_int_equal(shot.stats.evaluations_useful, forward.stats.evaluations_useful);
            assert_true(shot.stats.evaluations <= forward.stats.evaluations);
            shot_free(&shot);
            if (layers != 4 || (!all && p != FNL_LIGHT_PACKING_IDS)) continue;
            struct shot again = order_shoot(stage, FNL_SHADING_LIGHT_INDEXED, FNL_LISTS_TILED);
            assert_int_equal(count_differing(&forward.radiance, &again.radiance), 0);
            shot_free(&again);
        }
    stage->frame.light_indexed.packing = FNL_LIGHT_PACKING_IDS;
    stage->frame.light_indexed.layers = 4;
    shot_free(&forward);
}

static void check_scene(struct stage *stage, const char *what) { check_packings(stage, what, true); }
static void check_camera(struct stage *stage, const char *what) { check_packings(stage, what, false); }

static void test_indexed_equal(void **state) {
    UNUSED(state);
    order_scenes(check_scene);
    order_cameras(check_camera);
}

/* Lights round one point before a wall, all of them on its pixels. */
static struct stage wall_with(uint32_t count, uint32_t others) {
    struct stage stage = stage_open("builtin:wall?test=1&lights=0", 0);
    struct random_state random = {9};
    for (uint32_t i = 0; i < count + others; i++) {
        fnl_light_params light = fnl_light_params_default();
        fnl_light_id id;
        light.position = (fnl_vec3){random_range(&random, -0.5f, 0.5f), 9, -19};
        if (i < others) light.position = (fnl_vec3){0, -1000, 1000 + (float)i}; /* in numbers alone */
        light.range = 6;
        for (int k = 0; k < 3; k++) light.color[k] = random_range(&random, 0.2f, 1);
        assert_int_equal(fnl_scene_add_light(stage.scene, &light, &id), FNL_OK);
    }
    stage.frame.width = 120;
    stage.frame.height = 68;
    stage.frame.list.frustum_cull = false; /* so that ranks go up with the index */
    return stage;
}

/* Four lights on one another decode exactly with one layer, whatever their ids; the fifth makes pixels fall back, and is not lost. */
static void test_overlaps(void **state) {
    UNUSED(state);
    static const uint32_t others[] = {0, 100, 251, 300};
    for (uint32_t o = 0; o < COUNT_OF(others); o++)
        for (uint32_t count = 1; count <= 5; count++) {
            struct stage stage = wall_with(count, others[o]);
            struct shot forward = order_shoot(&stage, FNL_SHADING_FORWARD_PREPASS, FNL_LISTS_ALL);
            for (int p = 0; p < FNL_LIGHT_PACKING_COUNT; p++) {
                stage.frame.light_indexed.packing = (fnl_light_packing)p;
                bool eight_bits = p != FNL_LIGHT_PACKING_IDS && p != FNL_LIGHT_PACKING_SETS;
                stage.frame.light_indexed.layers = eight_bits && others[o] > 251 ? 2 : 1;
                struct shot shot = order_shoot(&stage, FNL_SHADING_LIGHT_INDEXED, FNL_LISTS_ALL);
                assert_int_equal(count_differing(&forward.radiance, &shot.radiance), 0);
                assert_int_equal(shot.stats.overflow_cells > 0, count > 4);
                if (p == FNL_LIGHT_PACKING_SETS && others[o] == 0) assert_int_equal(counter(&shot.stats, "light-indexed.unplaced"), count > 4);
                if (count <= 4)
                    assert_true(shot.stats.evaluations <= count * (uint64_t)(stage.frame.width * stage.frame.height));
                shot_free(&shot);
            }
            shot_free(&forward);
            stage_close(&stage);
        }
}

/* Lights that no layer is for are not lost either. */
static void test_more_lights_than_ids(void **state) {
    UNUSED(state);
    struct stage stage = wall_with(3, 600);
    struct shot forward = order_shoot(&stage, FNL_SHADING_FORWARD_PREPASS, FNL_LISTS_ALL);
    for (int p = FNL_LIGHT_PACKING_SHIFT; p <= FNL_LIGHT_PACKING_STENCIL; p++)
        for (uint32_t layers = 1; layers <= 3; layers++) {
            stage.frame.light_indexed.packing = (fnl_light_packing)p;
            stage.frame.light_indexed.layers = layers;
            struct shot shot = order_shoot(&stage, FNL_SHADING_LIGHT_INDEXED, FNL_LISTS_ALL);
            assert_int_equal(count_differing(&forward.radiance, &shot.radiance), 0);
            assert_int_equal(shot.stats.overflow_cells > 0, layers < 3);
            shot_free(&shot);
        }
    shot_free(&forward);
    stage_close(&stage);
}

/* Lights apart before a wall fit into one set; with sets for fewer lights than there are, pixels of the others visit all. */
static void test_sets(void **state) {
    UNUSED(state);
    struct stage stage = wall_with(0, 0);
    for (uint32_t i = 0; i < 1200; i++) { /* a grid, none of which meet */
        fnl_light_params light = fnl_light_params_default();
        fnl_light_id id;
        light.position = (fnl_vec3){-12 + 0.6f * (float)(i % 40), 1 + 0.5f * (float)(i / 40), -19.9f};
        light.range = 0.24f;
        assert_int_equal(fnl_scene_add_light(stage.scene, &light, &id), FNL_OK);
    }
    struct shot forward = order_shoot(&stage, FNL_SHADING_FORWARD_PREPASS, FNL_LISTS_ALL);
    stage.frame.light_indexed.packing = FNL_LIGHT_PACKING_SETS;
    for (uint32_t layers = 1; layers <= 2; layers++) {
        stage.frame.light_indexed.layers = layers;
        struct shot shot = order_shoot(&stage, FNL_SHADING_LIGHT_INDEXED, FNL_LISTS_ALL);
        assert_int_equal(count_differing(&forward.radiance, &shot.radiance), 0);
        assert_int_equal(shot.stats.overflow_cells > 0, layers == 1);
        assert_int_equal(counter(&shot.stats, "light-indexed.unplaced"), layers == 1 ? 1200 - 4 * 255 : 0);
        if (layers == 2) assert_true(shot.stats.evaluations <= (uint64_t)(stage.frame.width * stage.frame.height));
        shot_free(&shot);
    }
    shot_free(&forward);
    stage_close(&stage);
}

/* ---- zioma ---- */

static void check_layers(struct stage *stage, const char *what) {
    struct shot forward = order_shoot(stage, FNL_SHADING_FORWARD_PREPASS, FNL_LISTS_ALL);
    for (uint32_t layers = 1; layers <= 8; layers = layers == 1 ? 3 : layers + 5) {
        stage->frame.light_indexed.layers = layers;
        struct shot shot = order_shoot(stage, FNL_SHADING_ZIOMA, FNL_LISTS_ALL);
        int difference = greatest_difference(&forward.color, &shot.color);
        print_message("  %s, %u layers: %d/255, %u pixels have more\n", what, layers, difference, shot.stats.overflow_cells);
        assert_int_equal(count_broken(&shot.radiance), 0);
        assert_true(difference <= 2);
        if (layers == 3) {
            struct shot again = order_shoot(stage, FNL_SHADING_ZIOMA, FNL_LISTS_TILED);
            assert_int_equal(count_differing(&shot.radiance, &again.radiance), 0);
            shot_free(&again);
        }
        shot_free(&shot);
    }
    stage->frame.light_indexed.layers = 4;
    shot_free(&forward);
}

static void test_layers_equal(void **state) {
    UNUSED(state);
    order_scenes(check_layers);
    order_cameras(check_layers);
}

/* Where five lights overlap: with five layers no pixel has more, with four all that five reach do, and no picture changes. */
static void test_layer_counts(void **state) {
    UNUSED(state);
    struct stage stage = wall_with(5, 20);
    struct shot forward = order_shoot(&stage, FNL_SHADING_FORWARD_PREPASS, FNL_LISTS_ALL);
    uint32_t before = UINT32_MAX;
    for (uint32_t layers = 1; layers <= 6; layers++) {
        stage.frame.light_indexed.layers = layers;
        struct shot shot = order_shoot(&stage, FNL_SHADING_ZIOMA, FNL_LISTS_ALL);
        print_message("  %u layers: %u pixels have more, %llu lights reach pixels\n", layers, shot.stats.overflow_cells,
                      (unsigned long long)shot.stats.list_entries);
        assert_true(greatest_difference(&forward.color, &shot.color) <= 1);
        assert_true(shot.stats.overflow_cells <= before);
        assert_int_equal(shot.stats.overflow_cells > 0, layers < 5);
        /* by a few at the rims: layers ask for the point that depth gives, forward shading for the one that is drawn */
        uint64_t useful = forward.stats.evaluations_useful, got = shot.stats.list_entries;
        assert_true(got + got / 500 >= useful && got <= useful + useful / 500);
        before = shot.stats.overflow_cells;
        shot_free(&shot);
    }
    shot_free(&forward);
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        {"ES-26: light-indexed has the bits of forward shading", test_indexed_equal, NULL, harness_check, NULL},
        {"ES-26: four overlapping ids decode exactly, a fifth is not lost", test_overlaps, NULL, harness_check, NULL},
        {"ES-26: nor are lights without an id", test_more_lights_than_ids, NULL, harness_check, NULL},
        {"ES-26: sets of lights hold 255 each", test_sets, NULL, harness_check, NULL},
        {"ES-25: zioma equals forward shading, with room and without", test_layers_equal, NULL, harness_check, NULL},
        {"ES-25: overlaps beyond the layers are counted", test_layer_counts, NULL, harness_check, NULL},
    };
    return cmocka_run_group_tests_name("lights written into pixels", tests, harness_begin, harness_end);
}
