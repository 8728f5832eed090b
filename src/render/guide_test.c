/* SPDX-License-Identifier: MIT */
/* Sampled shadows whose choice of lights is guided by what earlier frames saw: right on average whatever they saw, with less noise where lights are hidden. */
#include "tests/render_harness.h"
#include "tests/trace_world.h"

/* ---- worlds ---- */

enum { SIDE = 48, LAMPS = 16 };

/* A floor under lamps in a row, all alike. A screen hides all but two of them from the whole floor; it may be taken away. */
struct world {
    struct stage stage;
    fnl_instance_id screen;
};

static mat4 screen_at(float x) { return mat4_mul(mat4_translation((vec3){x, 2, 0}), mat4_scaling((vec3){3, 1, 6})); }

static struct world world_open(void) {
    struct world w = {0};
    fnl_scene *scene = world_create(NULL);
    const fnl_material_params grey = matt(0.5f);
    add_square(scene, &grey, (vec3){2, 1, 2}, (vec3){0, 0, 0});
    w.screen = add_instance(scene, add_square_mesh(scene, add_material(scene, &grey)), screen_at(0));
    for (uint32_t i = 0; i < LAMPS; i++) add_point_light(scene, (vec3){0.1f * (float)i - 0.75f, i % 8 == 3 ? 1.9f : 2.5f, 0.05f * (float)(i % 4)}, 3);
    w.stage = stage_open_scene(scene);
    w.stage.frame.width = w.stage.frame.height = SIDE;
    w.stage.frame.camera = fnl_camera_default();
    w.stage.frame.camera.position = (vec3){0, 1.5f, 2.5f}, w.stage.frame.camera.target = (vec3){0, 0, 0};
    w.stage.frame.outputs = FNL_OUTPUT_RADIANCE;
    w.stage.frame.shadow.guide = true;
    return w;
}

static struct stage open_small(const char *source) {
    struct stage s = stage_open(source, 0);
    s.frame.width = 65, s.frame.height = 37, s.frame.ev = 1;
    s.frame.shadow.guide = true;
    s.frame.outputs = FNL_OUTPUT_RADIANCE;
    return s;
}

static struct shot shoot(struct stage *s, fnl_shadows shadows, uint32_t seed) {
    s->frame.shadows = shadows;
    s->frame.shadow.seed = seed;
    struct shot shot = stage_shoot(s, &s->frame);
    assert_int_equal(count_broken(&shot.radiance), 0);
    return shot;
}

/* By a renderer of its own: the other one keeps its history. */
static struct shot shoot_alone(const struct stage *s, fnl_shadows shadows, bool guide, uint32_t seed) {
    struct stage other = *s;
    assert_int_equal(fnl_renderer_create(harness_device(), s->scene, &other.renderer), FNL_OK);
    other.frame.shadow.guide = guide;
    other.frame.shadow.denoise = shadows == FNL_SHADOWS_SAMPLED && s->frame.shadow.denoise;
    struct shot shot = shoot(&other, shadows, seed);
    fnl_renderer_destroy(&other.renderer);
    return shot;
}

/* Seeds from `seed` on; returns the last one. */
static struct shot run(struct stage *s, uint32_t frames, uint32_t seed) {
    struct shot shot = {0};
    for (uint32_t i = 0; i < frames; i++) {
        shot_free(&shot);
        shot = shoot(s, FNL_SHADOWS_SAMPLED, seed + i);
    }
    return shot;
}

static double squeezed(double x) { return x / (1 + x); }

/* Root mean square of the difference of x / (1 + x). */
static double error_of(const struct shot *a, const struct shot *b) {
    const size_t values = (size_t)a->radiance.width * a->radiance.height * 4;
    const float *x = a->radiance.pixels, *y = b->radiance.pixels;
    double square = 0;
    for (size_t i = 0; i < values; i++) {
        const double e = squeezed((double)x[i]) - squeezed((double)y[i]);
        square += e * e;
    }
    return sqrt(square / (double)values);
}

/* Of `frames` pictures, each by other seeds than the others, root mean square. */
static double mean_error(struct stage *s, const struct shot *rays, uint32_t frames, uint32_t seed) {
    double square = 0;
    for (uint32_t i = 0; i < frames; i++) {
        struct shot shot = shoot(s, FNL_SHADOWS_SAMPLED, seed + i);
        const double error = error_of(&shot, rays);
        square += error * error / frames;
        shot_free(&shot);
    }
    return sqrt(square);
}

/* ---- means ---- */

enum { FRAMES = 32 };

