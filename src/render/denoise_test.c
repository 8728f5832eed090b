/* SPDX-License-Identifier: MIT */
/* Denoised shadows of lights that are chosen by chance: near to those of rays in few frames, without ghosts, and exact where nothing is in doubt. */
#include "tests/render_harness.h"
#include "tests/trace_world.h"

enum { SIDE = 64, LAMPS = 12 };

/* ---- worlds ---- */

/* Two floors, dark and bright, that shine; coloured lamps in a ring above them, one far brighter than the others; squares that throw shadows. Lamps may be
   farther away, and as much stronger. */
struct world {
    struct stage stage;
    fnl_light_id bright;
    fnl_light_params lamp; /* the bright one */
    fnl_instance_id square;
};

static mat4 square_at(float x) { return mat4_mul(mat4_translation((vec3){x, 1, 0}), mat4_scaling((vec3){0.4f, 1, 0.4f})); }

static struct world world_open(bool shadows, float away) {
    struct world w = {0};
    fnl_scene *scene = world_create(NULL);
    for (int side = 0; side < 2; side++) {
        fnl_material_params floor = fnl_material_params_default();
        for (int k = 0; k < 3; k++) floor.base_color[k] = side ? 0.8f : 0.02f;
        floor.metallic = 0, floor.roughness = 0.3f;
        add_square(scene, &floor, (vec3){2, 1, 4}, (vec3){side ? 2 : -2, 0, 0});
    }
    const fnl_material_params grey = matt(0.5f);
    for (int i = 0; i < 16; i++) {
        const vec3 at = {(float)(i % 4) - 1.5f, 1.5f, (float)(i / 4) - 1.5f}, size = {0.2f, 1, 0.2f};
        add_instance(scene, add_square_mesh(scene, add_material(scene, &grey)), mat4_mul(mat4_translation(at), mat4_scaling(size)));
    }
    w.square = add_instance(scene, add_square_mesh(scene, add_material(scene, &grey)), square_at(-0.5f));
    for (uint32_t i = 0; i < LAMPS; i++) {
        fnl_light_params lamp = fnl_light_params_default();
        fnl_light_id id;
        lamp.position = (vec3){1.5f * away * cosf((float)i * 0.5236f), 3 * away, 1.5f * away * sinf((float)i * 0.5236f)};
        lamp.intensity = (i ? 4 : 60) * away * away, lamp.range = 30 * away, lamp.casts_shadows = shadows;
        for (uint32_t k = 0; k < 3 && i; k++) lamp.color[k] = (i + k) % 3 ? 0.3f : 1;
        assert_int_equal(fnl_scene_add_light(scene, &lamp, &id), FNL_OK);
        if (i == 0) w.bright = id, w.lamp = lamp;
    }
    w.stage = stage_open_scene(scene);
    fnl_frame *frame = &w.stage.frame;
    frame->width = frame->height = SIDE;
    frame->camera = fnl_camera_default();
    frame->camera.position = (vec3){0, 6, 3}, frame->camera.target = (vec3){0, 0, 0};
    frame->camera.orthographic = false, frame->camera.vertical_fov = 0.7f;
    frame->shadow.denoise = true;
    frame->outputs = FNL_OUTPUT_RADIANCE;
    return w;
}

static struct stage open_small(const char *source) {
    struct stage s = stage_open(source, 0);
    s.frame.width = 65, s.frame.height = 37, s.frame.ev = 1;
    s.frame.shadow.denoise = true;
    s.frame.outputs = FNL_OUTPUT_RADIANCE;
    return s;
}

static struct shot shoot(struct stage *s, fnl_shadows shadows) {
    s->frame.shadows = shadows;
    struct shot shot = stage_shoot(s, &s->frame);
    assert_int_equal(count_broken(&shot.radiance), 0);
    return shot;
}

/* Rays by a renderer of its own: the other one keeps its history. */
static struct shot shoot_rays(struct stage *s) {
    struct stage other = *s;
    assert_int_equal(fnl_renderer_create(harness_device(), s->scene, &other.renderer), FNL_OK);
    other.frame.debug = FNL_DEBUG_NONE;
    struct shot shot = shoot(&other, FNL_SHADOWS_RAYS);
    fnl_renderer_destroy(&other.renderer);
    return shot;
}

