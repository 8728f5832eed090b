/* SPDX-License-Identifier: MIT */
/** What nobody sees costs nothing, and what is seen stays as it was (VR-7). */
#include "tests/render_harness.h"

enum { WIDTH = 96, HEIGHT = 90, SEGMENTS = 48, MARGIN = 1 };

static const fnl_rigid_pose nowhere = {{0, 0, 0}, {0, 0, 0, 1}};
static fnl_vec2 corners[2][FNL_HIDDEN_ROUND_CORNERS(SEGMENTS)];

struct eyes {
    fnl_eye eyes[2];
    fnl_camera cameras[2];
    fnl_hidden_area areas[2];
};

/* Two eyes with edges that are not symmetric, and a circle that touches the shorter sides. */
static struct eyes place_eyes(const fnl_camera *at, float radius) {
    struct eyes e = {.eyes = {{{{-0.032f, 0, 0}, {0, 0, 0, 1}}, -1.1f, 0.9f, -0.95f, 0.95f}, {{{0.032f, 0, 0}, {0, 0, 0, 1}}, -0.9f, 1.1f, -0.95f, 0.95f}}};
    const mat4 view = mat4_look_at(at->position, at->target, at->up);
    mat4 world;
    mat4_inverse(&view, &world);
    for (int i = 0; i < 2; i++) {
        assert_int_equal(fnl_eye_query_camera(NULL, &e.eyes[i], &nowhere, WIDTH, HEIGHT, 0.05f, &e.cameras[i]), FNL_OK);
        e.cameras[i].position = mat4_point(&world, e.cameras[i].position);
        e.cameras[i].target = mat4_point(&world, e.cameras[i].target);
        e.cameras[i].up = at->up;
        assert_int_equal(fnl_hidden_area_round(NULL, &e.eyes[i], (fnl_vec2){0, 0}, radius, SEGMENTS, corners[i], &e.areas[i]), FNL_OK);
    }
    return e;
}

/* Of the sample at the middle of a pixel, in tangents from the centre. */
static float radius_at(const fnl_eye *eye, uint32_t x, uint32_t y) {
    const float a = eye->left + (eye->right - eye->left) * ((float)x + 0.5f) / WIDTH, b = eye->up + (eye->down - eye->up) * ((float)y + 0.5f) / HEIGHT;
    return sqrtf(a * a + b * b);
}

/* Bytes of the pixels that are seen are those of `whole`; the hidden ones are black. Within a pixel of the circle either may be. */
static void check_picture(const fnl_image *image, uint32_t view, const fnl_image *whole, const fnl_eye *eye, float radius, uint32_t samples, const char *what) {
    const size_t bytes = fnl_pixel_size(image->format), zeros = image->format == FNL_PIXEL_FORMAT_RGBA8 ? 3 : 12;
    const float step = 1.5f * fmaxf((eye->right - eye->left) / WIDTH, (eye->up - eye->down) / HEIGHT);
    const float inside = samples > 1 ? step : 0; /* samples beside the middle may be hidden */
    uint32_t shown = 0;
    for (uint32_t y = 0; y < HEIGHT; y++)
        for (uint32_t x = 0; x < WIDTH; x++) {
            const size_t at = ((size_t)y * WIDTH + x) * bytes;
            const char *pixel = (const char *)image->pixels + (size_t)view * WIDTH * HEIGHT * bytes + at;
            static const char black[16];
            const float r = radius_at(eye, x, y);
            if (r < radius - inside && memcmp(pixel, (const char *)whole->pixels + at, bytes) != 0) fail_msg("%s: pixel %u %u of view %u changed", what, x, y, view);
            if (r > radius + step && memcmp(pixel, black, zeros) != 0) fail_msg("%s: pixel %u %u of view %u is not black", what, x, y, view);
            shown += r < radius && memcmp(pixel, black, zeros) != 0;
        }
    if (shown < WIDTH * HEIGHT / 4) fail_msg("%s: only %u pixels show something", what, shown);
}

