/* SPDX-License-Identifier: MIT */
/** Resolution that falls towards the edges (VR-11). */
#include "tests/render_harness.h"

static const fnl_eye eye = {{{0, 0, 0}, {0, 0, 0, 1}}, -1.1f, 0.9f, -1, 1};

static void test_cells_cover_the_picture_VR_11(void **state) {
    UNUSED(state);
    static const uint32_t sizes[][2] = {{3, 3}, {64, 37}, {101, 100}};
    for (uint32_t s = 0; s < COUNT_OF(sizes); s++)
        for (uint32_t k = 1; k <= 10; k++) {
            fnl_eye_cell cells[9];
            uint64_t covered = 0;
            assert_int_equal(fnl_eye_query_cells(NULL, &eye, sizes[s][0], sizes[s][1], (float)k / 10, 0.5f, cells), FNL_OK);
            for (uint32_t i = 0; i < 9; i++) {
                const fnl_eye_cell *c = &cells[i];
                covered += (uint64_t)c->width * c->height;
                assert_true(c->width > 0 && c->height > 0 && c->rendered_width > 0 && c->rendered_width <= c->width);
                assert_float_equal(c->eye.left, eye.left + (eye.right - eye.left) * (float)c->x / (float)sizes[s][0], 1e-5f);
                assert_float_equal(c->eye.down, eye.up + (eye.down - eye.up) * (float)(c->y + c->height) / (float)sizes[s][1], 1e-5f);
                if (i % 3 < 2) assert_int_equal(c->x + c->width, cells[i + 1].x);
                if (i < 6) assert_int_equal(c->y + c->height, cells[i + 3].y);
            }
            assert_int_equal(covered, sizes[s][0] * sizes[s][1]);
            assert_int_equal(cells[0].width, cells[8].width);
            assert_int_equal(cells[4].rendered_width, cells[4].width);
        }
}

enum { WIDTH = 100, HEIGHT = 90 };

static fnl_camera camera_of(const fnl_eye *of, const fnl_camera *at, uint32_t width, uint32_t height) {
    fnl_camera camera;
    const vec3 forward = vec3_normalize(vec3_sub(at->target, at->position));
    const fnl_rigid_pose head = {at->position, quat_axis_angle(vec3_make(0, 1, 0), atan2f(-forward.x, -forward.z))};
    assert_int_equal(fnl_eye_query_camera(NULL, of, &head, width, height, 0.05f, &camera), FNL_OK);
    return camera;
}

/* The middle is as in the whole picture; the borders cost less and come close to it. */
static void test_the_middle_stays_as_it_was_VR_11(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:hall?lights=100", 0);
    fnl_eye_cell cells[9];
    assert_int_equal(fnl_eye_query_cells(NULL, &eye, WIDTH, HEIGHT, 0.6f, 0.5f, cells), FNL_OK);
    const fnl_camera at = stage.frame.camera;
    stage.frame.width = WIDTH;
    stage.frame.height = HEIGHT;
    stage.frame.ev = 1;
    stage.frame.lists = FNL_LISTS_CLUSTERED;
    stage.frame.camera = camera_of(&eye, &at, WIDTH, HEIGHT);
    struct shot whole = stage_shoot(&stage, &stage.frame);
    uint64_t shaded = 0;
    double inner = 0, outer = 0;
    static const uint32_t groups[4][4] = {{4}, {0, 2, 6, 8}, {3, 5}, {1, 7}};
    static const uint32_t counts[4] = {1, 4, 2, 2};
    for (uint32_t g = 0; g < 4; g++) { /* cells of one size are views of one frame */
        fnl_camera cameras[4];
        fnl_frame frame = stage.frame;
        const fnl_eye_cell *first = &cells[groups[g][0]];
        frame.width = first->rendered_width;
        frame.height = first->rendered_height;
        for (uint32_t i = 0; i < counts[g]; i++) cameras[i] = camera_of(&cells[groups[g][i]].eye, &at, frame.width, frame.height);
        frame.views = cameras;
        frame.view_count = counts[g];
        struct shot shot = stage_shoot(&stage, &frame);
        shaded += (uint64_t)frame.width * frame.height * counts[g];
        for (uint32_t i = 0; i < counts[g]; i++) {
            const fnl_eye_cell *c = &cells[groups[g][i]];
            for (uint32_t y = 0; y < c->height; y++)
                for (uint32_t x = 0; x < c->width; x++) {
                    const uint8_t *a = (const uint8_t *)whole.color.pixels + 4 * ((c->y + y) * WIDTH + c->x + x);
                    const uint32_t row = i * frame.height + y * frame.height / c->height, column = x * frame.width / c->width;
                    const uint8_t *b = (const uint8_t *)shot.color.pixels + 4 * (row * frame.width + column);
                    for (uint32_t ch = 0; ch < 3; ch++) *(g ? &outer : &inner) += (a[ch] - b[ch]) * (a[ch] - b[ch]) / 65025.0;
                }
        }
        shot_free(&shot);
    }
    const double values = 3.0 * WIDTH * HEIGHT, middle = 3.0 * cells[4].width * cells[4].height;
    const double inner_psnr = -10 * log10(inner / middle + 1e-12), outer_psnr = -10 * log10(outer / (values - middle) + 1e-12), part = (double)shaded / (WIDTH * HEIGHT);
    printf("3 x 3 cells: %.1f dB in the middle, %.1f dB in the borders, %.0f %% of the pixels\n", inner_psnr, outer_psnr, part * 100);
    if (inner_psnr < 45) fail_msg("the middle has %.1f dB", inner_psnr);
    assert_true(outer_psnr > 12 && part < 0.7);
    shot_free(&whole);
    stage_close(&stage);
}

