/* SPDX-License-Identifier: MIT */
/* Shadows of lights that are chosen by chance: their mean is that of rays, and rays are few. */
#include "tests/render_harness.h"
#include "tests/shadow_cases.h"
#include "tests/shadow_paths.h"

#include "render/renderer_internal.h"

static const char *const many_lights = "builtin:interior?lights=300"; /* of all shapes */

/* ---- lamps ---- */

enum { LAMPS = 8 };

/* A floor that fills the picture, and lamps far above its middle, of equal strength or each twice as strong as the last. Those cast no
   shadow. `far` more are out of reach. */
static struct stage open_lamps(uint32_t lamps, bool sun, bool unequal, uint32_t far) {
    fnl_scene *scene = world_create(NULL);
    fnl_material_params white = matt(1);
    add_square(scene, &white, (vec3){10, 1, 10}, (vec3){0, 0, 0});
    if (!unequal) add_square(scene, &white, (vec3){0.5f, 1, 0.5f}, (vec3){0, 1, 0});
    fnl_light_id id;
    for (uint32_t i = 0; i < lamps + far; i++) {
        fnl_light_params lamp = fnl_light_params_default();
        lamp.position = (vec3){cosf((float)i * 0.7854f), 4, sinf((float)i * 0.7854f)};
        if (i >= lamps) lamp.position.x += 1000;
        lamp.intensity = unequal ? 1 << i : 10, lamp.range = 50;
        assert_int_equal(fnl_scene_add_light(scene, &lamp, &id), FNL_OK);
    }
    if (sun) {
        fnl_light_params light = fnl_light_params_default();
        light.kind = FNL_LIGHT_DIRECTIONAL, light.direction = (vec3){0.5f, -1, 0}, light.intensity = 10;
        assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
    }
    struct stage s = stage_open_scene(scene);
    s.frame.width = s.frame.height = SHADOW_SIZE;
    s.frame.camera = look_down((vec3){0, 0, 0}, 2, 0.5f, SHADOW_SIZE).camera;
    s.frame.count_lights = true;
    return s;
}

/* ---- means ---- */

static struct shot shoot(struct stage *s, fnl_shadows shadows, uint32_t seed) {
    s->frame.shadows = shadows;
    s->frame.shadow.seed = seed;
    return stage_shoot(s, &s->frame);
}

static void open_small(struct stage *s, const char *source) {
    *s = stage_open(source, 0);
    s->frame.width = 65, s->frame.height = 37, s->frame.ev = 1;
}

enum { FRAMES = 32, MOST = 6 };

/* Root mean squares of the difference from rays, of x / (1 + x): of the means of the first 1, 2, 4 … frames up
   to `frames`. Returns how many. */
static uint32_t errors_of_means(struct stage *s, uint32_t frames, double *errors) {
    struct shot truth = shoot(s, FNL_SHADOWS_RAYS, 0);
    const size_t values = (size_t)truth.radiance.width * truth.radiance.height * 4;
    const float *expected = truth.radiance.pixels;
    double *sum = calloc(values, sizeof *sum);
    uint32_t count = 0;
    for (uint32_t n = 0; n < frames; n++) {
        struct shot shot = shoot(s, FNL_SHADOWS_SAMPLED, n);
        assert_int_equal(count_broken(&shot.radiance), 0);
        const float *seen = shot.radiance.pixels;
        for (size_t i = 0; i < values; i++) sum[i] += (double)seen[i];
        shot_free(&shot);
        if (n & (n + 1)) continue;
        double square = 0;
        for (size_t i = 0; i < values; i++) {
            const double mean = sum[i] / (n + 1), e = mean / (1 + mean) - (double)expected[i] / (1 + (double)expected[i]);
            square += e * e;
        }
        errors[count++] = sqrt(square / (double)values);
    }
    free(sum);
    shot_free(&truth);
    return count;
}

/* Slope of log(error) over log(frames), least squares. */
static double slope(const double *errors, uint32_t count) {
    double x = 0, y = 0, xx = 0, xy = 0;
    for (uint32_t i = 0; i < count; i++) {
        const double e = log2(errors[i]);
        x += i, y += e, xx += (double)i * i, xy += i * e;
    }
    return (count * xy - x * y) / (count * xx - x * x);
}

static void expect_convergence(struct stage *s, const char *what) {
    double errors[MOST];
    const uint32_t count = errors_of_means(s, FRAMES, errors);
    const double found = slope(errors, count);
    print_message("%s: error %.2g of one frame, %.2g of %d; slope %.2f\n", what, errors[0], errors[count - 1], FRAMES, found);
    if (found > -0.5 || errors[count - 1] > errors[0] / 10) fail_msg("%s: slope %.2f, %g -> %g", what, found, errors[0], errors[count - 1]);
}

static void test_SH_40_mean_of_frames_is_that_of_rays(void **state) {
    UNUSED(state);
    struct stage s;
    open_small(&s, many_lights);
    expect_convergence(&s, "1 ray");
    s.frame.shadow.rays = 4;
    s.frame.msaa = 4;
    expect_convergence(&s, "4 rays, 4 samples");
    stage_close(&s);
    open_small(&s, "builtin:glass?lights=200&crossing=1");
    expect_convergence(&s, "glass");
    stage_close(&s);
}

