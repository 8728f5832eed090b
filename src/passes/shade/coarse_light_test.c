/* SPDX-License-Identifier: MIT */
/** Coarse shading: what the pixels of blocks get, and how often that is found. */
#include "tests/coarse_cases.h"

static void test_lists_give_one_picture_CP_8(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:hall?lights=1024", 0);
    fnl_frame frame = coarse_hall_frame(&stage, 81, 45);
    frame.lists = FNL_LISTS_ALL;
    for (uint32_t split = 0; split < FNL_COARSE_SPLIT_COUNT; split += 2) {
        frame.coarse.split = (fnl_coarse_split)split;
        frame.lists = FNL_LISTS_ALL;
        struct shot all = stage_shoot(&stage, &frame);
        static const fnl_light_lists kinds[] = {FNL_LISTS_TILED, FNL_LISTS_CLUSTERED, FNL_LISTS_BACKFACE, FNL_LISTS_ZBIN};
        for (uint32_t i = 0; i < COUNT_OF(kinds); i++) {
            frame.lists = kinds[i];
            struct shot shot = stage_shoot(&stage, &frame);
            if (count_differing(&shot.radiance, &all.radiance))
                fail_msg("%s, split %u: not the picture of all", fnl_value_name(FNL_ENUM_LISTS, frame.lists), split);
            shot_free(&shot);
        }
        shot_free(&all);
    }
    stage_close(&stage);
}

/* ---- what blocks share ---- */

static void test_split_sums_CP_10(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:hall?lights=300", 0);
    fnl_frame frame = coarse_hall_frame(&stage, 81, 45);
    frame.coarse.filter = FNL_COARSE_FILTER_NONE;
    struct shot full = coarse_deferred(&stage, frame);
    for (uint32_t split = 0; split < FNL_COARSE_SPLIT_COUNT; split++)
        for (uint32_t size = 2; size <= 4; size += 2) {
            frame.coarse.size = size;
            frame.coarse.split = (fnl_coarse_split)split;
            struct shot shot = stage_shoot(&stage, &frame);
            /* At its own pixel a block has what this pixel has at the full rate. */
            double worst = coarse_worst_ratio(&shot.radiance, &full.radiance, size);
            if (worst > (split ? 2e-4 : 0)) fail_msg("split %u, size %u: off by %g", split, size, worst);
            assert_true(coarse_worst_ratio(&shot.radiance, &full.radiance, 1) > 0.01);
            shot_free(&shot);
        }
    shot_free(&full);
    stage_close(&stage);
}

static fnl_image_id add_noise(fnl_scene *scene) {
    enum { SIDE = 128 };
    static uint8_t texels[SIDE * SIDE * 4];
    struct random_state random = {3};
    for (uint32_t i = 0; i < SIDE * SIDE; i++) {
        uint8_t grey = (uint8_t)random_range(&random, 0, 255);
        memcpy(&texels[4 * i], (uint8_t[4]){grey, grey, grey, 255}, 4);
    }
    fnl_image_id id;
    assert_int_equal(fnl_scene_add_image(scene, &(fnl_image){SIDE, SIDE, FNL_PIXEL_FORMAT_RGBA8, texels}, true, &id),
                     FNL_OK);
    return id;
}

/* What a split makes for each pixel is right at each pixel; without the split it is not. */
static void test_split_pixel_rate_CP_10(void **state) {
    UNUSED(state);
    for (uint32_t split = 1; split < FNL_COARSE_SPLIT_COUNT; split++) {
        fnl_scene *scene = coarse_scene();
        float roughness = split == FNL_COARSE_SPLIT_HIGHLIGHTS ? 0.2f : 1;
        bool noise = split == FNL_COARSE_SPLIT_ALBEDO;
        coarse_add_plane(scene, coarse_material(scene, roughness, noise ? add_noise(scene) : (fnl_image_id){0}), -3, 3, 0, 0, 0);
        fnl_light_kind kinds[] = {FNL_LIGHT_POINT, FNL_LIGHT_DIRECTIONAL, FNL_LIGHT_POINT, FNL_LIGHT_SPOT};
        coarse_add_light(scene, kinds[split], vec3_make(0, 0, split == FNL_COARSE_SPLIT_SHARP ? 2 : 0.5f), 5);
        struct stage stage = stage_open_scene(scene);
        fnl_frame frame = coarse_front_frame(&stage);
        struct shot full = coarse_deferred(&stage, frame), none = stage_shoot(&stage, &frame);
        frame.coarse.split = (fnl_coarse_split)split;
        struct shot shot = stage_shoot(&stage, &frame);
        assert_int_equal(counter(&shot.stats, "coarse.shared"), counter(&shot.stats, "coarse.blocks"));
        double worst = coarse_worst_ratio(&shot.radiance, &full.radiance, 1),
               without = coarse_worst_ratio(&none.radiance, &full.radiance, 1);
        print_message("split %s: off by %.3g, without by %.3g\n", fnl_value_name(FNL_ENUM_COARSE_SPLIT, frame.coarse.split), worst, without);
        if (split == FNL_COARSE_SPLIT_HIGHLIGHTS)
            assert_true(worst < 0.5 * without); /* the diffuse light is still the block's */
        else
            assert_true(worst < 1e-3 && without > 0.1);
        shot_free(&full);
        shot_free(&none);
        shot_free(&shot);
        stage_close(&stage);
    }
}