/* The errors of one frame, and of the mean of all. */
static void expect_convergence(struct stage *s, const char *what) {
    struct shot rays = shoot_alone(s, FNL_SHADOWS_RAYS, false, 0);
    const size_t values = (size_t)rays.radiance.width * rays.radiance.height * 4;
    const float *expected = rays.radiance.pixels;
    double *sum = calloc(values, sizeof *sum), errors[2] = {0}, all = 0, most = 0;
    assert_non_null(sum);
    for (uint32_t n = 0; n < FRAMES; n++) {
        struct shot shot = shoot(s, FNL_SHADOWS_SAMPLED, n);
        const float *seen = shot.radiance.pixels;
        if (n == 0) errors[0] = error_of(&shot, &rays);
        for (size_t i = 0; i < values; i++) sum[i] += (double)seen[i] / FRAMES;
        shot_free(&shot);
    }
    for (size_t i = 0; i < values; i++) {
        const double e = squeezed(sum[i]) - squeezed((double)expected[i]);
        errors[1] += e * e / (double)values;
        if (i % 4 == 3) continue;
        all += sum[i], most += (double)expected[i];
    }
    errors[1] = sqrt(errors[1]);
    print_message("%s: error %.3g of one frame, %.3g of %d; light in all %.4f\n", what, errors[0], errors[1], FRAMES, all / most);
    if (errors[1] > errors[0] / 4) fail_msg("%s: %g -> %g", what, errors[0], errors[1]);
    if (fabs(all / most - 1) > 0.005) fail_msg("%s: light %g", what, all / most);
    free(sum);
    shot_free(&rays);
}

/* Whatever guides the choice, and nonsense too. */
static void test_SH_61_mean_of_guided_frames_is_that_of_rays(void **state) {
    UNUSED(state);
    struct stage s = open_small("builtin:interior?lights=300"); /* of all shapes */
    expect_convergence(&s, "guided");
    harness_hooks(s.renderer)->guide_adverse = true;
    expect_convergence(&s, "adverse guides");
    stage_close(&s);
}

/* What no earlier frame knows, is what it is without. */
static void test_SH_62_first_frames_are_what_they_are_without(void **state) {
    UNUSED(state);
    struct world w = world_open();
    for (int denoise = 0; denoise < 2; denoise++) {
        w.stage.frame.shadow.denoise = denoise;
        w.stage.frame.reset_history = true;
        struct shot plain = shoot_alone(&w.stage, FNL_SHADOWS_SAMPLED, false, 5), first = shoot_alone(&w.stage, FNL_SHADOWS_SAMPLED, true, 5);
        assert_int_equal(count_differing(&plain.radiance, &first.radiance), 0);
        struct shot reset = run(&w.stage, 3, 3);
        assert_int_equal(count_differing(&plain.radiance, &reset.radiance), 0);
        w.stage.frame.reset_history = false;
        struct shot next = shoot(&w.stage, FNL_SHADOWS_SAMPLED, 5);
        assert_true(count_differing(&plain.radiance, &next.radiance) > 0);
        shot_free(&plain);
        shot_free(&first);
        shot_free(&reset);
        shot_free(&next);
    }
    stage_close(&w.stage);
}

/* ---- noise ---- */

/* Of frames that follow eight others, still and moving: what tiles know goes with what they show. */
static void test_SH_63_noise_falls_where_lights_are_hidden_SH_66(void **state) {
    UNUSED(state);
    struct stage s = open_small("builtin:hall?lights=256");
    const fnl_camera camera = s.frame.camera;
    struct shot rays = shoot_alone(&s, FNL_SHADOWS_RAYS, false, 0);
    s.frame.shadow.guide = false;
    const double plain = mean_error(&s, &rays, 4, 8);
    s.frame.shadow.guide = true;
    double errors[2] = {0};
    for (int move = 0; move < 2; move++) {
        for (uint32_t i = 0; i < 9; i++) { /* the camera comes to the same place, turning by about a tile in each frame */
            const float turn = move ? 0.16f * (float)(8 - i) : 0, x = camera.target.x - camera.position.x, z = camera.target.z - camera.position.z;
            s.frame.camera.target.x = camera.position.x + cosf(turn) * x - sinf(turn) * z;
            s.frame.camera.target.z = camera.position.z + sinf(turn) * x + cosf(turn) * z;
            s.frame.reset_history = i == 0;
            struct shot shot = shoot(&s, FNL_SHADOWS_SAMPLED, i);
            if (i == 8) errors[move] = error_of(&shot, &rays);
            shot_free(&shot);
        }
        if (move) break;
        s.frame.reset_history = false;
        errors[0] = mean_error(&s, &rays, 4, 9);
    }
    print_message("hall: error %.4f, guided %.4f: %.2f times less; moving %.4f\n", plain, errors[0], plain / errors[0], errors[1]);
    shot_free(&rays);
    stage_close(&s);
    assert_true(errors[0] < plain / 1.2);
    assert_true(plain - errors[1] > 0.8 * (plain - errors[0]));
}

