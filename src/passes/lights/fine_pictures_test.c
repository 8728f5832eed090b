/* SPDX-License-Identifier: MIT */
/** Whole frames by fine-pruned tiles. */
#include "tests/fine_bench.h"
#include "tests/frame_plain.h"

/* ---- pictures ---- */

static struct shot shoot(struct stage *stage, fnl_shading shading, fnl_light_lists lists, uint32_t msaa,
                         const fnl_frame *options) {
    fnl_frame frame = stage->frame;
    frame.width = 97;
    frame.height = 61;
    frame.shading = shading;
    frame.lists = lists;
    frame.msaa = msaa;
    frame.count_lights = true;
    frame.list = options->list;
    frame.fine = options->fine;
    frame.tiles = options->tiles;
    return stage_shoot(stage, &frame);
}

/* More lights in a tile than the count keeps masks for, behind directional ones in the array of lights. */
static void test_pictures_beside_suns(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:spheres", 150);
    const fnl_frame options = frame_plain();
    for (uint32_t i = 0; i < 3; i++) {
        fnl_light_params sun = fnl_light_params_default();
        fnl_light_id id;
        sun.kind = FNL_LIGHT_DIRECTIONAL;
        assert_int_equal(fnl_scene_add_light(stage.scene, &sun, &id), FNL_OK);
    }
    struct shot all = shoot(&stage, FNL_SHADING_DEFERRED, FNL_LISTS_ALL, 1, &options);
    struct shot fine = shoot(&stage, FNL_SHADING_DEFERRED, FNL_LISTS_FINE, 1, &options);
    assert_int_equal(count_differing(&all.radiance, &fine.radiance), 0);
    assert_int_equal(fine.stats.evaluations_useful, all.stats.evaluations_useful);
    shot_free(&all);
    shot_free(&fine);
    stage_close(&stage);
}

/* Pruned, in other ways and brute force are equal to the bit: each shape alone in two ways; mixed in all, then with samples and in a draw too. */
static void test_pictures_FP_1(void **state) {
    UNUSED(state);
    for (uint32_t kind = FNL_LIGHT_POINT; kind <= FNL_LIGHT_KIND_COUNT; kind++) {
        struct stage stage = stage_open("builtin:glass?lights=0", 0);
        fnl_scatter_params scatter = fnl_scatter_params_default();
        scatter.count = 80;
        for (uint32_t k = FNL_LIGHT_POINT; k < FNL_LIGHT_KIND_COUNT; k++)
            scatter.shares[k] = kind == FNL_LIGHT_KIND_COUNT || kind == k ? 1 : 0;
        assert_int_equal(fnl_scene_scatter_light_shapes(stage.scene, &scatter), FNL_OK);
        static const struct {
            fnl_shading shading;
            uint32_t msaa;
        } orders[] = {{FNL_SHADING_DEFERRED, 1}, {FNL_SHADING_FORWARD_PREPASS, 4}, {FNL_SHADING_FORWARD_PREPASS, 1}};
        for (uint32_t o = 0; o < (kind == FNL_LIGHT_KIND_COUNT ? COUNT_OF(orders) : 1); o++) {
            fnl_frame options = frame_plain();
            struct shot all = shoot(&stage, orders[o].shading, FNL_LISTS_ALL, orders[o].msaa, &options);
            assert_true(all.stats.evaluations_useful > 1000);
            static const uint32_t variants[] = {7, 2, 3}; /* of each order */
            for (uint32_t v = 0; v < variants[o]; v++) {
                if (kind < FNL_LIGHT_KIND_COUNT && v > 0 && v != kind - FNL_LIGHT_POINT + 1) continue;
                options.fine.pruning = v != 1 && v != 6;
                options.fine.masks = v == 3 ? 0 : v == 4 ? 2 : 1;
                options.fine.packed = v == 2 || v == 6;
                options.tiles.size = v == 4 ? 32 : v == 5 ? 8 : 16;
                struct shot fine = shoot(&stage, orders[o].shading, FNL_LISTS_FINE, orders[o].msaa, &options);
                if (count_differing(&all.radiance, &fine.radiance))
                    fail_msg("shape %u, %s, %u samples, variant %u: %llu pixels differ", kind,
                             fnl_value_name(FNL_ENUM_SHADING, orders[o].shading), orders[o].msaa, v,
                             (unsigned long long)count_differing(&all.radiance, &fine.radiance));
                assert_int_equal(fine.stats.evaluations_useful, all.stats.evaluations_useful);
                shot_free(&fine);
            }
            shot_free(&all);
        }
        stage_close(&stage);
    }
}

/* With MSAA a surface that covers a pixel in part may be shaded far off along its plane, in another tile. */
static void test_partly_covered_pixels_FP_1(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:hall?lights=1024", 0);
    stage.frame.msaa = 4;
    for (uint32_t s = FNL_SHADING_FORWARD; s <= FNL_SHADING_FORWARD_PREPASS; s++) {
        stage.frame.shading = (fnl_shading)s;
        stage.frame.lists = FNL_LISTS_ALL;
        struct shot all = stage_shoot(&stage, &stage.frame);
        stage.frame.lists = FNL_LISTS_FINE;
        struct shot fine = stage_shoot(&stage, &stage.frame);
        assert_int_equal(count_differing(&all.radiance, &fine.radiance), 0);
        shot_free(&all);
        shot_free(&fine);
    }
    stage_close(&stage);
}