/* Frames whose pictures do not matter; returns the last one. */
static struct shot run(struct stage *s, uint32_t frames) {
    struct shot shot = {0};
    for (uint32_t i = 0; i < frames; i++) {
        shot_free(&shot);
        shot = shoot(s, FNL_SHADOWS_SAMPLED);
    }
    return shot;
}

/* Root mean square of the difference of x / (1 + x). */
static double error_of(const struct shot *a, const struct shot *b) {
    const size_t values = (size_t)a->radiance.width * a->radiance.height * 4;
    const float *x = a->radiance.pixels, *y = b->radiance.pixels;
    double square = 0;
    for (size_t i = 0; i < values; i++) {
        const double e = (double)x[i] / (1 + (double)x[i]) - (double)y[i] / (1 + (double)y[i]);
        square += e * e;
    }
    return sqrt(square / (double)values);
}

static double sum_of(const struct shot *shot) {
    const float *x = shot->radiance.pixels;
    double sum = 0;
    for (size_t i = 0; i < (size_t)shot->radiance.width * shot->radiance.height; i++)
        sum += 0.2126 * (double)x[4 * i] + 0.7152 * (double)x[4 * i + 1] + 0.0722 * (double)x[4 * i + 2];
    return sum;
}

/* ---- what is seen ---- */

/* Light without shadows has no noise, and nothing of it is blurred: neither the border of two floors nor highlights. */
static void test_SH_46_open_light_is_exact(void **state) {
    UNUSED(state);
    struct world w = world_open(false, 1);
    struct shot rays = shoot(&w.stage, FNL_SHADOWS_RAYS), seen = shoot(&w.stage, FNL_SHADOWS_SAMPLED);
    const float *a = rays.radiance.pixels, *b = seen.radiance.pixels;
    for (uint32_t i = 0; i < SIDE * SIDE * 4; i++) assert_float_equal(b[i], a[i], 3e-3 * (double)a[i]);
    assert_int_equal(counter(&seen.stats, "shadows.denoised"), SIDE * SIDE);
    shot_free(&rays);
    shot_free(&seen);
    stage_close(&w.stage);
}

/* Where there are as many rays as lights shadows are those of rays, sharp from the first frame on. */
static void test_SH_47_few_lights_are_exact(void **state) {
    UNUSED(state);
    struct world w = world_open(true, 1);
    w.stage.frame.shadow.rays = LAMPS;
    struct shot rays = shoot(&w.stage, FNL_SHADOWS_RAYS), seen = shoot(&w.stage, FNL_SHADOWS_SAMPLED);
    const float *a = rays.radiance.pixels, *b = seen.radiance.pixels;
    for (uint32_t i = 0; i < SIDE * SIDE * 4; i++) assert_float_equal(b[i], a[i], 1e-3 + 3e-3 * (double)a[i]);
    assert_int_equal(counter(&seen.stats, "shadows.denoised"), 0);
    shot_free(&rays);
    shot_free(&seen);
    stage_close(&w.stage);
}

/* Errors of one frame as it is, of one denoised, and of those after 8 and 48 of a still scene. The mean of frames without history is that of rays,
   but for what blurring takes. */