static void test_lens_matched_places_come_back_VR_11(void **state) {
    UNUSED(state);
    const fnl_vec2 strength = {0.35f, 0.5f};
    for (int y = -20; y <= 20; y++)
        for (int x = -20; x <= 20; x++) {
            const fnl_vec2 place = {(float)x / 20, (float)y / 20}, there = fnl_lens_matched_place(strength, place, false), again = fnl_lens_matched_place(strength, there, true);
            assert_true(fabsf(there.x) <= fabsf(place.x) && fabsf(there.y) <= fabsf(place.y));
            assert_float_equal(again.x, place.x, 1e-5f);
            assert_float_equal(again.y, place.y, 1e-5f);
        }
    const fnl_vec2 corner = fnl_lens_matched_place(strength, (fnl_vec2){1, -1}, false);
    assert_float_equal(corner.x, 1 / 1.85f, 1e-6f);
    assert_float_equal(corner.y, -1 / 1.85f, 1e-6f);
}

/* ---- coarse.fovea: rates by the angle from where the viewer looks ---- */

/* How many pixels across block (x, y) of `size` shares, as the header says it; 0: too near to a limit to tell. */
static uint32_t side_at(const fnl_frame *frame, const fnl_camera *camera, const fnl_vec3 *gaze, uint32_t x, uint32_t y) {
    const uint32_t size = frame->coarse.size;
    const vec3 back = vec3_normalize(vec3_sub(camera->position, camera->target)), right = vec3_normalize(vec3_cross(camera->up, back)), up = vec3_cross(back, right);
    const float tangent = tanf(camera->vertical_fov / 2), aspect = camera->pixel_aspect * (float)frame->width / (float)frame->height;
    const float u = 2 * ((float)x + 0.5f * (float)size) / (float)frame->width - 1, v = 1 - 2 * ((float)y + 0.5f * (float)size) / (float)frame->height;
    const vec3 to = vec3_sub(vec3_add(vec3_scale(right, (u - camera->shift.x) * tangent * aspect), vec3_scale(up, (v - camera->shift.y) * tangent)), back);
    const vec3 look = gaze ? vec3_sub(*gaze, camera->position) : vec3_scale(back, -1);
    const float angle = acosf(fminf(fmaxf(vec3_dot(vec3_normalize(to), vec3_normalize(look)), -1), 1)) * (180 / PI);
    const float far = fmaxf(frame->coarse.fovea, frame->coarse.fovea_far);
    if (fabsf(angle - frame->coarse.fovea) < 0.02f || (size == 4 && fabsf(angle - far) < 0.02f)) return 0;
    return angle < frame->coarse.fovea ? 1 : size == 4 && angle < far ? 2 : size;
}