static const struct path {
    fnl_shading shading;
    bool prepass;
    uint32_t msaa;
    const char *source;
} paths[] = {{FNL_SHADING_DEFERRED, false, 1, "builtin:hall?lights=24"},         {FNL_SHADING_DEFERRED, true, 1, "builtin:glass?lights=24"},
             {FNL_SHADING_DEFERRED, false, 4, "builtin:hall?lights=24"},         {FNL_SHADING_FORWARD, false, 1, "builtin:glass?lights=24"},
             {FNL_SHADING_FORWARD_PREPASS, false, 4, "builtin:hall?lights=24"}, {FNL_SHADING_FORWARD_PREPASS, false, 1, "builtin:glass?lights=24"},
             {FNL_SHADING_VISIBILITY, false, 1, "builtin:hall?lights=24"},       {FNL_SHADING_VISIBILITY, false, 4, "builtin:glass?lights=24"}};

static void test_seen_pixels_stay_as_they_were_VR_7(void **state) {
    UNUSED(state);
    const float radius = 0.9f;
    for (uint32_t p = 0; p < COUNT_OF(paths); p++) {
        struct stage stage = stage_open(paths[p].source, 0);
        const struct eyes e = place_eyes(&stage.frame.camera, radius);
        stage.frame.width = WIDTH;
        stage.frame.height = HEIGHT;
        stage.frame.shading = paths[p].shading;
        stage.frame.gbuffer.prepass = paths[p].prepass;
        stage.frame.msaa = paths[p].msaa;
        stage.frame.lists = FNL_LISTS_CLUSTERED;
        fnl_frame both = stage.frame;
        both.views = e.cameras;
        both.view_count = 2;
        both.hidden_areas = e.areas;
        both.stereo.eyes = p % 3 == 0 ? 2 : 0;
        both.stereo.path = p % 2 ? FNL_STEREO_PATH_MULTIVIEW : FNL_STEREO_PATH_INSTANCES;
        if (!both.stereo.eyes) both.multiview = p % 2 ? FNL_MULTIVIEW_ON : FNL_MULTIVIEW_OFF;
        struct shot hidden = stage_shoot(&stage, &both);
        for (uint32_t eye = 0; eye < 2; eye++) {
            stage.frame.camera = e.cameras[eye];
            struct shot whole = stage_shoot(&stage, &stage.frame);
            char what[32];
            snprintf(what, sizeof what, "path %u", p);
            check_picture(&hidden.color, eye, &whole.color, &e.eyes[eye], radius, paths[p].msaa, what);
            check_picture(&hidden.radiance, eye, &whole.radiance, &e.eyes[eye], radius, paths[p].msaa, what);
            shot_free(&whole);
        }
        shot_free(&hidden);
        stage_close(&stage);
    }
}

/* Pixels that were shaded at all, and those of them that are hidden: pixels that lights were looked up for. */
static uint32_t count_shaded(const struct stage *stage, const fnl_eye *eye, float radius, uint32_t *hidden) {
    const uint32_t *counters = stage->renderer->views.data[0].counters.mapped;
    uint32_t count = 0;
    *hidden = 0;
    for (uint32_t y = 0; y < HEIGHT; y++)
        for (uint32_t x = 0; x < WIDTH; x++) {
            const bool shaded = counters[2 * (y * WIDTH + x)] > 0;
            count += shaded;
            *hidden += shaded && radius_at(eye, x, y) > radius;
        }
    return count;
}

