/* SPDX-License-Identifier: MIT */
/* Frames against rays: without shadows both show the same picture. */
#include "tests/render_harness.h"

#include "fanal/trace.h"
#include "tests/coarse_cases.h"
#include "tests/stand_in.h"

struct view {
    const char *source;
    double radiance,
        color; /* PSNR that is reached, dB; of radiance by its 99th percentile, so that a bright lamp does not set the scale */
    bool orthographic;
    double seconds;     /* of the animation */
    uint32_t scattered; /* lights */
};

static fnl_trace trace_of(const struct stage *s) {
    fnl_trace_params p = trace_plain();
    p.width = s->frame.width, p.height = s->frame.height, p.camera = s->frame.camera;
    p.shadows = false;
    p.exposure = s->frame.exposure, p.ev = s->frame.ev, p.tonemap = s->frame.tonemap;
    fnl_trace trace;
    assert_int_equal(fnl_scene_trace(s->scene, &p, &trace), FNL_OK);
    return trace;
}

static int compare_floats(const void *a, const void *b) {
    const float *x = a, *y = b;
    return *x < *y ? -1 : *x > *y;
}

/* Of the pixels' green; what is brighter than the 99th percentile is cut off at it. */
static double psnr_below_highlights(const fnl_image *a, const fnl_image *b) {
    const size_t count = (size_t)a->width * a->height;
    const float *x = a->pixels, *y = b->pixels;
    float *sorted = malloc(count * sizeof *sorted);
    for (size_t i = 0; i < count; i++) sorted[i] = y[i * 4 + 1];
    qsort(sorted, count, sizeof *sorted, compare_floats);
    double peak = fmax((double)sorted[count * 99 / 100], 1e-6), sum = 0;
    free(sorted);
    for (size_t i = 0; i < count; i++) {
        double d = fmin((double)x[i * 4 + 1], peak) - fmin((double)y[i * 4 + 1], peak);
        sum += d * d;
    }
    return 10 * log10(peak * peak * (double)count / fmax(sum, 1e-30));
}

static void expect_same(const struct view *view) {
    struct stage s = stage_open(view->source, view->scattered);
    if (view->seconds > 0) assert_int_equal(fnl_scene_set_time(s.scene, 0, view->seconds), FNL_OK);
    s.frame.shading = FNL_SHADING_FORWARD;
    s.frame.lists = FNL_LISTS_ALL;
    s.frame.transparency = FNL_TRANSPARENCY_LINKED;
    if (view->orthographic) {
        s.frame.camera.orthographic = true;
        s.frame.camera.vertical_extent = 6;
        s.frame.camera.shift = (fnl_vec2){0.2f, -0.1f};
    }
    struct shot shot = stage_shoot(&s, &s.frame);
    fnl_trace trace = trace_of(&s);
    fnl_image_difference difference;
    assert_int_equal(fnl_image_compare(NULL, &trace.color, &shot.color, &difference), FNL_OK);
    double radiance = psnr_below_highlights(&trace.radiance, &shot.radiance);
    print_message("%s: %.1f dB of radiance, %.1f dB of the picture\n", view->source, radiance, difference.psnr);
    if (radiance < view->radiance || difference.psnr < view->color)
        fail_msg("%s: %.1f dB of radiance, %.1f dB of the picture, must be %g and %g", view->source, radiance,
                 difference.psnr, view->radiance, view->color);
    fnl_trace_free(&s.scene->host, &trace);
    shot_free(&shot);
    stage_close(&s);
}

static void test_frames_without_shadows(void **state) {
    UNUSED(state);
    static const struct view views[] = {
        {"builtin:spheres?lights=40", 40, 49, false, 0, 0},
        {"builtin:spheres?lights=40", 48, 54, true, 0, 0},
        {"builtin:interior?lights=40", 38, 40, false, 0, 0}, /* all shapes of lights */
        {"builtin:glass?lights=40&crossing=1", 42, 51, false, 0, 0},
        {"builtin:hall?lights=24", 43, 58, false, 0, 0}, /* textures, normal maps, cutouts; pixels on triangle edges dominate the error */
    };
    for (uint32_t i = 0; i < COUNT_OF(views); i++) expect_same(&views[i]);
}

/* Each extension's sample model: textures of layers, and normals and tangents of their own. */
static void test_layered_materials_of_files_MA_6(void **state) {
    UNUSED(state);
    /* Stand-ins (tests/stand_in.h) reach 45.7 and 46.6, 72.9 and 79.4, 68.2 and 69.6, 56.5 and 62.9 dB. */
    static const double made[][2] = {{43.5, 44.5}, {65, 70}, {60, 62}, {50, 57}};
    static const struct view views[] = {
        {"materials/ClearCoatTest.glb", 35, 38, false, 0, 12},
        {"materials/IridescenceSuzanne.glb", 35, 38, false, 0, 12},
        {"materials/AnisotropyStrengthTest.glb", 35, 38, false, 0, 12},
        {"materials/SheenChair/SheenChair.gltf", 35, 38, false, 0, 12},
    };
    for (uint32_t i = 0; i < COUNT_OF(views); i++) {
        struct view view = views[i];
        if (!stand_in_sample(view.source)) view.radiance = made[i][0], view.color = made[i][1];
        expect_same(&view);
    }
}

static void test_animated_frames(void **state) {
    UNUSED(state);
    expect_same(&(struct view){"Fox.glb", 45, 50, false, 0.4, 60});
}

/* ---- environments ---- */