/* Blocks where the viewer looks are as in `reference` to the bit, and so is the background; all others are lit as often as their side says. */
static void check_fovea(const fnl_frame *frame, const fnl_camera *camera, const fnl_vec3 *gaze, const struct shot *shot, const struct shot *reference) {
    const uint32_t size = frame->coarse.size, width = frame->width, height = frame->height;
    const vec4 *radiance = shot->radiance.pixels, *wanted = reference->radiance.pixels, *normals = shot->normal.pixels;
    uint64_t shaded = 0, open = 0, shown = 0, near = 0, differing = 0;
    for (uint32_t y = 0; y < height; y += size)
        for (uint32_t x = 0; x < width; x += size) {
            const uint32_t side = side_at(frame, camera, gaze, x, y);
            uint32_t parts = 0; /* a bit for each that shows a surface */
            for (uint32_t v = y; v < MIN(y + size, height); v++)
                for (uint32_t u = x; u < MIN(x + size, width); u++) {
                    const size_t at = (size_t)v * width + u;
                    const bool surface = normals[at].w > 0, same = memcmp(&radiance[at], &wanted[at], sizeof *radiance) == 0;
                    shown += surface;
                    if (surface && side) parts |= 1u << ((v - y) / side * size / side + (u - x) / side);
                    if ((side == 1 || !surface) && !same) fail_msg("pixel %u, %u is not as in deferred", u, v);
                    near += side == 1 && surface;
                    differing += !same;
                }
            open += side ? 0 : size * size;
            for (; parts; parts &= parts - 1) shaded++;
        }
    const fnl_frame_stats *s = &shot->stats;
    const uint64_t counted = counter(s, "coarse.shaded");
    print_message("%ux%u, size %u: %u of %u pixels each, %u times in all, %u differ\n", width, height, size, (uint32_t)near, (uint32_t)shown, (uint32_t)counted, (uint32_t)differing);
    assert_int_equal(counter(s, "coarse.pixels"), shown);
    assert_true(counted >= shaded && counted <= shaded + open && open < (uint64_t)width * height / 10);
    if (shown > near + open + 16) assert_true(differing > 0 && counted < shown);
    assert_true(s->evaluations > 0 && s->evaluations * shown == reference->stats.evaluations * counted); /* with lists that have all lights in each pixel */
}

static struct shot shoot_deferred(struct stage *stage, fnl_frame frame) {
    frame.shading = FNL_SHADING_DEFERRED;
    return stage_shoot(stage, &frame);
}

static fnl_frame fovea_frame(const struct stage *stage, uint32_t width, uint32_t height) {
    fnl_frame frame = stage->frame;
    frame.shading = FNL_SHADING_COARSE;
    frame.lists = FNL_LISTS_ALL;
    frame.width = width;
    frame.height = height;
    frame.outputs = FNL_OUTPUT_COLOR | FNL_OUTPUT_RADIANCE | FNL_OUTPUT_NORMAL;
    frame.count_lights = true;
    frame.coarse.size = 4;
    frame.coarse.fovea = 14;
    frame.coarse.fovea_far = 24;
    return frame;
}

/* Somewhere in the picture, -1 .. 1 right and up, `away` metres from the camera; beyond 1 outside of it. */
static vec3 point_in(const fnl_camera *camera, float aspect, float x, float y, float away) {
    const vec3 back = vec3_normalize(vec3_sub(camera->position, camera->target)), right = vec3_normalize(vec3_cross(camera->up, back)), up = vec3_cross(back, right);
    const float tangent = tanf(camera->vertical_fov / 2);
    const vec3 to = vec3_sub(vec3_add(vec3_scale(right, x * tangent * aspect), vec3_scale(up, y * tangent)), back);
    return vec3_add_scaled(camera->position, to, away);
}

static void test_fovea_follows_the_gaze_VR_11(void **state) {
    UNUSED(state);
    static const struct {
        uint32_t width, height, size;
        float x, y, away;
    } cases[] = {{96, 64, 4, 0, 0, 0}, {101, 67, 4, -0.6f, 0.4f, 3}, {101, 67, 2, 0.5f, -0.3f, 50}, {63, 65, 4, 1, 1, 1000}, {64, 36, 4, 3, 0, 10}, {64, 36, 2, 0.2f, 0, -5}, {3, 5, 4, 0, 0, 0}};
    static const char *const scenes[] = {"builtin:sky?lights=20", "builtin:hall?lights=20&decals=20"};
    for (uint32_t s = 0; s < COUNT_OF(scenes); s++) {
        struct stage stage = stage_open(scenes[s], 0);
        for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
            fnl_frame frame = fovea_frame(&stage, cases[i].width, cases[i].height);
            const vec3 gaze = point_in(&frame.camera, (float)frame.width / (float)frame.height, cases[i].x, cases[i].y, cases[i].away);
            frame.gaze = cases[i].away != 0 ? &gaze : NULL;
            frame.coarse.size = cases[i].size;
            frame.coarse.filter = i % 2 ? FNL_COARSE_FILTER_SAMPLED : FNL_COARSE_FILTER_MEAN;
            struct shot shot = stage_shoot(&stage, &frame), reference = shoot_deferred(&stage, frame);
            check_fovea(&frame, &frame.camera, frame.gaze, &shot, &reference);
            shot_free(&shot);
            shot_free(&reference);
        }
        stage_close(&stage);
    }
}