/* By the area of the mask, as the geometry of a circle in a rectangle has it, within a hundredth. */
static void test_work_falls_by_the_area_VR_7(void **state) {
    UNUSED(state);
    const float radius = 0.8f, half = PI / SEGMENTS;
    static const fnl_shading shadings[] = {FNL_SHADING_DEFERRED, FNL_SHADING_FORWARD_PREPASS, FNL_SHADING_VISIBILITY, FNL_SHADING_FORWARD};
    struct stage stage = stage_open("builtin:hall?lights=6", 0);
    const struct eyes e = place_eyes(&stage.frame.camera, radius);
    stage.frame.camera = e.cameras[0];
    stage.frame.width = WIDTH;
    stage.frame.height = HEIGHT;
    stage.frame.lists = FNL_LISTS_ALL;
    stage.frame.count_lights = true;
    const double area = 1 - (double)(radius * radius * tanf(half) * SEGMENTS) / (2.0 * 1.9);
    for (uint32_t s = 0; s < COUNT_OF(shadings); s++) {
        stage.frame.shading = shadings[s];
        stage.frame.hidden_areas = NULL;
        uint32_t seen_before, seen_after;
        struct shot whole = stage_shoot(&stage, &stage.frame);
        const uint32_t before = count_shaded(&stage, &e.eyes[0], radius / cosf(half), &seen_before);
        stage.frame.hidden_areas = e.areas;
        struct shot less = stage_shoot(&stage, &stage.frame);
        const uint32_t after = count_shaded(&stage, &e.eyes[0], radius / cosf(half), &seen_after);
        const double saved = 1 - (double)after / (double)before;
        if (before < WIDTH * HEIGHT * 99 / 100) fail_msg("only %u pixels are shaded", before);
        if (fabs(saved - area) > 0.01) fail_msg("shading %d saves %.4f of %u pixels, but %.4f are hidden", (int)shadings[s], saved, before, area);
        if (shadings[s] == FNL_SHADING_FORWARD) seen_after = 0; /* the CPU driver tests the depth of cutouts late where they count */
        if (seen_before == 0 || seen_after != 0) fail_msg("shading %d shades %u hidden pixels", (int)shadings[s], seen_after);
        assert_true(less.stats.evaluations < whole.stats.evaluations);
        if (shadings[s] == FNL_SHADING_VISIBILITY) /* overdraw is not spread evenly */
            assert_true(counter(&less.stats, "visibility.fragments") * 10 < counter(&whole.stats, "visibility.fragments") * 6);
        shot_free(&whole);
        shot_free(&less);
    }
    stage_close(&stage);
}

/* A Vive's eye, and a round field that touches its upper and lower edge: the source's figure is 17 % of the fill (VR-7). */
static void test_what_a_vive_saves_VR_7(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:hall?lights=6", 0);
    const struct eyes place = place_eyes(&stage.frame.camera, 1);
    const fnl_eye eye = {nowhere, -1.3955f, 1.2424f, -1.4642f, 1.4642f};
    fnl_hidden_area area;
    fnl_camera camera = place.cameras[0], of_eye;
    assert_int_equal(fnl_eye_query_camera(NULL, &eye, &nowhere, WIDTH, HEIGHT, 0.05f, &of_eye), FNL_OK);
    assert_int_equal(fnl_hidden_area_round(NULL, &eye, (fnl_vec2){0, 0}, 1.4642f, SEGMENTS, corners[0], &area), FNL_OK);
    camera.vertical_fov = of_eye.vertical_fov;
    camera.pixel_aspect = of_eye.pixel_aspect;
    camera.shift = of_eye.shift;
    stage.frame.camera = camera;
    stage.frame.width = WIDTH;
    stage.frame.height = HEIGHT;
    stage.frame.lists = FNL_LISTS_ALL;
    stage.frame.count_lights = true;
    uint32_t seen;
    struct shot whole = stage_shoot(&stage, &stage.frame);
    const uint32_t before = count_shaded(&stage, &eye, 1.47f, &seen);
    stage.frame.hidden_areas = &area;
    struct shot less = stage_shoot(&stage, &stage.frame);
    const uint32_t after = count_shaded(&stage, &eye, 1.47f, &seen);
    const double saved = 100 - 100.0 * after / before;
    printf("hidden area of a Vive: source 17 %%, ours %.1f %% fewer pixels shaded: as the source says\n", saved);
    assert_float_equal((float)saved, 16.4f, 1);
    shot_free(&whole);
    shot_free(&less);
    stage_close(&stage);
}

