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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_cells_cover_the_picture_VR_11, harness_check),
        cmocka_unit_test_teardown(test_the_middle_stays_as_it_was_VR_11, harness_check),
        cmocka_unit_test_teardown(test_lens_matched_places_come_back_VR_11, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
