/* SPDX-License-Identifier: MIT */
/** Inferred lighting: how close it is to deferred shading, its lists, its glass. */
#include "tests/msaa_cases.h"
#include "tests/order_cases.h"

/* Every list gives the bits of `all`, also for what is stippled; nothing breaks, whatever the size. */
static void check_own_reference(struct stage *stage, const char *what) {
    static const fnl_light_lists lists[] = {FNL_LISTS_TILED,  FNL_LISTS_FINE,      FNL_LISTS_BACKFACE,
                                            FNL_LISTS_SPARSE, FNL_LISTS_CLUSTERED, FNL_LISTS_CLUSTERED_CPU};
    for (uint32_t scale = 2; scale <= 4; scale *= 2) {
        stage->frame.light_buffer.scale = scale;
        struct shot all = order_shoot(stage, FNL_SHADING_INFERRED, FNL_LISTS_ALL);
        struct shot deferred = order_shoot(stage, FNL_SHADING_DEFERRED, FNL_LISTS_ALL);
        print_message("  %s, 1/%u: %.1f dB, %llu of %llu evaluations\n", what, scale,
                      order_psnr(&all.color, &deferred.color), (unsigned long long)all.stats.evaluations,
                      (unsigned long long)deferred.stats.evaluations);
        assert_int_equal(count_broken(&all.radiance), 0);
        for (uint32_t i = 0; i < COUNT_OF(lists); i++) {
            struct shot shot = order_shoot(stage, FNL_SHADING_INFERRED, lists[i]);
            if (count_differing(&all.radiance, &shot.radiance))
                fail_msg("%s, 1/%u: %s differs from all at %llu pixels", what, scale, fnl_value_name(FNL_ENUM_LISTS, lists[i]),
                         (unsigned long long)count_differing(&all.radiance, &shot.radiance));
            shot_free(&shot);
        }
        shot_free(&all);
        shot_free(&deferred);
    }
    stage->frame.light_buffer.scale = 2;
}

static void test_lists(void **state) {
    UNUSED(state);
    order_cameras(check_own_reference);
    static const char *const sources[] = {"builtin:glass?lights=40", "builtin:sky", "builtin:spheres?lights=0"};
    for (uint32_t i = 0; i < COUNT_OF(sources); i++) {
        struct stage stage = stage_open(sources[i], 0);
        check_own_reference(&stage, sources[i]);
        stage_close(&stage);
    }
}

/* Pixels that no texel suits go through clusters. Too small a pool, or a tree over the lights: the same bits. */
static void test_fallback(void **state) {
    UNUSED(state);
    static const char *const sources[] = {"builtin:city?lights=64", "builtin:hall?lights=1100"};
    for (uint32_t i = 0; i < COUNT_OF(sources); i++) {
        struct stage stage = stage_open(sources[i], 0);
        stage.frame.width = 161; /* in a smaller picture more pixels are edges, which no texel suits */
        stage.frame.height = 91;
        struct shot all = order_shoot(&stage, FNL_SHADING_INFERRED, FNL_LISTS_ALL);
        struct shot shot = order_shoot(&stage, FNL_SHADING_INFERRED, FNL_LISTS_TILED);
        harness_set_pool(&stage, 10);
        struct shot cramped = order_shoot(&stage, FNL_SHADING_INFERRED, FNL_LISTS_TILED);
        print_message("  %s: %llu evaluations, all %llu, a small pool %llu\n", sources[i],
                      (unsigned long long)shot.stats.evaluations, (unsigned long long)all.stats.evaluations,
                      (unsigned long long)cramped.stats.evaluations);
        assert_int_equal(count_differing(&all.radiance, &shot.radiance), 0);
        assert_int_equal(count_differing(&all.radiance, &cramped.radiance), 0);
        assert_int_equal(shot.stats.evaluations_useful, all.stats.evaluations_useful);
        assert_true(shot.stats.evaluations * 4 < all.stats.evaluations);
        assert_int_equal(shot.stats.overflow_cells, 0);
        assert_true(cramped.stats.overflow_cells > 0 && stage.renderer->lists.pool_capacity > 10);
        shot_free(&all);
        shot_free(&shot);
        shot_free(&cramped);
        stage_close(&stage);
    }
}