/* Splits come closer to the whole rate with as much work for what is shared. One rate for all pixels is no foveation. */
static void test_fovea_with_splits_and_limits_VR_11(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:spheres", 40);
    fnl_frame frame = fovea_frame(&stage, 101, 67);
    frame.count_lights = false;
    struct shot full = shoot_deferred(&stage, frame), none = stage_shoot(&stage, &frame);
    fnl_image_difference difference;
    for (uint32_t split = 1; split < FNL_COARSE_SPLIT_COUNT; split++) {
        frame.coarse.split = (fnl_coarse_split)split;
        frame.coarse.ao_radius = split == 1 ? 0.3f : 0;
        struct shot shot = stage_shoot(&stage, &frame);
        assert_int_equal(fnl_image_compare(gpu_host(harness_device()), &shot.color, &full.color, &difference), FNL_OK);
        print_message("%s: %.1f dB\n", fnl_value_name(FNL_ENUM_COARSE_SPLIT, frame.coarse.split), difference.psnr);
        if (split > 1) assert_true(difference.psnr > 22);
        if (split == 1) assert_int_equal(counter(&shot.stats, "coarse.ao-shaded"), counter(&none.stats, "coarse.shaded"));
        assert_int_equal(counter(&shot.stats, "coarse.shaded"), counter(&none.stats, "coarse.shaded"));
        shot_free(&shot);
    }
    /* One rate for all is as if there was none, to the bit, and so are blocks of a pixel. */
    frame.coarse = fovea_frame(&stage, 1, 1).coarse;
    for (uint32_t i = 0; i < 2; i++) {
        frame.coarse.fovea = i ? 5 : 180;
        frame.coarse.size = i ? 1 : 4;
        struct shot shot = stage_shoot(&stage, &frame);
        assert_int_equal(count_differing(&shot.radiance, &full.radiance), 0);
        assert_int_equal(counter(&shot.stats, "coarse.shaded"), counter(&shot.stats, "coarse.pixels"));
        shot_free(&shot);
    }
    frame.coarse.fovea = 10;
    frame.camera.orthographic = true;
    frame.camera.vertical_extent = 2;
    frame.camera.far_distance = 100;
    assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_ERROR_UNSUPPORTED);
    frame.coarse.fovea = 0;
    assert_int_equal(fnl_renderer_render(stage.renderer, &frame), FNL_OK);
    shot_free(&full);
    shot_free(&none);
    stage_close(&stage);
}

/* Both eyes of a headset with canted displays look at one point: each has the pixels around it where it sees it. */
static void test_fovea_of_two_eyes_VR_11(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:hall?lights=20", 0);
    fnl_frame frame = fovea_frame(&stage, 80, 60);
    fnl_camera eyes[2];
    const fnl_camera at = frame.camera;
    const vec3 gaze = point_in(&at, 4 / 3.0f, 0.2f, 0.1f, 2);
    uint64_t shaded[2];
    struct shot single[2];
    frame.gaze = &gaze;
    for (int i = 0; i < 2; i++) {
        const fnl_eye one = {{{i ? 0.0315f : -0.0315f, 0, 0}, quat_axis_angle(vec3_make(0, 1, 0), i ? -0.17f : 0.17f)}, i ? -0.8f : -1.2f, i ? 1.2f : 0.8f, -0.9f, 0.8f};
        eyes[i] = camera_of(&one, &at, frame.width, frame.height);
        frame.camera = eyes[i];
        single[i] = stage_shoot(&stage, &frame);
        struct shot reference = shoot_deferred(&stage, frame);
        check_fovea(&frame, &eyes[i], &gaze, &single[i], &reference);
        shaded[i] = counter(&single[i].stats, "coarse.shaded");
        shot_free(&reference);
    }
    frame.views = eyes;
    frame.view_count = 2;
    frame.stereo.eyes = 2;
    struct shot both = stage_shoot(&stage, &frame);
    const size_t half = single[0].radiance.width * single[0].radiance.height * sizeof(vec4);
    for (int i = 0; i < 2; i++) {
        assert_memory_equal((const char *)both.radiance.pixels + i * half, single[i].radiance.pixels, half);
        assert_int_equal(fnl_counter_find(&both.stats.views[i], "coarse.shaded")->value, shaded[i]);
        shot_free(&single[i]);
    }
    shot_free(&both);
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_cells_cover_the_picture_VR_11, harness_check),
        cmocka_unit_test_teardown(test_the_middle_stays_as_it_was_VR_11, harness_check),
        cmocka_unit_test_teardown(test_lens_matched_places_come_back_VR_11, harness_check),
        cmocka_unit_test_teardown(test_fovea_follows_the_gaze_VR_11, harness_check),
        cmocka_unit_test_teardown(test_fovea_with_splits_and_limits_VR_11, harness_check),
        cmocka_unit_test_teardown(test_fovea_of_two_eyes_VR_11, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