static void test_SH_48_still_frames_come_close_to_rays(void **state) {
    UNUSED(state);
    struct stage s = open_small("builtin:interior?lights=300");
    struct shot rays = shoot_rays(&s), seen = {0};
    double errors[4] = {0}, sum = 0;
    s.frame.shadow.denoise = false;
    seen = shoot(&s, FNL_SHADOWS_SAMPLED);
    errors[0] = error_of(&seen, &rays);
    s.frame.shadow.denoise = true;
    for (uint32_t n = 1; n <= 48; n++) {
        shot_free(&seen);
        seen = shoot(&s, FNL_SHADOWS_SAMPLED);
        if (n == 1 || n == 8 || n == 48) errors[n == 1 ? 1 : n == 8 ? 2 : 3] = error_of(&seen, &rays);
        if (n == 8) assert_int_equal(counter(&seen.stats, "shadows.frames"), 8);
    }
    for (uint32_t n = 0; n < 8; n++) {
        shot_free(&seen);
        s.frame.reset_history = true;
        s.frame.shadow.seed = 100 + n;
        seen = shoot(&s, FNL_SHADOWS_SAMPLED);
        sum += sum_of(&seen) / 8;
        assert_int_equal(counter(&seen.stats, "shadows.fresh"), counter(&seen.stats, "shadows.denoised"));
    }
    const double bias = sum / sum_of(&rays) - 1;
    print_message("errors %.3g, denoised %.3g, 8 frames %.3g, 48 frames %.3g; bias of one frame %.2g\n", errors[0], errors[1], errors[2], errors[3], bias);
    assert_true(errors[1] < errors[0] / 2.2);
    assert_true(errors[2] < errors[0] / 6);
    assert_true(errors[3] < errors[0] / 12);
    assert_true(fabs(bias) < 0.02);
    shot_free(&seen);
    shot_free(&rays);
    stage_close(&s);
}

/* History follows surfaces: of a moving camera frames are better than without. */
static void test_SH_49_history_follows_the_camera(void **state) {
    UNUSED(state);
    struct world w = world_open(true, 1);
    fnl_frame *frame = &w.stage.frame;
    struct shot seen = run(&w.stage, 1);
    for (int n = 0; n < 12; n++) {
        frame->camera.position.x += 0.1f, frame->camera.target.x += 0.1f; /* about a pixel */
        shot_free(&seen);
        seen = shoot(&w.stage, FNL_SHADOWS_SAMPLED);
    }
    struct shot rays = shoot_rays(&w.stage);
    const double moving = error_of(&seen, &rays);
    const uint64_t frames = counter(&seen.stats, "shadows.frames"), fresh = counter(&seen.stats, "shadows.fresh");
    frame->reset_history = true;
    shot_free(&seen);
    seen = shoot(&w.stage, FNL_SHADOWS_SAMPLED);
    const double alone = error_of(&seen, &rays);
    print_message("moving %.3g, without history %.3g; %u frames, %u fresh\n", moving, alone, (uint32_t)frames, (uint32_t)fresh);
    assert_true(moving < 0.85 * alone);
    assert_in_range(frames, 9, 13);
    assert_true(fresh < SIDE * SIDE / 20); /* at the border of the picture */
    shot_free(&seen);
    shot_free(&rays);
    stage_close(&w.stage);
}

/* What comes to light from behind something has none, even where the light is the same everywhere and only the plane tells. */
static void test_SH_52_what_was_hidden_has_no_history(void **state) {
    UNUSED(state);
    struct world w = world_open(true, 100);
    fnl_frame *frame = &w.stage.frame;
    struct shot seen = run(&w.stage, 4);
    frame->camera.position.z += 1;
    shot_free(&seen);
    seen = shoot(&w.stage, FNL_SHADOWS_SAMPLED);
    const uint64_t fresh = counter(&seen.stats, "shadows.fresh");
    print_message("%u fresh\n", (uint32_t)fresh);
    assert_in_range(fresh, 700, 1000); /* 598 come in at the border */
    shot_free(&seen);
    stage_close(&w.stage);
}

/* ---- ghosts ---- */

/* The error of frames after a change, over that of a renderer that starts with it. */
static void expect_no_ghosts(struct world *w, const char *what, const double limits[4]) {
    static const uint32_t at[4] = {1, 4, 8, 16};
    struct shot rays = shoot_rays(&w->stage);
    struct stage fresh = w->stage;
    assert_int_equal(fnl_renderer_create(harness_device(), w->stage.scene, &fresh.renderer), FNL_OK);
    struct shot first = shoot(&fresh, FNL_SHADOWS_SAMPLED);
    const double alone = error_of(&first, &rays);
    for (uint32_t i = 0, n = 0; i < COUNT_OF(at); i++) {
        struct shot seen = run(&w->stage, at[i] - n);
        const double error = error_of(&seen, &rays) / alone;
        n = at[i];
        print_message("%s, frame %u: error %.2f of one without history; %u fresh, %u refuted\n", what, n, error,
                      (uint32_t)counter(&seen.stats, "shadows.fresh"), (uint32_t)counter(&seen.stats, "shadows.refuted"));
        if (error > limits[i]) fail_msg("%s, frame %u: %g > %g", what, n, error, limits[i]);
        shot_free(&seen);
    }
    shot_free(&first);
    shot_free(&rays);
    fnl_renderer_destroy(&fresh.renderer);
}

