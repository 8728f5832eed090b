/* SPDX-License-Identifier: MIT */
/** The visibility buffer: ids of all widths, and attributes and gradients as the rasteriser makes them. Whole scenes: render/lists_test.c. */
#include "passes/visibility/visibility.h"
#include "tests/triangle_soup.h"

static void test_bits(void **state) {
    UNUSED(state);
    static const struct {
        uint32_t items, triangles, bits, triangle_bits;
    } cases[] = {{0, 0, 32, 0},
                 {1, 1, 32, 0},
                 {UINT32_MAX, 1, 32, 0}, /* items are numbered from 1 */
                 {65535, 65536, 32, 16},
                 {65536, 65536, 48, 16},
                 {65535, 65537, 48, 17},
                 {1u << 24, 1u << 23, 48, 23},
                 {UINT32_MAX, 1u << 16, 48, 16},
                 {UINT32_MAX, (1u << 16) + 1, 64, 17},
                 {UINT32_MAX, UINT32_MAX / 3, 64, 31}};
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        uint32_t triangle_bits;
        assert_int_equal(visibility_bits(cases[i].items, cases[i].triangles, &triangle_bits), cases[i].bits);
        assert_int_equal(triangle_bits, cases[i].triangle_bits);
    }
}

static fnl_frame wide_frame(int view) { return soup_frame(FNL_OUTPUT_RADIANCE | FNL_OUTPUT_COLOR, view); }