/*
 * What is evaluated how often, on a plane that is lit once per block: with all lights in one list each evaluation visits all of them, and
 * those that reach the surface are known from shading every pixel.
 */
static void test_split_work_CP_10(void **state) {
    UNUSED(state);
    enum { POINTS = 5, SPOTS = 3, PIXELS = 64 * 64 };
    fnl_scene *scene = coarse_scene();
    coarse_add_plane(scene, coarse_plain(scene), -3, 3, 0, 0, 0);
    for (int i = 0; i < POINTS; i++) coarse_add_light(scene, FNL_LIGHT_POINT, vec3_make(0.3f * (float)i - 0.6f, 0.2f, 2), 5);
    for (int i = 0; i < SPOTS; i++) coarse_add_light(scene, FNL_LIGHT_SPOT, vec3_make(0.5f * (float)i - 0.5f, -0.1f, 2), 5);
    struct stage stage = stage_open_scene(scene);
    fnl_frame frame = coarse_front_frame(&stage);
    frame.lists = FNL_LISTS_ALL;
    frame.count_lights = true;
    frame.shading = FNL_SHADING_DEFERRED;
    fnl_frame_stats full = coarse_stats(&stage, &frame);
    assert_int_equal(full.evaluations, PIXELS * (POINTS + SPOTS));
    uint64_t useful_spots = full.evaluations_useful - PIXELS * POINTS;
    assert_true(useful_spots > PIXELS / 4 && useful_spots < PIXELS * SPOTS / 2);
    frame.shading = FNL_SHADING_COARSE;
    for (uint32_t size = 2; size <= 4; size += 2)
        for (uint32_t gather = 0; gather < 2; gather++) {
            uint32_t blocks = PIXELS / (size * size);
            frame.coarse.size = size;
            frame.coarse.gather = gather;
            uint64_t useful_once = 0;
            for (uint32_t split = 0; split < FNL_COARSE_SPLIT_COUNT; split++) {
                frame.coarse.split = (fnl_coarse_split)split;
                fnl_frame_stats s = coarse_stats(&stage, &frame);
                bool twice = split == FNL_COARSE_SPLIT_HIGHLIGHTS || split == FNL_COARSE_SPLIT_SHARP;
                assert_int_equal(counter(&s, "coarse.shared"), blocks);
                assert_int_equal(s.evaluations, (uint64_t)(twice ? blocks + PIXELS : blocks) * (POINTS + SPOTS));
                if (split == FNL_COARSE_SPLIT_NONE) useful_once = s.evaluations_useful;
                uint64_t useful = split == FNL_COARSE_SPLIT_HIGHLIGHTS ? useful_once + full.evaluations_useful
                                  : split == FNL_COARSE_SPLIT_SHARP    ? (uint64_t)blocks * POINTS + useful_spots
                                                                       : useful_once;
                assert_int_equal(s.evaluations_useful, useful);
            }
            assert_in_range(useful_once, full.evaluations_useful / (size * size) * 9 / 10,
                            full.evaluations_useful / (size * size) * 11 / 10);
        }
    stage_close(&stage);
}

static void test_splat_and_gather_CP_11(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:hall?lights=100", 0);
    fnl_frame frame = coarse_hall_frame(&stage, 81, 45);
    for (uint32_t split = 0; split < FNL_COARSE_SPLIT_COUNT; split++) {
        frame.coarse.split = (fnl_coarse_split)split;
        frame.coarse.gather = false;
        struct shot splat = stage_shoot(&stage, &frame);
        frame.coarse.gather = true;
        struct shot gather = stage_shoot(&stage, &frame);
        assert_int_equal(count_differing(&splat.radiance, &gather.radiance), 0);
        assert_int_equal(counter(&splat.stats, "coarse.shaded"), counter(&gather.stats, "coarse.shaded"));
        assert_true(counter(&splat.stats, "coarse.shared") > 0);
        shot_free(&splat);
        shot_free(&gather);
    }
    stage_close(&stage);
}