/* A light that jumps, and one that goes out, leave nothing behind, from the first frame on. */
static void test_SH_50_lights_leave_no_ghosts(void **state) {
    UNUSED(state);
    struct world w = world_open(true, 1);
    struct shot seen = run(&w.stage, 32);
    shot_free(&seen);
    w.lamp.position.x = -1.5f;
    assert_int_equal(fnl_scene_set_light(w.stage.scene, w.bright, &w.lamp), FNL_OK);
    expect_no_ghosts(&w, "a light jumps", (const double[]){1.2, 0.9, 0.7, 0.6});
    w.lamp.intensity = 0.01f;
    assert_int_equal(fnl_scene_set_light(w.stage.scene, w.bright, &w.lamp), FNL_OK);
    expect_no_ghosts(&w, "a light goes out", (const double[]){1.2, 0.9, 0.7, 0.6});
    stage_close(&w.stage);
}

/* What moves takes its shadow along, though no light changes. */
static void test_SH_51_shadows_leave_no_ghosts(void **state) {
    UNUSED(state);
    struct world w = world_open(true, 1);
    struct shot seen = run(&w.stage, 32);
    shot_free(&seen);
    const mat4 place = square_at(0.5f);
    assert_int_equal(fnl_scene_set_instance_transform(w.stage.scene, w.square, &place), FNL_OK);
    expect_no_ghosts(&w, "a square jumps", (const double[]){0.8, 0.6, 0.5, 0.4});
    stage_close(&w.stage);
}

/* ---- limits ---- */

static void test_histories_belong_to_views(void **state) {
    UNUSED(state);
    struct world w = world_open(true, 1);
    fnl_frame *frame = &w.stage.frame;
    fnl_camera cameras[2] = {frame->camera, frame->camera};
    cameras[1].position.z = -3;
    frame->views = cameras, frame->view_count = 2;
    struct shot seen = run(&w.stage, 5);
    for (uint32_t i = 0; i < 2; i++) assert_int_equal(counter(&seen.stats.views[i], "shadows.frames"), 5);
    frame->view_count = 0; /* other views, another size: no history */
    shot_free(&seen);
    seen = run(&w.stage, 1);
    assert_int_equal(counter(&seen.stats, "shadows.frames"), 1);
    frame->width = 31;
    shot_free(&seen);
    seen = run(&w.stage, 1);
    assert_int_equal(counter(&seen.stats, "shadows.frames"), 1);
    shot_free(&seen);
    seen = run(&w.stage, 1);
    assert_int_equal(counter(&seen.stats, "shadows.frames"), 2);
    frame->aa = FNL_ANTIALIASING_TAA;
    shot_free(&seen);
    seen = run(&w.stage, 2);
    assert_int_equal(counter(&seen.stats, "shadows.frames"), 4);
    shot_free(&seen);
    stage_close(&w.stage);
}

static void test_any_size_and_scene(void **state) {
    UNUSED(state);
    struct world w = world_open(true, 1);
    static const uint32_t sizes[][2] = {{1, 1}, {113, 65}, {7, 33}};
    for (uint32_t i = 0; i < COUNT_OF(sizes); i++) {
        w.stage.frame.width = sizes[i][0], w.stage.frame.height = sizes[i][1];
        struct shot seen = run(&w.stage, 2);
        assert_in_range(counter(&seen.stats, "shadows.denoised"), 1, sizes[i][0] * sizes[i][1]);
        shot_free(&seen);
    }
    w.stage.frame.camera.target = (vec3){0, 20, 0}; /* sky */
    struct shot seen = run(&w.stage, 2);
    assert_int_equal(counter(&seen.stats, "shadows.denoised"), 0);
    shot_free(&seen);
    stage_close(&w.stage);
    static const char *const sources[] = {"builtin:sky?lights=0", "builtin:hall?lights=0", "builtin:glass?lights=40"};
    for (uint32_t i = 0; i < COUNT_OF(sources); i++) {
        struct stage s = open_small(sources[i]);
        struct shot rays = shoot_rays(&s);
        seen = run(&s, 3);
        if (i < 2) assert_int_equal(count_differing(&rays.radiance, &seen.radiance), 0);
        shot_free(&rays);
        shot_free(&seen);
        stage_close(&s);
    }
}

