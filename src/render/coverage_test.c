/* SPDX-License-Identifier: MIT */
/** The alpha of radiance is the coverage: 1 where a surface is, 0 where the background shows, and what blended surfaces hide between them. */
#include "tests/render_test.h"

static uint32_t add_material(fnl_scene *scene, float red, float alpha) {
    fnl_material_params params = fnl_material_params_default();
    params.unlit = true;
    params.base_color[0] = red, params.base_color[3] = alpha;
    params.alpha_mode = alpha < 1 ? FNL_ALPHA_BLEND : FNL_ALPHA_OPAQUE;
    return test_material(scene, &params).index;
}

/* A square on the left, whose edges lie in the middle of pixels; half of it, and as much of the background, behind a blended one. */
static fnl_scene *squares(bool blended, bool sky) {
    fnl_scene *scene = test_scene();
    test_place(scene, test_quad_mesh(scene, add_material(scene, 0.5f, 1)), (vec3){-0.5f, 0, 0}, (vec3){0.5f - 1.0f / 64, 0.5f - 1.0f / 64, 1});
    if (blended) test_place(scene, test_quad_mesh(scene, add_material(scene, 1, 0.25f)), (vec3){0, 0, 1}, (vec3){0.5f, 0.25f, 1});
    if (!sky) return scene;
    fnl_environment_params environment = fnl_environment_params_default();
    environment.source = "builtin:overcast";
    assert_int_equal(fnl_scene_set_environment(scene, &environment), FNL_OK);
    return scene;
}

static void expect(const char *name, const fnl_image *radiance, uint32_t x, uint32_t y, double alpha) {
    const double found = (double)test_pixel(radiance, x, y)[3];
    if (!(fabs(found - alpha) < 1e-3)) fail_msg("%s: pixel %u, %u is covered by %g, not %g", name, x, y, found, alpha);
}

/* What `mobile` blends in its scope has no place for coverage. */
static void look_at(const char *what, const fnl_frame *frame, bool blended, bool sky) {
    char name[96];
    snprintf(name, sizeof name, "%s, %s%s", fnl_value_name(FNL_ENUM_SHADING, frame->shading), what, sky ? ", sky" : "");
    fnl_scene *scene = squares(blended, sky);
    fnl_image radiance = test_render(scene, frame, FNL_OUTPUT_RADIANCE);
    expect(name, &radiance, 16, 32, 1);
    expect(name, &radiance, 60, 4, 0);
    expect(name, &radiance, 24, 32, 1);
    expect(name, &radiance, 40, 32, blended && (frame->shading != FNL_SHADING_MOBILE || sky) ? 0.25 : 0);
    if (frame->msaa == 4) { /* half of the samples of pixels at the edges */
        const double edge = (double)test_pixel(&radiance, 4, 16)[3];
        if (edge < 0.2 || edge > 0.8) fail_msg("%s: the edge is covered by %g", name, edge);
    }
    free_picture(&radiance);
    fnl_scene_destroy(&scene);
}

static void test_radiance_has_the_coverage(void **state) {
    UNUSED(state);
    fnl_device_info info;
    assert_int_equal(fnl_device_query_info(harness_device(), &info), FNL_OK);
    for (uint32_t s = 0; s < FNL_SHADING_AUTO; s++)
        for (uint32_t samples = 1; samples <= 4; samples += 3) {
            fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
            frame.shading = (fnl_shading)s;
            frame.lists = FNL_LISTS_ALL;
            frame.msaa = samples;
            if (!fnl_shading_supports(frame.shading, frame.lists, 1)) frame.lists = FNL_LISTS_TILED;
            if (!fnl_shading_supports(frame.shading, frame.lists, samples) || !(info.msaa_counts & samples)) continue;
            look_at(samples > 1 ? "4 samples" : "1 sample", &frame, false, false);
            look_at(samples > 1 ? "4 samples, blended" : "1 sample, blended", &frame, true, false);
            look_at(samples > 1 ? "4 samples" : "1 sample", &frame, true, true);
        }
}

/* Lists of what is to be shaded leave out the background, which a pass of its own writes. */
static void test_sorted_pixels_leave_the_background(void **state) {
    UNUSED(state);
    for (uint32_t sort = 0; sort < FNL_VISIBILITY_SORT_COUNT; sort++) {
        fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
        frame.shading = FNL_SHADING_VISIBILITY;
        frame.visibility.sort = (fnl_visibility_sort)sort;
        look_at(fnl_value_name(FNL_ENUM_VISIBILITY_SORT, frame.visibility.sort), &frame, true, false);
    }
}

static void test_transparency_adds_to_the_coverage(void **state) {
    UNUSED(state);
    for (uint32_t t = 0; t < FNL_TRANSPARENCY_COUNT; t++) {
        fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
        frame.transparency = (fnl_transparency)t;
        look_at(fnl_value_name(FNL_ENUM_TRANSPARENCY, frame.transparency), &frame, true, false);
    }
}

/* The picture itself is opaque. */
static void test_pictures_are_opaque(void **state) {
    UNUSED(state);
    fnl_frame frame = test_frame(FNL_OUTPUT_COLOR | FNL_OUTPUT_RADIANCE);
    fnl_scene *scene = squares(true, false);
    fnl_image color = test_render(scene, &frame, FNL_OUTPUT_COLOR);
    for (uint32_t i = 0; i < 64; i++) assert_int_equal(test_pixel8(&color, i, i)[3], 255);
    free_picture(&color);
    fnl_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_radiance_has_the_coverage, harness_check),
        cmocka_unit_test_teardown(test_sorted_pixels_leave_the_background, harness_check),
        cmocka_unit_test_teardown(test_transparency_adds_to_the_coverage, harness_check),
        cmocka_unit_test_teardown(test_pictures_are_opaque, harness_check),
    };
    return cmocka_run_group_tests_name("coverage", tests, test_group_begin, test_group_end);
}