/* ---- motion ---- */

/* Mean change of a pixel from frame to frame while the camera moves on by parts of a pixel. */
static double flicker(struct stage *stage, fnl_frame frame) {
    enum { FRAMES = 8 };
    fnl_image last = {0};
    double sum = 0;
    for (int i = 0; i < FRAMES; i++) {
        frame.camera.position.x = frame.camera.target.x = 0.37f / 32 * (float)i;
        struct shot shot = stage_shoot(stage, &frame);
        const float *p = shot.radiance.pixels, *q = last.pixels;
        for (uint32_t k = 0; q && k < 64 * 64; k++) sum += fabs((double)p[4 * k] - q[4 * k]);
        fnl_image_free(gpu_host(harness_device()), &last);
        last = shot.radiance;
        shot.radiance = (fnl_image){0};
        shot_free(&shot);
    }
    fnl_image_free(gpu_host(harness_device()), &last);
    return sum / (64 * 64 * (FRAMES - 1));
}

static void test_filters_calm_motion_CP_12(void **state) {
    UNUSED(state);
    fnl_scene *scene = coarse_scene();
    coarse_add_plane(scene, coarse_material(scene, 1, add_noise(scene)), -3, 3, 0, 0, 0); /* 4 texels a pixel */
    assert_int_equal(fnl_scene_set_ambient(scene, vec3_make(1, 1, 1), vec3_make(1, 1, 1)), FNL_OK);
    struct stage stage = stage_open_scene(scene);
    for (uint32_t size = 2; size <= 4; size += 2) {
        fnl_frame frame = coarse_front_frame(&stage);
        frame.outputs = FNL_OUTPUT_RADIANCE;
        frame.coarse.size = size;
        frame.coarse.filter = FNL_COARSE_FILTER_NONE;
        double without = flicker(&stage, frame);
        for (uint32_t filter = FNL_COARSE_FILTER_MEAN; filter <= FNL_COARSE_FILTER_SAMPLED; filter++) {
            frame.coarse.filter = (fnl_coarse_filter)filter;
            double with = flicker(&stage, frame);
            print_message("size %u: a pixel changes by %.4f with the base colour %s, by %.4f with the first pixel's\n", size,
                          with, fnl_value_name(FNL_ENUM_COARSE_FILTER, frame.coarse.filter), without);
            assert_true(with < 0.8 * without);
        }
    }
    stage_close(&stage);
}

/* ---- cost, occlusion ---- */

/* The loops that imitate dear materials change no bit. They run for what is lit: once for most blocks of four pixels, whatever is split. */
static void test_cost_changes_no_bit_CP_15(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:onetile?lights=20", 0);
    fnl_frame frame = coarse_hall_frame(&stage, 64, 36);
    for (uint32_t i = 0; i < 4; i++) {
        frame.shading = i < 2 ? FNL_SHADING_FORWARD : FNL_SHADING_COARSE;
        if (i == 1) frame.shading = FNL_SHADING_DEFERRED;
        frame.coarse.split = i == 3 ? FNL_COARSE_SPLIT_ALBEDO : FNL_COARSE_SPLIT_NONE;
        struct shot cheap, dear;
        frame.shade_cost = 0;
        cheap = stage_shoot(&stage, &frame);
        frame.shade_cost = 20000;
        dear = stage_shoot(&stage, &frame);
        assert_int_equal(count_differing(&cheap.radiance, &dear.radiance), 0);
        assert_int_equal(has_counter(&dear.stats, "coarse.shaded"), i > 1);
        if (i > 1) assert_true(counter(&dear.stats, "coarse.shaded") < 0.5 * counter(&dear.stats, "coarse.pixels"));
        shot_free(&cheap);
        shot_free(&dear);
    }
    stage_close(&stage);
}

/* The estimator of coarse_ao.comp.glsl in the valley z = 0.8 |x|, in the middle of a pixel of the view of coarse_front_frame(). */
static double valley_openness(uint32_t x, uint32_t y, double radius) {
    double px = (x + 0.5) / 32 - 1, py = 1 - (y + 0.5) / 32, pz = 0.8 * fabs(px), length = sqrt(0.8 * 0.8 + 1), sum = 0;
    double normal[2] = {px < 0 ? 0.8 / length : -0.8 / length, 1 / length}, reach = radius * 32;
    double bias = 0.002 * (5 - pz) + 0.01 * radius;
    for (int i = 0; i < 16; i++) {
        double along = (i + 0.5) / 16, turn = i * 2.39996323;
        double u = fmin(fmax(x + round(reach * along * cos(turn)), 0), 63),
               v = fmin(fmax(y + round(reach * along * sin(turn)), 0), 63);
        double qx = (u + 0.5) / 32 - 1, to[3] = {qx - px, 1 - (v + 0.5) / 32 - py, 0.8 * fabs(qx) - pz};
        double distance2 = to[0] * to[0] + to[1] * to[1] + to[2] * to[2], rest = fmax(1 - distance2 / (radius * radius), 0);
        sum += rest * rest * rest * fmax(to[0] * normal[0] + to[2] * normal[1] - bias, 0) /
               (distance2 + 0.01 * radius * radius);
    }
    return fmin(fmax(1 - 2 * radius / 16 * sum, 0), 1);
}