/* The mean of each path is that of its own rays. Paths that cannot choose send all rays. */
static void test_SH_41_all_paths_have_the_mean_of_rays(void **state) {
    UNUSED(state);
    struct stage s;
    open_small(&s, "builtin:interior?lights=100");
    for (fnl_shading shading = FNL_SHADING_FORWARD; shading < FNL_SHADING_AUTO; shading++) {
        const bool exact = shading == FNL_SHADING_DEFERRED_VOLUMES || shading == FNL_SHADING_PRE_LIGHTING || shading == FNL_SHADING_ZIOMA ||
                           shading == FNL_SHADING_LIGHT_PREPASS || shading == FNL_SHADING_LOW_RES || shading == FNL_SHADING_INFERRED;
        double errors[MOST];
        s.frame.shading = shading;
        uint32_t last = errors_of_means(&s, exact ? 1 : 8, errors) - 1;
        const char *name = fnl_value_name(FNL_ENUM_SHADING, shading);
        print_message("%s: %.2g -> %.2g\n", name, errors[0], errors[last]);
        if (exact ? errors[0] != 0 : !(errors[0] > 1e-3) || errors[last] > errors[0] / 3)
            fail_msg("%s: %g -> %g", name, errors[0], errors[last]);
    }
    double errors[MOST];
    s.frame.shading = FNL_SHADING_COARSE;
    s.frame.coarse.split = FNL_COARSE_SPLIT_SHARP;
    errors_of_means(&s, 1, errors);
    assert_true(errors[0] == 0);
    s.frame.shading = FNL_SHADING_FORWARD_PREPASS;
    s.frame.lists = FNL_LISTS_MULTIPASS;
    errors_of_means(&s, 1, errors);
    assert_true(errors[0] == 0);
    stage_close(&s);
}

/* ---- to the bit ---- */

static void test_SH_42_lists_choose_the_same_lights(void **state) {
    UNUSED(state);
    expect_lists_alike(FNL_SHADOWS_SAMPLED);
}

static void expect_rays(struct stage *s) {
    struct shot rays = shoot(s, FNL_SHADOWS_RAYS, 0), sampled = shoot(s, FNL_SHADOWS_SAMPLED, 5);
    assert_int_equal(count_differing(&rays.radiance, &sampled.radiance), 0);
    shot_free(&rays);
    shot_free(&sampled);
}

/* Where there are as many rays as lights, nothing is left to chance. */
static void test_SH_43_few_lights_have_exact_shadows(void **state) {
    UNUSED(state);
    static const fnl_shading shadings[] = {FNL_SHADING_FORWARD, FNL_SHADING_DEFERRED, FNL_SHADING_LIGHT_PREPASS, FNL_SHADING_VISIBILITY};
    for (uint32_t k = 0; k < COUNT_OF(shadings); k++) {
        struct stage s = stage_open("Fox.glb", 1);
        s.frame.shading = shadings[k];
        expect_rays(&s);
        stage_close(&s);
        s = stage_open("builtin:glass?lights=16", 0);
        s.frame.shading = shadings[k];
        s.frame.shadow.rays = 16;
        expect_rays(&s);
        stage_close(&s);
    }
    struct stage s = open_lamps(LAMPS, true, false, 40); /* what counts is how many reach the surface */
    s.frame.shadow.rays = LAMPS;
    expect_rays(&s);
    stage_close(&s);
    s = stage_open("Fox.glb", 0); /* no light at all */
    expect_rays(&s);
    stage_close(&s);
}

static void test_frames_repeat(void **state) {
    UNUSED(state);
    struct stage s;
    open_small(&s, many_lights);
    struct shot first = shoot(&s, FNL_SHADOWS_SAMPLED, 3), other = shoot(&s, FNL_SHADOWS_SAMPLED, 4), again = shoot(&s, FNL_SHADOWS_SAMPLED, 3);
    assert_int_equal(count_differing(&first.radiance, &again.radiance), 0);
    assert_true(count_differing(&first.radiance, &other.radiance) > 65 * 37 / 4);
    shot_free(&first);
    shot_free(&other);
    shot_free(&again);
    stage_close(&s);
}

/* Temporal antialiasing takes other lights in each frame: its picture becomes that of rays. */
static void test_accumulation_has_the_mean_of_rays(void **state) {
    UNUSED(state);
    double errors[3];
    struct stage s;
    struct shot truth = {0};
    for (int k = 0; k < 3; k++) { /* rays; the first frame; the 24th */
        open_small(&s, many_lights);
        s.frame.aa = FNL_ANTIALIASING_TAA;
        struct shot shot = {0};
        for (int n = 0; n < (k == 1 ? 1 : 24); n++) {
            shot_free(&shot);
            shot = shoot(&s, k ? FNL_SHADOWS_SAMPLED : FNL_SHADOWS_RAYS, 0);
        }
        fnl_image_difference difference;
        if (k > 0) assert_int_equal(fnl_image_compare(NULL, &truth.color, &shot.color, &difference), FNL_OK);
        errors[k] = k ? difference.rmse : 0;
        if (k) shot_free(&shot);
        else truth = shot;
        stage_close(&s);
    }
    print_message("accumulated: %.3g -> %.3g\n", errors[1], errors[2]);
    assert_true(errors[2] < errors[1] / 4);
    shot_free(&truth);
}