static fnl_material_params painted(float metallic, float roughness) {
    fnl_material_params material = fnl_material_params_default();
    material.metallic = metallic;
    material.roughness = roughness;
    material.base_color[0] = 0.9f, material.base_color[1] = 0.7f, material.base_color[2] = 0.4f;
    return material;
}

/* A ball in a sky, whose sun is a light: paths choose directions by the lobe, frames read prefiltered maps. dB of the tone-mapped pictures. */
static double ball_in_the_sky(const char *source, float ev, const char *name, const fnl_material_params *material, uint32_t bounces) {
    fnl_scene *scene = coarse_scene();
    fnl_environment_params environment = fnl_environment_params_default();
    fnl_material_id id;
    environment.source = source;
    assert_int_equal(fnl_scene_set_environment(scene, &environment), FNL_OK);
    assert_int_equal(fnl_scene_add_material(scene, material, &id), FNL_OK);
    coarse_add_sphere(scene, id, 1);
    struct stage s = stage_open_scene(scene);
    s.frame.width = s.frame.height = 20;
    s.frame.ev = ev;
    s.frame.camera = fnl_camera_default();
    s.frame.camera.position = (fnl_vec3){0, 0.6f, 1.5f}; /* it fills the picture: edges have other samples */
    s.frame.camera.target = (fnl_vec3){0, 0, 0};
    s.frame.camera.vertical_fov = 1;
    struct shot shot = stage_shoot(&s, &s.frame);
    fnl_trace_params p = trace_plain();
    p.width = s.frame.width, p.height = s.frame.height, p.camera = s.frame.camera;
    p.exposure = s.frame.exposure, p.ev = s.frame.ev, p.tonemap = s.frame.tonemap;
    p.samples = 700;
    p.bounces = bounces;
    p.shadows = false;
    fnl_trace trace;
    fnl_image_difference difference;
    assert_int_equal(fnl_scene_trace(s.scene, &p, &trace), FNL_OK);
    assert_int_equal(fnl_image_compare(NULL, &trace.color, &shot.color, &difference), FNL_OK);
    print_message("%s, %s, metallic %.1f, roughness %.2f: %.1f dB\n", source, name, (double)material->metallic, (double)material->roughness, difference.psnr);
    fnl_trace_free(&s.scene->host, &trace);
    shot_free(&shot);
    stage_close(&s);
    return difference.psnr;
}

static void test_environments_against_paths_EN_8(void **state) {
    UNUSED(state);
    static const float roughnesses[] = {0.2f, 0.6f, 1};
    for (uint32_t i = 0; i < COUNT_OF(roughnesses); i++) {
        const fnl_material_params metal = painted(1, roughnesses[i]), paint = painted(0, roughnesses[i]);
        assert_true(ball_in_the_sky("builtin:sky", 14, "metal", &metal, 0) > 35);
        assert_true(ball_in_the_sky("builtin:studio", 1, "paint", &paint, 0) > 35);
    }
}

/* Each model of the material extensions, in one environment: the frame's approximations against paths. */
static void test_each_extension_against_paths(void **state) {
    UNUSED(state);
    enum { EXTENSIONS = 11 };
    static const char *const names[EXTENSIONS] = {"clearcoat", "sheen", "iridescence", "anisotropy", "specular", "ior", "thin transmission", "rough transmission", "volume", "dispersion", "diffuse transmission"};
    /* The last: the far side of the ball stops light that frames take from all around. */
    static const double least[EXTENSIONS] = {36, 32, 38, 32, 36, 36, 45, 27, 30, 30, 15};
    fnl_material_params m[EXTENSIONS];
    for (int i = 0; i < EXTENSIONS; i++) m[i] = painted(0, 0.4f);
    m[0].clearcoat.strength = 1, m[0].clearcoat.roughness = 0.1f;
    m[1].sheen.color[0] = m[1].sheen.color[2] = 0.8f, m[1].sheen.roughness = 0.5f;
    m[2] = painted(1, 0.3f), m[2].iridescence.strength = 1;
    m[3] = painted(1, 0.4f), m[3].anisotropy.strength = 0.5f;
    m[4].specular = 0.5f, m[4].specular_color[0] = 0.2f;
    m[5].ior = 2;
    for (int i = 6; i < 10; i++) {
        m[i].transmission.strength = 1;
        m[i].roughness = i == 7 ? 0.4f : 0.05f;
        m[i].volume.thickness = i < 8 ? 0 : 1.5f;
    }
    m[8].volume.attenuation_distance = 2, m[8].volume.attenuation_color[0] = 0.8f, m[8].volume.attenuation_color[1] = m[8].volume.attenuation_color[2] = 0.5f;
    m[9].dispersion = 2;
    m[10].diffuse_transmission.strength = 0.5f;
    for (int c = 0; c < 3; c++) m[10].diffuse_transmission.color[c] = 0.8f;
    for (int i = 0; i < EXTENSIONS; i++) {
        const double reached = ball_in_the_sky("builtin:overcast", 11, names[i], &m[i], 0);
        if (!(reached > least[i])) fail_msg("%s: %.1f dB, must be over %g", names[i], reached, least[i]);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_frames_without_shadows, harness_check),
        cmocka_unit_test_teardown(test_layered_materials_of_files_MA_6, harness_check),
        cmocka_unit_test_teardown(test_animated_frames, harness_check),
        cmocka_unit_test_teardown(test_environments_against_paths_EN_8, harness_check),
        cmocka_unit_test_teardown(test_each_extension_against_paths, harness_check),
    };
    return cmocka_run_group_tests_name("trace_frames", tests, harness_begin, harness_end);
}