static void test_occlusion_at_coarse_rate_CP_17(void **state) {
    UNUSED(state);
    fnl_scene *scene = coarse_scene();
    fnl_material_id material = coarse_plain(scene);
    coarse_add_plane(scene, material, -3, 0, 0, -0.8f, 0); /* a valley along x = 0 */
    coarse_add_plane(scene, material, 0, 3, 0, 0.8f, 0);
    assert_int_equal(fnl_scene_set_ambient(scene, vec3_make(1, 1, 1), vec3_make(1, 1, 1)), FNL_OK);
    struct stage stage = stage_open_scene(scene);
    fnl_frame frame = coarse_front_frame(&stage);
    frame.coarse.size = 1;
    struct shot off = stage_shoot(&stage, &frame);
    assert_false(has_counter(&off.stats, "coarse.ao-shaded"));
    frame.coarse.ao_radius = 0.4f;
    struct shot full = stage_shoot(&stage, &frame);
    assert_int_equal(counter(&full.stats, "coarse.ao-shaded"), 64 * 64);
    const float *a = off.radiance.pixels, *b = full.radiance.pixels;
    for (uint32_t y = 0; y < 64; y++)
        for (uint32_t x = 0; x < 64; x++) {
            size_t i = 4 * (y * 64 + x);
            float distance = fabsf(((float)x + 0.5f) / 32 - 1);
            if (distance < 0.05f) assert_true(b[i] < 0.9f * a[i]);
            if (distance > 0.5f) assert_true(b[i] > 0.99f * a[i]);
            assert_true(fabs((double)b[i] / a[i] - valley_openness(x, y, 0.4)) < 3e-3); /* there is but ambient light */
        }
    for (uint32_t size = 2; size <= 4; size += 2) {
        frame.coarse.size = size;
        frame.coarse.depth_factor = 0; /* no block is alike */
        struct shot fine = stage_shoot(&stage, &frame);
        assert_int_equal(counter(&fine.stats, "coarse.ao-shaded"), 64 * 64);
        assert_int_equal(count_differing(&fine.radiance, &full.radiance), 0);
        shot_free(&fine);
        frame.coarse.depth_factor = 1;
        struct shot shot = stage_shoot(&stage, &frame);
        assert_int_equal(counter(&shot.stats, "coarse.ao-shaded"), counter(&shot.stats, "coarse.shaded"));
        assert_true(counter(&shot.stats, "coarse.ao-shaded") < 64 * 64 / 3);
        double near = coarse_psnr(&shot.color, &full.color);
        print_message("size %u: occlusion found %u times for 4096 pixels, %.1f dB\n", size,
                      (uint32_t)counter(&shot.stats, "coarse.ao-shaded"), near);
        assert_true(near > 28);
        /* Blocks have the occlusion of their first pixels, whatever else they share. */
        assert_true(coarse_worst_ratio(&shot.radiance, &full.radiance, size) < 1e-6);
        frame.coarse.split = FNL_COARSE_SPLIT_ALBEDO;
        struct shot split = stage_shoot(&stage, &frame);
        assert_true(coarse_worst_ratio(&split.radiance, &shot.radiance, 1) < 2e-3);
        frame.coarse.split = FNL_COARSE_SPLIT_NONE;
        shot_free(&split);
        shot_free(&shot);
    }
    shot_free(&off);
    shot_free(&full);
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_lists_give_one_picture_CP_8, harness_check),
        cmocka_unit_test_teardown(test_split_sums_CP_10, harness_check),
        cmocka_unit_test_teardown(test_split_pixel_rate_CP_10, harness_check),
        cmocka_unit_test_teardown(test_split_work_CP_10, harness_check),
        cmocka_unit_test_teardown(test_splat_and_gather_CP_11, harness_check),
        cmocka_unit_test_teardown(test_filters_calm_motion_CP_12, harness_check),
        cmocka_unit_test_teardown(test_cost_changes_no_bit_CP_15, harness_check),
        cmocka_unit_test_teardown(test_occlusion_at_coarse_rate_CP_17, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