static void check_quality(const char *source, float ev, double half, double quarter, double share) {
    struct stage stage = stage_open(source, 0);
    stage.frame.ev = ev;
    stage.frame.width = 320;
    stage.frame.height = 180;
    struct shot deferred = order_shoot(&stage, FNL_SHADING_DEFERRED, FNL_LISTS_TILED);
    for (uint32_t scale = 2; scale <= 4; scale *= 2) {
        stage.frame.light_buffer.scale = scale;
        for (int b = FNL_LIGHT_BUFFER_RGBA; b <= FNL_LIGHT_BUFFER_FOUR; b += 2) {
            stage.frame.light_buffer.kind = (fnl_light_buffer)b;
            struct shot shot = order_shoot(&stage, FNL_SHADING_INFERRED, FNL_LISTS_TILED);
            double got = order_psnr(&deferred.color, &shot.color);
            double part = (double)shot.stats.evaluations / (double)deferred.stats.evaluations;
            print_message("  %s, 1/%u, %s: %.1f dB, %.2f of the evaluations\n", source, scale,
                          fnl_value_name(FNL_ENUM_LIGHT_BUFFER, (fnl_light_buffer)b), got, part);
            assert_true(got > (scale == 2 ? half : quarter) && part < share);
            shot_free(&shot);
        }
    }
    shot_free(&deferred);
    stage_close(&stage);
}

static void test_quality(void **state) {
    UNUSED(state);
    check_quality("builtin:hall?lights=256", 3, 28, 25, 0.5);
    check_quality("builtin:city?lights=512", 3, 28, 25, 0.6);
    check_quality("builtin:glass?lights=40", 5, 28, 25, 0.4);
}

/*
 * Two squares side by side in one plane, one smooth and one rough, and a light before the seam: nothing but the item tells their texels apart.
 * The sharp highlight of the smooth one ends at the seam.
 */
static void test_light_belongs_to_items(void **state) {
    UNUSED(state);
    fnl_scene *scene = msaa_scene();
    msaa_square(scene, msaa_material(scene, 0.1f, 0.1f, 0.1f, 0.25f), 0, 1, vec3_make(-1.003f, 0, 0));
    msaa_square(scene, msaa_material(scene, 0.1f, 0.1f, 0.1f, 1), 0, 1, vec3_make(0.997f, 0, 0));
    fnl_light_params light = fnl_light_params_default();
    fnl_light_id id;
    light.position = vec3_make(0, 0, 2);
    light.intensity = 20;
    light.range = 10;
    assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
    struct stage stage = stage_open_scene(scene);
    fnl_frame *frame = &stage.frame;
    frame->width = frame->height = 91;
    frame->camera = fnl_camera_default();
    frame->camera.position = vec3_make(0, 0, 5);
    frame->camera.target = vec3_make(0, 0, 0);
    frame->camera.orthographic = true;
    frame->camera.vertical_extent = 1.5f;
    frame->camera.far_distance = 20;
    struct shot deferred = order_shoot(&stage, FNL_SHADING_DEFERRED, FNL_LISTS_ALL);
    for (uint32_t scale = 2; scale <= 4; scale *= 2) {
        frame->light_buffer.scale = scale;
        struct shot shot = order_shoot(&stage, FNL_SHADING_INFERRED, FNL_LISTS_ALL);
        double worst = 0, contrast = 0;
        for (uint32_t y = 0; y < 91; y++)
            for (uint32_t x = 0; x < 91; x++) {
                const float *p = (const float *)deferred.radiance.pixels + 4 * (y * 91 + x),
                            *q = (const float *)shot.radiance.pixels + 4 * (y * 91 + x);
                if (x >= 45) worst = fmax(worst, fabs((double)q[0] / (double)p[0] - 1));
                if (x == 45) contrast = fmax(contrast, (double)p[-4] / (double)p[0]);
            }
        print_message("  1/%u: the rough square is off by %.0f %% at most; the seam parts 1 : %.1f\n", scale, worst * 100, contrast);
        assert_true(contrast > 2 && worst < 0.25);
        shot_free(&shot);
    }
    shot_free(&deferred);
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        {"ES-24: inferred lists equal its own brute force, blended surfaces included", test_lists, NULL, harness_check,
         NULL},
        {"ES-24: inferred finds the lights of pixels that no texel suits in clusters", test_fallback, NULL, harness_check,
         NULL},
        {"ES-24: inferred takes light of the own item", test_light_belongs_to_items, NULL, harness_check, NULL},
        {"ES-24: inferred is close in hall, city and glass", test_quality, NULL, harness_check, NULL},
    };
    return cmocka_run_group_tests_name("inferred", tests, harness_begin, harness_end);
}