/* Rays go to the two lights that are seen; and they count as they pass. */
static void test_SH_64_rays_go_where_they_pass(void **state) {
    UNUSED(state);
    struct world w = world_open();
    w.stage.frame.count_lights = true;
    double shares[2];
    for (uint32_t i = 0; i < 2; i++) {
        struct shot shot = run(&w.stage, i ? 7 : 1, i);
        const uint64_t sent = counter(&shot.stats, "shadows.rays"), passed = counter(&shot.stats, "shadows.rays-passed");
        shares[i] = (double)passed / (double)sent;
        assert_true(sent > SIDE * SIDE / 4 && passed <= sent);
        shot_free(&shot);
    }
    print_message("rays that pass: %.3f, then %.3f\n", shares[0], shares[1]);
    assert_true(shares[0] > 0.05 && shares[0] < 0.25);
    assert_true(shares[1] > 2.5 * shares[0]);
    stage_close(&w.stage);
}

/* A light whose screen goes away is as good as new within a few frames. */
static void test_SH_65_lights_are_found_again(void **state) {
    UNUSED(state);
    struct world w = world_open();
    struct shot seen = run(&w.stage, 24, 0);
    const mat4 away = screen_at(50);
    assert_int_equal(fnl_scene_set_instance_transform(w.stage.scene, w.screen, &away), FNL_OK);
    struct shot rays = shoot_alone(&w.stage, FNL_SHADOWS_RAYS, false, 0);
    double errors[8];
    for (uint32_t i = 0; i < COUNT_OF(errors); i++) errors[i] = mean_error(&w.stage, &rays, 1, 24 + i);
    print_message("after the screen is gone: %.4f, %.4f, %.4f, %.4f\n", errors[0], errors[1], errors[3], errors[7]);
    assert_true(errors[0] > 0.02);
    assert_true(errors[3] < errors[0] / 4);
    assert_true(errors[7] < errors[0] / 10);
    shot_free(&seen);
    shot_free(&rays);
    stage_close(&w.stage);
}

/* Denoised, the noise that is not there need not be filtered. */
static void test_SH_67_denoised_frames_are_better(void **state) {
    UNUSED(state);
    struct stage s = open_small("builtin:hall?lights=256");
    struct shot rays = shoot_alone(&s, FNL_SHADOWS_RAYS, false, 0);
    s.frame.shadow.denoise = true;
    double errors[2][2];
    for (int guide = 0; guide < 2; guide++) {
        s.frame.shadow.guide = guide;
        for (int k = 0; k < 2; k++) {
            s.frame.reset_history = k == 0;
            struct shot first = run(&s, 1, 0);
            s.frame.reset_history = false;
            struct shot seen = run(&s, k ? 4 : 3, 0);
            errors[guide][k] = error_of(&seen, &rays);
            shot_free(&first);
            shot_free(&seen);
        }
    }
    print_message("denoised: error %.4f after 4 frames, %.4f after 9; guided %.4f, %.4f\n", errors[0][0], errors[0][1], errors[1][0], errors[1][1]);
    shot_free(&rays);
    stage_close(&s);
    assert_true(errors[1][0] < errors[0][0] && errors[1][1] < errors[0][1]);
}

/* ---- limits ---- */

static void test_frames_repeat(void **state) {
    UNUSED(state);
    struct shot shots[2];
    for (uint32_t i = 0; i < 2; i++) {
        struct world w = world_open();
        shots[i] = run(&w.stage, 4, 0);
        stage_close(&w.stage);
    }
    assert_int_equal(count_differing(&shots[0].radiance, &shots[1].radiance), 0);
    for (uint32_t i = 0; i < 2; i++) shot_free(&shots[i]);
}

/* Views learn for themselves, and a new size begins anew. */
static void test_histories_belong_to_views(void **state) {
    UNUSED(state);
    struct world w = world_open();
    fnl_frame *frame = &w.stage.frame;
    fnl_camera cameras[2] = {frame->camera, frame->camera};
    cameras[1].position.z = -2.5f;
    struct shot alone = run(&w.stage, 4, 0);
    frame->views = cameras, frame->view_count = 2;
    struct shot both = run(&w.stage, 4, 0);
    assert_int_equal(memcmp(both.radiance.pixels, alone.radiance.pixels, (size_t)SIDE * SIDE * 16), 0);
    frame->view_count = 0, frame->views = NULL;
    frame->width = 31;
    struct shot plain = shoot_alone(&w.stage, FNL_SHADOWS_SAMPLED, false, 9), narrow = shoot(&w.stage, FNL_SHADOWS_SAMPLED, 9);
    assert_int_equal(count_differing(&plain.radiance, &narrow.radiance), 0);
    shot_free(&alone);
    shot_free(&both);
    shot_free(&plain);
    shot_free(&narrow);
    stage_close(&w.stage);
}