static void test_frames_repeat(void **state) {
    UNUSED(state);
    struct shot shots[2];
    for (uint32_t i = 0; i < 2; i++) {
        struct world w = world_open(true, 1);
        shots[i] = run(&w.stage, 3);
        stage_close(&w.stage);
    }
    assert_int_equal(count_differing(&shots[0].radiance, &shots[1].radiance), 0);
    for (uint32_t i = 0; i < 2; i++) shot_free(&shots[i]);
}

/* No passes without the option, nor with shadows that have no noise; and what cannot denoise says so. */
static void test_only_where_asked_for(void **state) {
    UNUSED(state);
    struct world w = world_open(true, 1);
    static char plan[1 << 17];
    for (uint32_t i = 0; i < 3; i++) {
        w.stage.frame.shadow.denoise = i > 0;
        struct shot seen = shoot(&w.stage, i < 2 ? FNL_SHADOWS_RAYS : FNL_SHADOWS_SAMPLED);
        assert_true(fnl_renderer_print(w.stage.renderer, FNL_PRINT_PLAN, plan, sizeof plan) < sizeof plan);
        assert_int_equal(strstr(plan, "denoise") != NULL, i == 2);
        assert_int_equal(has_counter(&seen.stats, "shadows.denoised"), i == 2);
        shot_free(&seen);
    }
    fnl_frame frame = w.stage.frame;
    frame.debug = FNL_DEBUG_SHADOW_HISTORY;
    assert_int_equal(fnl_renderer_render(w.stage.renderer, &frame), FNL_OK);
    frame.debug = FNL_DEBUG_SHADOW_VARIANCE;
    assert_int_equal(fnl_renderer_render(w.stage.renderer, &frame), FNL_OK);
    frame.shadow.denoise = false;
    assert_int_equal(fnl_renderer_render(w.stage.renderer, &frame), FNL_ERROR_UNSUPPORTED);
    frame = w.stage.frame;
    frame.shading = FNL_SHADING_FORWARD;
    assert_int_equal(fnl_renderer_render(w.stage.renderer, &frame), FNL_ERROR_UNSUPPORTED);
    frame.shading = FNL_SHADING_AUTO;
    assert_int_equal(fnl_renderer_render(w.stage.renderer, &frame), FNL_ERROR_UNSUPPORTED);
    frame = w.stage.frame;
    frame.msaa = 4;
    assert_int_equal(fnl_renderer_render(w.stage.renderer, &frame), FNL_ERROR_UNSUPPORTED);
    frame = w.stage.frame;
    frame.deferred.class_blocks = 8;
    assert_int_equal(fnl_renderer_render(w.stage.renderer, &frame), FNL_ERROR_UNSUPPORTED);
    stage_close(&w.stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_SH_46_open_light_is_exact, harness_check),
        cmocka_unit_test_teardown(test_SH_47_few_lights_are_exact, harness_check),
        cmocka_unit_test_teardown(test_SH_48_still_frames_come_close_to_rays, harness_check),
        cmocka_unit_test_teardown(test_SH_49_history_follows_the_camera, harness_check),
        cmocka_unit_test_teardown(test_SH_52_what_was_hidden_has_no_history, harness_check),
        cmocka_unit_test_teardown(test_SH_50_lights_leave_no_ghosts, harness_check),
        cmocka_unit_test_teardown(test_SH_51_shadows_leave_no_ghosts, harness_check),
        cmocka_unit_test_teardown(test_histories_belong_to_views, harness_check),
        cmocka_unit_test_teardown(test_any_size_and_scene, harness_check),
        cmocka_unit_test_teardown(test_frames_repeat, harness_check),
        cmocka_unit_test_teardown(test_only_where_asked_for, harness_check),
    };
    return cmocka_run_group_tests_name("shadow_denoise", tests, harness_begin, harness_end);
}