/* Packed: more lights than fit, in a tile or in view, and MSAA; what fits costs as many evaluations as without masks. */
static void test_packed_pictures_FP_9_FP_10(void **state) {
    UNUSED(state);
    static const struct {
        fnl_shading shading;
        uint32_t msaa, lights;
    } cases[] = {{FNL_SHADING_DEFERRED, 1, 30},
                 {FNL_SHADING_DEFERRED, 1, 300},
                 {FNL_SHADING_DEFERRED, 1, 1100},
                 {FNL_SHADING_FORWARD, 4, 300},
                 {FNL_SHADING_FORWARD_PREPASS, 4, 300}};
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        struct stage stage = stage_open("builtin:glass?lights=0", cases[i].lights);
        fnl_frame options = frame_plain();
        struct shot all = shoot(&stage, cases[i].shading, FNL_LISTS_ALL, cases[i].msaa, &options);
        options.fine.masks = 0;
        options.list.frustum_cull = cases[i].lights < 1024; /* or all count as in view */
        struct shot plain = shoot(&stage, cases[i].shading, FNL_LISTS_FINE, cases[i].msaa, &options);
        options.fine.packed = true;
        struct shot packed = shoot(&stage, cases[i].shading, FNL_LISTS_FINE, cases[i].msaa, &options);
        if (count_differing(&all.radiance, &packed.radiance))
            fail_msg("case %u: %llu pixels differ", i, (unsigned long long)count_differing(&all.radiance, &packed.radiance));
        assert_int_equal(packed.stats.list_entries, plain.stats.list_entries);
        assert_true(cases[i].lights < 1024 || packed.stats.lights_in_view > 1024);
        assert_true((packed.stats.overflow_cells > 0) == (cases[i].lights > 30));
        assert_true(packed.stats.evaluations >= plain.stats.evaluations &&
                    packed.stats.evaluations <= all.stats.evaluations);
        if (cases[i].lights == 30) {
            assert_int_equal(packed.stats.evaluations, plain.stats.evaluations);
            assert_int_equal(packed.stats.list_bytes, 7 * 4 * 32 * 2); /* opaque and blended */
            assert_int_equal(packed.stats.list_used_bytes, packed.stats.list_bytes);
        }
        shot_free(&all);
        shot_free(&plain);
        shot_free(&packed);
        stage_close(&stage);
    }
}

/* A pixel visits hardly more lights than reach it: without blended surfaces, none but those within the slack. */
static void test_evaluations(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:spheres?lights=400", 0);
    fnl_frame options = frame_plain();
    struct shot pixels = shoot(&stage, FNL_SHADING_DEFERRED, FNL_LISTS_FINE, 1, &options);
    assert_true((double)pixels.stats.evaluations <= 1.01 * (double)pixels.stats.evaluations_useful);
    options.fine.masks = 2;
    struct shot quads = shoot(&stage, FNL_SHADING_DEFERRED, FNL_LISTS_FINE, 1, &options);
    options.fine.masks = 0;
    struct shot tiles = shoot(&stage, FNL_SHADING_DEFERRED, FNL_LISTS_FINE, 1, &options);
    options.fine.pruning = false;
    struct shot boxes = shoot(&stage, FNL_SHADING_DEFERRED, FNL_LISTS_FINE, 1, &options);
    assert_true(pixels.stats.evaluations < quads.stats.evaluations && quads.stats.evaluations < tiles.stats.evaluations &&
                tiles.stats.evaluations < boxes.stats.evaluations);
    const fnl_frame usual = frame_plain();
    struct shot prepass = shoot(&stage, FNL_SHADING_FORWARD_PREPASS, FNL_LISTS_FINE, 1, &usual);
    assert_true((double)prepass.stats.evaluations <=
                1.02 * (double)prepass.stats.evaluations_useful); /* positions are near enough */
    print_message("evaluations that reach the surface: 1; by pixels %.3f, quads %.3f, tiles %.3f, boxes %.3f; interpolated "
                  "positions %.3f\n",
                  (double)pixels.stats.evaluations / (double)pixels.stats.evaluations_useful,
                  (double)quads.stats.evaluations / (double)quads.stats.evaluations_useful,
                  (double)tiles.stats.evaluations / (double)tiles.stats.evaluations_useful,
                  (double)boxes.stats.evaluations / (double)boxes.stats.evaluations_useful,
                  (double)prepass.stats.evaluations / (double)prepass.stats.evaluations_useful);
    shot_free(&pixels);
    shot_free(&quads);
    shot_free(&tiles);
    shot_free(&boxes);
    shot_free(&prepass);
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_pictures_beside_suns, harness_check),
        cmocka_unit_test_teardown(test_pictures_FP_1, harness_check),
        cmocka_unit_test_teardown(test_partly_covered_pixels_FP_1, harness_check),
        cmocka_unit_test_teardown(test_packed_pictures_FP_9_FP_10, harness_check),
        cmocka_unit_test_teardown(test_evaluations, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