static void test_any_size_and_scene(void **state) {
    UNUSED(state);
    struct world w = world_open();
    static const uint32_t sizes[][2] = {{1, 1}, {113, 65}, {7, 33}};
    for (uint32_t i = 0; i < COUNT_OF(sizes); i++) {
        w.stage.frame.width = sizes[i][0], w.stage.frame.height = sizes[i][1];
        struct shot seen = run(&w.stage, 3, 0);
        shot_free(&seen);
    }
    w.stage.frame.camera.target = (vec3){0, 20, 0}; /* sky */
    struct shot seen = run(&w.stage, 2, 0);
    shot_free(&seen);
    stage_close(&w.stage);
    static const char *const sources[] = {"builtin:sky?lights=0", "builtin:glass?lights=40"};
    for (uint32_t i = 0; i < COUNT_OF(sources); i++) {
        struct stage s = open_small(sources[i]);
        seen = run(&s, 3, 0);
        shot_free(&seen);
        stage_close(&s);
    }
}

/* Neither a pass nor a byte without the option, nor with shadows that choose no lights; and what cannot be guided says so. */
static void test_only_where_asked_for(void **state) {
    UNUSED(state);
    struct world w = world_open();
    static char plan[1 << 17];
    for (uint32_t i = 0; i < 3; i++) {
        w.stage.frame.shadow.guide = i > 0;
        struct shot seen = shoot(&w.stage, i == 1 ? FNL_SHADOWS_RAYS : FNL_SHADOWS_SAMPLED, 0);
        assert_true(fnl_renderer_print(w.stage.renderer, FNL_PRINT_PLAN, plan, sizeof plan) < sizeof plan);
        assert_int_equal(strstr(plan, "shadow guide") != NULL, i == 2);
        assert_int_equal(strstr(plan, "kept shadow rays") != NULL, i == 2);
        shot_free(&seen);
    }
    fnl_frame frame = w.stage.frame;
    frame.shading = FNL_SHADING_FORWARD;
    assert_int_equal(fnl_renderer_render(w.stage.renderer, &frame), FNL_ERROR_UNSUPPORTED);
    frame.shading = FNL_SHADING_AUTO;
    assert_int_equal(fnl_renderer_render(w.stage.renderer, &frame), FNL_ERROR_UNSUPPORTED);
    frame.shadows = FNL_SHADOWS_RAYS; /* which it says nothing to */
    frame.shading = FNL_SHADING_FORWARD;
    assert_int_equal(fnl_renderer_render(w.stage.renderer, &frame), FNL_OK);
    frame = w.stage.frame;
    frame.msaa = 4;
    assert_int_equal(fnl_renderer_render(w.stage.renderer, &frame), FNL_ERROR_UNSUPPORTED);
    frame = w.stage.frame;
    frame.deferred.class_blocks = 8;
    assert_int_equal(fnl_renderer_render(w.stage.renderer, &frame), FNL_ERROR_UNSUPPORTED);
    frame = w.stage.frame;
    frame.deferred.pass = FNL_DEFERRED_FRAGMENT;
    assert_int_equal(fnl_renderer_render(w.stage.renderer, &frame), FNL_ERROR_UNSUPPORTED);
    stage_close(&w.stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_SH_61_mean_of_guided_frames_is_that_of_rays, harness_check),
        cmocka_unit_test_teardown(test_SH_62_first_frames_are_what_they_are_without, harness_check),
        cmocka_unit_test_teardown(test_SH_63_noise_falls_where_lights_are_hidden_SH_66, harness_check),
        cmocka_unit_test_teardown(test_SH_64_rays_go_where_they_pass, harness_check),
        cmocka_unit_test_teardown(test_SH_65_lights_are_found_again, harness_check),
        cmocka_unit_test_teardown(test_SH_67_denoised_frames_are_better, harness_check),
        cmocka_unit_test_teardown(test_frames_repeat, harness_check),
        cmocka_unit_test_teardown(test_histories_belong_to_views, harness_check),
        cmocka_unit_test_teardown(test_any_size_and_scene, harness_check),
        cmocka_unit_test_teardown(test_only_where_asked_for, harness_check),
    };
    return cmocka_run_group_tests_name("shadow_guide", tests, harness_begin, harness_end);
}