static void test_interpolation(void **state) {
    UNUSED(state);
    fnl_scene *scene = soup_scene(&colorful);
    fnl_renderer *renderer = test_renderer(scene);
    for (int view = 0; view < 3; view++) {
        fnl_frame frame = wide_frame(view);
        test_render_frame(renderer, &frame);
        fnl_image forward = test_read(renderer, FNL_OUTPUT_RADIANCE);
        frame.shading = FNL_SHADING_VISIBILITY;
        test_render_frame(renderer, &frame);
        fnl_image visibility = test_read(renderer, FNL_OUTPUT_RADIANCE);
        double worst = 0;
        uint32_t beyond = 0, shown = 0;
        for (uint32_t y = 0; y < frame.height; y++)
            for (uint32_t x = 0; x < frame.width; x++) {
                double error = 0;
                for (int c = 0; c < 3; c++)
                    error =
                        fmax(error, fabs((double)test_pixel(&forward, x, y)[c] - (double)test_pixel(&visibility, x, y)[c]));
                beyond += error > 1e-4;
                shown += test_pixel(&forward, x, y)[0] > 0;
                worst = fmax(worst, error);
            }
        print_message("view %d: %u of %u pixels beyond 1e-4, %.2g at most\n", view, beyond, shown, worst);
        assert_true(shown > 3000);
        /* Triangles on edge, a fraction of a pixel wide: the rasteriser's positions are rounded to 1/256 of a pixel. */
        assert_true(beyond * 200 < shown);
        free_picture(&forward);
        free_picture(&visibility);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

static fnl_scene *textured_floor(float anisotropy) {
    fnl_scene *scene = test_scene();
    assert_int_equal(fnl_scene_set_anisotropy(scene, anisotropy), FNL_OK);
    enum { SIDE = 128 };
    static uint8_t texels[SIDE * SIDE * 4];
    for (uint32_t i = 0; i < SIDE * SIDE; i++)
        for (uint32_t c = 0; c < 4; c++)
            texels[i * 4 + c] = c == 3 ? 255 : (uint8_t)(((i % SIDE / (c * 2 + 1)) ^ (i / SIDE / (c + 1))) & 1 ? 240 : 20);
    fnl_image image = {SIDE, SIDE, FNL_PIXEL_FORMAT_RGBA8, texels};
    fnl_image_id id;
    assert_int_equal(fnl_scene_add_image(scene, &image, true, &id), FNL_OK);
    struct scene_sampler sampler = {.mag = SCENE_FILTER_LINEAR,
                                    .min = SCENE_FILTER_LINEAR,
                                    .mip = SCENE_FILTER_LINEAR,
                                    .mipmapped = true,
                                    .wrap_u = SCENE_WRAP_REPEAT,
                                    .wrap_v = SCENE_WRAP_MIRROR};
    struct scene_material material = test_unlit(1, 1, 1);
    material.textures[SCENE_TEXTURE_BASE_COLOR] = scene_texture_none();
    material.textures[SCENE_TEXTURE_BASE_COLOR].image = id.index;
    material.textures[SCENE_TEXTURE_BASE_COLOR].sampler = scene_add_sampler(scene, &sampler);
    mat4 matrix = mat4_from_trs((vec3){0, -1, 0}, quat_axis_angle((vec3){1, 0, 0}, -PI / 2), (vec3){20, 20, 1});
    scene_add_node(scene, "", SCENE_NONE, &matrix, test_quad_mesh(scene, scene_add_material(scene, &material)));
    test_place(scene, test_sphere_mesh(scene, scene_add_material(scene, &material), 6), (vec3){0.5f, 0.3f, 1},
               (vec3){1, 1, 1});
    return scene;
}

/* Textures are filtered as in forward shading: with the same levels, and along the longer gradient. */
static void test_gradients(void **state) {
    UNUSED(state);
    static const struct {
        float anisotropy;
        double psnr;
    } cases[] = {{1, 50}, {8, 30}}; /* drivers differ in how they place anisotropic samples */
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        fnl_scene *scene = textured_floor(cases[i].anisotropy);
        fnl_renderer *renderer = test_renderer(scene);
        fnl_frame frame = wide_frame(0);
        fnl_image colors[2];
        for (int k = 0; k < 2; k++) {
            frame.shading = k ? FNL_SHADING_VISIBILITY : FNL_SHADING_FORWARD;
            test_render_frame(renderer, &frame);
            colors[k] = test_read(renderer, FNL_OUTPUT_COLOR);
        }
        fnl_image_difference difference;
        assert_int_equal(fnl_image_compare(NULL, &colors[0], &colors[1], &difference), FNL_OK);
        print_message("anisotropy %g: %.1f dB\n", (double)cases[i].anisotropy, difference.psnr);
        assert_true(difference.psnr > cases[i].psnr);
        for (int k = 0; k < 2; k++) free_picture(&colors[k]);
        fnl_renderer_destroy(&renderer);
        fnl_scene_destroy(&scene);
    }
}

/* Stored weights against those that shading finds by itself, with lines and points, across the near plane; the number of what is beyond. */
static void check_stored(fnl_scene *scene, fnl_frame frame, double allowed, uint32_t part) {
    fnl_renderer *renderer = test_renderer(scene);
    frame.shading = FNL_SHADING_VISIBILITY;
    fnl_image pictures[2];
    for (int k = 0; k < 2; k++) {
        frame.visibility.barycentrics = k;
        harness_hooks(renderer)->poison = true;
        test_render_frame(renderer, &frame);
        pictures[k] = test_read(renderer, FNL_OUTPUT_RADIANCE);
        char plan[32768];
        assert_true(fnl_renderer_print(renderer, FNL_PRINT_PLAN, plan, sizeof plan) < sizeof plan);
        assert_int_equal(strstr(plan, "visibility weights") != NULL, k);
    }
    double worst = 0;
    uint32_t beyond = 0, shown = 0;
    for (uint32_t y = 0; y < frame.height; y++)
        for (uint32_t x = 0; x < frame.width; x++) {
            double error = 0;
            for (int c = 0; c < 3; c++)
                error =
                    fmax(error, fabs((double)test_pixel(&pictures[0], x, y)[c] - (double)test_pixel(&pictures[1], x, y)[c]));
            beyond += error > allowed;
            shown += test_pixel(&pictures[0], x, y)[0] > 0;
            worst = fmax(worst, error);
        }
    print_message("%u of %u pixels beyond %g, %.2g at most\n", beyond, shown, allowed, worst);
    assert_true(shown > 3000);
    assert_true(beyond * part < shown);
    for (int k = 0; k < 2; k++) free_picture(&pictures[k]);
    fnl_renderer_destroy(&renderer);
}

static void test_stored_weights(void **state) {
    UNUSED(state);
    fnl_scene *scene = soup_scene(&colorful);
    for (int view = 0; view < 3; view++) check_stored(scene, wide_frame(view), 1e-4, 200);
    fnl_scene_destroy(&scene);
    scene = textured_floor(1);
    check_stored(scene, wide_frame(0), 4.0 / 255, 200);
    /* Both sides of surfaces, lit: positions come from depth here. */
    struct scene_material material = scene_material_default();
    material.double_sided = true;
    material.metallic = 0;
    uint32_t mesh = test_quad_mesh(scene, scene_add_material(scene, &material));
    mat4 matrix = mat4_from_trs((vec3){-1, 0.5f, 1}, quat_axis_angle((vec3){0, 1, 0}, PI * 0.8f), (vec3){1, 1, 1});
    scene_add_node(scene, "", SCENE_NONE, &matrix, mesh);
    fnl_light_params light = test_point((vec3){0, 1, 2.5f}, 4, 20);
    fnl_light_id id;
    assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
    check_stored(scene, wide_frame(0), 4.0 / 255, 200);
    fnl_scene_destroy(&scene);
}

static void test_wide_ids(void **state) {
    UNUSED(state);
    fnl_scene *scene = soup_scene(&colorful);
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = wide_frame(0);
    frame.shading = FNL_SHADING_VISIBILITY;
    fnl_image narrow = {0};
    static const uint32_t bits[] = {32, 48, 64};
    for (uint32_t i = 0; i < COUNT_OF(bits); i++) {
        harness_hooks(renderer)->visibility_bits = bits[i];
        test_render_frame(renderer, &frame);
        char plan[32768];
        assert_true(fnl_renderer_print(renderer, FNL_PRINT_PLAN, plan, sizeof plan) < sizeof plan);
        assert_int_equal(strstr(plan, "visibility high") != NULL, i > 0);
        fnl_image radiance = test_read(renderer, FNL_OUTPUT_RADIANCE);
        if (i == 0) {
            narrow = radiance;
            continue;
        }
        assert_true(test_equal(&narrow, &radiance));
        free_picture(&radiance);
    }
    free_picture(&narrow);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        {"ES-73: ids are as wide as the scene needs", test_bits, NULL, NULL, NULL},
        {"ES-73: weights are the rasteriser's, across the near plane too", test_interpolation, NULL, NULL, NULL},
        {"ES-73: textures are filtered as in forward shading", test_gradients, NULL, NULL, NULL},
        {"ES-74: stored weights give the picture of ES-73", test_stored_weights, NULL, NULL, NULL},
        {"ES-73: ids of 48 and 64 bits give the same picture", test_wide_ids, NULL, NULL, NULL}};
    return cmocka_run_group_tests(tests, test_group_begin, test_group_end);
}