/* ---- how many rays ---- */

/* `visits`: light evaluations, or NULL. */
static uint64_t rays_of(struct stage *s, fnl_shadows shadows, uint64_t *visits) {
    struct shot shot = shoot(s, shadows, 1);
    const uint64_t rays = counter(&shot.stats, "shadows.rays");
    if (visits) *visits = shot.stats.evaluations;
    shot_free(&shot);
    return rays;
}

/* A chosen light stands for all by how much it gives: where all are seen, whichever it is, the sum is right. */
static void test_SH_45_light_without_shadows_has_no_noise(void **state) {
    UNUSED(state);
    struct stage s = open_lamps(LAMPS, false, true, 0);
    struct shot off = shoot(&s, FNL_SHADOWS_OFF, 0), sampled = shoot(&s, FNL_SHADOWS_SAMPLED, 1);
    const float *a = off.radiance.pixels, *b = sampled.radiance.pixels;
    for (uint32_t i = 0; i < SHADOW_SIZE * SHADOW_SIZE * 4; i++) {
        assert_true(a[i] > 0);
        assert_float_equal(b[i], a[i], 1e-4 * (double)a[i]);
    }
    shot_free(&off);
    shot_free(&sampled);
    stage_close(&s);
}

static void test_SH_44_each_pixel_sends_the_rays_asked_for(void **state) {
    UNUSED(state);
    const uint64_t pixels = SHADOW_SIZE * SHADOW_SIZE;
    for (int sun = 0; sun < 2; sun++) {
        struct stage s = open_lamps(LAMPS, sun, false, 0);
        for (fnl_shading shading = FNL_SHADING_FORWARD; shading <= FNL_SHADING_DEFERRED; shading++) {
            s.frame.shading = shading;
            if (shading == FNL_SHADING_FORWARD_PREPASS) continue;
            assert_int_equal(rays_of(&s, FNL_SHADOWS_RAYS, NULL), pixels * (LAMPS + sun));
            for (uint32_t rays = 1; rays <= 16; rays *= 2) {
                s.frame.shadow.rays = rays;
                uint64_t visits;
                assert_int_equal(rays_of(&s, FNL_SHADOWS_SAMPLED, &visits), pixels * (MIN(rays, LAMPS) + sun));
                if (rays == 1) assert_true(visits < pixels * (LAMPS + LAMPS - 2)); /* the second walk ends at the chosen light */
            }
        }
        stage_close(&s);
    }
    struct stage s = open_lamps(0, false, false, 0);
    assert_int_equal(rays_of(&s, FNL_SHADOWS_SAMPLED, NULL), 0);
    s.frame.shadows = FNL_SHADOWS_OFF;
    struct shot shot = stage_shoot(&s, &s.frame);
    assert_false(has_counter(&shot.stats, "shadows.rays"));
    shot_free(&shot);
    stage_close(&s);
    s = stage_open("builtin:hall?lights=64", 0);
    s.frame.count_lights = true;
    uint64_t all_visits, visits;
    const uint64_t all = rays_of(&s, FNL_SHADOWS_RAYS, &all_visits);
    for (uint32_t rays = 1; rays <= 4; rays *= 2) {
        s.frame.shadow.rays = rays;
        const uint64_t sent = rays_of(&s, FNL_SHADOWS_SAMPLED, &visits);
        assert_true(visits < 2 * all_visits);
        print_message("hall, %u rays a pixel: %u of %u\n", rays, (uint32_t)sent, (uint32_t)all);
        assert_true(sent > 0 && sent <= (uint64_t)rays * s.frame.width * s.frame.height && sent < all);
    }
    stage_close(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_SH_40_mean_of_frames_is_that_of_rays, harness_check),
        cmocka_unit_test_teardown(test_SH_41_all_paths_have_the_mean_of_rays, harness_check),
        cmocka_unit_test_teardown(test_SH_42_lists_choose_the_same_lights, harness_check),
        cmocka_unit_test_teardown(test_SH_43_few_lights_have_exact_shadows, harness_check),
        cmocka_unit_test_teardown(test_frames_repeat, harness_check),
        cmocka_unit_test_teardown(test_accumulation_has_the_mean_of_rays, harness_check),
        cmocka_unit_test_teardown(test_SH_45_light_without_shadows_has_no_noise, harness_check),
        cmocka_unit_test_teardown(test_SH_44_each_pixel_sends_the_rays_asked_for, harness_check),
    };
    return cmocka_run_group_tests_name("sampled_shadows", tests, harness_begin, harness_end);
}