/* Metering passes over what is hidden: with it the picture would come out brighter. */
static void test_exposure_is_that_of_what_is_seen(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:hall?lights=24", 0);
    struct eyes e = place_eyes(&stage.frame.camera, 0.6f);
    stage.frame.camera = e.cameras[0];
    stage.frame.width = WIDTH;
    stage.frame.height = HEIGHT;
    stage.frame.exposure = FNL_EXPOSURE_AUTO;
    struct shot whole = stage_shoot(&stage, &stage.frame);
    stage.frame.hidden_areas = e.areas;
    struct shot less = stage_shoot(&stage, &stage.frame);
    if (fabsf(less.stats.ev - whole.stats.ev) > 1) fail_msg("EV %g instead of %g", (double)less.stats.ev, (double)whole.stats.ev);
    shot_free(&less);
    shot_free(&whole);
    /* With no corners the frame is as without an area. */
    e.areas[0].corner_count = 0;
    stage.frame.hidden_areas = NULL;
    struct shot a = stage_shoot(&stage, &stage.frame);
    stage.frame.hidden_areas = e.areas;
    struct shot b = stage_shoot(&stage, &stage.frame);
    assert_int_equal(count_differing(&a.color, &b.color), 0);
    shot_free(&a);
    shot_free(&b);
    stage_close(&stage);
}

/* A frame that was warmed up compiles nothing, for one view and for two at once, by multiview and by instances. */
static void test_pipelines_ahead_of_frames(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:hall?lights=2", 0);
    const struct eyes e = place_eyes(&stage.frame.camera, 0.9f);
    stage.frame.msaa = 4;
    stage.frame.lists = FNL_LISTS_ALL;
    stage.frame.hidden_areas = e.areas;
    stage.frame.views = e.cameras;
    for (uint32_t n = 0; n < 3; n++) {
        fnl_frame_stats stats;
        stage.frame.view_count = n ? 2 : 0;
        stage.frame.multiview = n < 2 ? FNL_MULTIVIEW_ON : FNL_MULTIVIEW_AUTO;
        stage.frame.stereo.eyes = n < 2 ? 0 : 2;
        stage.frame.stereo.path = FNL_STEREO_PATH_INSTANCES;
        assert_int_equal(fnl_renderer_warm(stage.renderer, &stage.frame, NULL, true, NULL), FNL_OK);
        assert_int_equal(fnl_renderer_render(stage.renderer, &stage.frame), FNL_OK);
        assert_int_equal(fnl_renderer_query_stats(stage.renderer, &stats), FNL_OK);
        assert_int_equal(stats.pipelines_made, 0);
    }
    stage_close(&stage);
}

static void test_what_has_no_hidden_areas(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:hall?lights=2", 0);
    struct eyes e = place_eyes(&stage.frame.camera, 0.6f);
    fnl_frame frame = stage.frame;
    frame.hidden_areas = e.areas;
    frame.shading = FNL_SHADING_MOBILE;
    assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_ERROR_UNSUPPORTED);
    frame.shading = FNL_SHADING_COARSE;
    frame.coarse.fovea = 10;
    assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_ERROR_UNSUPPORTED);
    frame.shading = FNL_SHADING_FORWARD;
    frame.lists = FNL_LISTS_BATCHES;
    assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_ERROR_UNSUPPORTED);
    frame.lists = FNL_LISTS_ALL;
    frame.camera.orthographic = true;
    assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_ERROR_UNSUPPORTED);
    frame.camera.orthographic = false;
    e.areas[0].corner_count = 4;
    assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_ERROR_INVALID);
    e.areas[0].corner_count = 3;
    e.areas[0].corners = NULL;
    assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_ERROR_INVALID);
    frame.hidden_areas = NULL;
    frame.shading = FNL_SHADING_AUTO;
    assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_OK);
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_pipelines_ahead_of_frames, harness_check), /* before others make them */
        cmocka_unit_test_teardown(test_seen_pixels_stay_as_they_were_VR_7, harness_check),
        cmocka_unit_test_teardown(test_work_falls_by_the_area_VR_7, harness_check),
        cmocka_unit_test_teardown(test_what_a_vive_saves_VR_7, harness_check),
        cmocka_unit_test_teardown(test_exposure_is_that_of_what_is_seen, harness_check),
        cmocka_unit_test_teardown(test_what_has_no_hidden_areas, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
