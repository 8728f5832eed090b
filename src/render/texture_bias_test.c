/* SPDX-License-Identifier: MIT */
/** Textures that are sharper than a frame needs: the mean of such frames shows what a larger picture shows. */
#include "tests/render_test.h"

enum { SIDE = 256, WIDTH = 40, HEIGHT = 24, FINER = 8 };

/* A board of squares, 16 texels each, a little turned. */
static fnl_scene *make_board(float turn) {
    static uint8_t texels[SIDE * SIDE * 4];
    static const float positions[12] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0}, uv[8] = {0, 1, 1, 1, 1, 0, 0, 0};
    static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    for (int i = 0; i < SIDE * SIDE * 4; i++) texels[i] = i % 4 == 3 || (i / 4 % SIDE / 16 + i / 4 / SIDE / 16) % 2 ? 255 : 0;
    const fnl_image squares = {SIDE, SIDE, FNL_PIXEL_FORMAT_RGBA8, texels};
    fnl_scene *scene = test_scene();
    fnl_material_params look = fnl_material_params_default();
    look.unlit = look.double_sided = true;
    assert_int_equal(fnl_scene_add_image(scene, &squares, true, &look.base_color_image), FNL_OK);
    const fnl_mesh_params params = {.vertex_count = 4, .index_count = 6, .positions = positions, .uv = uv, .indices = indices, .material = test_material(scene, &look)};
    fnl_mesh_id mesh;
    fnl_instance_id instance;
    const fnl_mat4 place = mat4_from_trs(vec3_make(0, 0, 0), quat_axis_angle(vec3_make(1, 0, 0), turn), vec3_make(1, 1, 1));
    assert_int_equal(fnl_scene_add_mesh(scene, &params, &mesh), FNL_OK);
    assert_int_equal(fnl_scene_add_instance(scene, mesh, &place, &instance), FNL_OK);
    return scene;
}

/* Adds the frame's red to sums of `part` x `part` pixels. */
static void add_frame(struct stage *stage, const fnl_frame *frame, uint32_t part, double *sums) {
    test_render_frame(stage->renderer, frame);
    fnl_image image = test_read(stage->renderer, FNL_OUTPUT_RADIANCE);
    for (uint32_t i = 0; i < frame->width * frame->height; i++)
        sums[i / frame->width / part * WIDTH + i % frame->width / part] += (double)((const float *)image.pixels)[4 * i] / (FINER * FINER);
    free_picture(&image);
}

/* How far the mean of jittered frames is from the larger picture, of its contrast. */
static double error_with(float bias, float turn, fnl_shading shading) {
    struct stage stage = stage_open_scene(make_board(turn));
    double means[WIDTH * HEIGHT] = {0}, wanted[WIDTH * HEIGHT] = {0}, error = 0, contrast = 0;
    fnl_frame frame = stage.frame;
    frame.width = WIDTH * FINER;
    frame.height = HEIGHT * FINER;
    frame.shading = shading;
    frame.outputs = FNL_OUTPUT_RADIANCE;
    frame.camera = fnl_camera_default();
    frame.camera.position = vec3_make(0, 0, 1.5f);
    frame.camera.target = vec3_make(0, 0, 0);
    frame.camera.vertical_fov = 0.6f;
    add_frame(&stage, &frame, FINER, wanted);
    assert_int_equal(fnl_scene_set_texture_bias(stage.scene, bias), FNL_OK);
    frame.width = WIDTH;
    frame.height = HEIGHT;
    for (uint32_t i = 0; i < FINER * FINER; i++) {
        frame.jitter = fnl_jitter(i);
        add_frame(&stage, &frame, 1, means);
    }
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        error += pow(means[i] - wanted[i], 2);
        contrast += pow(wanted[i] - 0.5, 2);
    }
    stage_close(&stage);
    return error / contrast;
}

static void test_frames_with_a_bias_are_as_sharp_as_a_larger_picture(void **state) {
    UNUSED(state);
    static const fnl_shading paths[] = {FNL_SHADING_FORWARD, FNL_SHADING_DEFERRED, FNL_SHADING_VISIBILITY};
    for (uint32_t i = 0; i < COUNT_OF(paths); i++)
        for (int turned = 0; turned < 2; turned++) {
            const double without = error_with(0, 1.1f * (float)turned, paths[i]), with = error_with(-3, 1.1f * (float)turned, paths[i]);
            /* Along the longer axis of what is seen from the side drivers still filter over a pixel. */
            if (!(turned ? with < without : with < 0.01 && with < 0.4 * without))
                fail_msg("path %u, turned %d: off by %g of the contrast with a bias, %g without", i, turned, with, without);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test_teardown(test_frames_with_a_bias_are_as_sharp_as_a_larger_picture, harness_check)};
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
