/* SPDX-License-Identifier: MIT */
/** Frames of scenes in an environment: energy, every shading order, the sky, and what a frame pays for it. */
#include "passes/shade/gbuffer_layouts.h"
#include "render/renderer_internal.h"
#include "render/shading.h"
#include "tests/coarse_cases.h"
#include "tests/render_harness.h"

/* A panorama of one colour in each of six directions, blended; all 1: `even`. */
static fnl_image picture(bool even) {
    enum { WIDTH = 64, HEIGHT = 32 };
    float *pixels = calloc(WIDTH * HEIGHT, 16);
    assert_non_null(pixels);
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
        const float longitude = ((float)(i % WIDTH) + 0.5f) / WIDTH * 2 * PI - PI, latitude = ((float)(i / WIDTH) + 0.5f) / HEIGHT * PI;
        const vec3 d = vec3_make(sinf(latitude) * cosf(longitude), cosf(latitude), sinf(latitude) * sinf(longitude));
        pixels[4 * i] = even ? 1 : 1 + d.x;
        pixels[4 * i + 1] = even ? 1 : 1 + d.y;
        pixels[4 * i + 2] = even ? 1 : 1 + d.z;
        pixels[4 * i + 3] = 1;
    }
    return (fnl_image){WIDTH, HEIGHT, FNL_PIXEL_FORMAT_RGBA32F, pixels};
}

static void surround_by(fnl_scene *scene, bool even, float rotation, float intensity, bool background, bool compressed) {
    fnl_image image = picture(even);
    fnl_environment_params params = fnl_environment_params_default();
    params.image = &image;
    params.rotation = rotation;
    params.intensity = intensity;
    params.background = background;
    params.compressed = compressed;
    assert_int_equal(fnl_scene_set_environment(scene, &params), FNL_OK);
    free(image.pixels);
}

static void surround(fnl_scene *scene, bool even, float rotation, float intensity, bool background) {
    surround_by(scene, even, rotation, intensity, background, false);
}

static const float *pixel(const struct shot *shot, uint32_t x, uint32_t y) {
    return (const float *)shot->radiance.pixels + 4 * ((size_t)y * shot->radiance.width + x);
}

/* ---- energy ---- */

/* A sphere in light that is 1 from everywhere: how far its pixels are from 1. `inside`: the part of its radius that is looked at. */
static double furnace(const fnl_material_params *params) {
    fnl_scene *scene = coarse_scene();
    fnl_material_id material;
    assert_int_equal(fnl_scene_add_material(scene, params, &material), FNL_OK);
    coarse_add_sphere(scene, material, 1);
    surround(scene, true, 0, 1, true);
    struct stage s = stage_open_scene(scene);
    s.frame.width = s.frame.height = 48;
    s.frame.outputs = FNL_OUTPUT_RADIANCE;
    s.frame.energy = FNL_ENERGY_CONSERVING;
    s.frame.camera = fnl_camera_default();
    s.frame.camera.position = (fnl_vec3){0, 0, 3};
    s.frame.camera.target = (fnl_vec3){0, 0, 0};
    struct shot shot = stage_shoot(&s, &s.frame);
    double worst = 0;
    for (uint32_t y = 0; y < 48; y++)
        for (uint32_t x = 0; x < 48; x++)
            for (int c = 0; c < 3; c++) worst = fmax(worst, fabs((double)pixel(&shot, x, y)[c] - 1));
    shot_free(&shot);
    stage_close(&s);
    return worst;
}

/* Nothing gets lost and nothing comes from nowhere; the background is the same light, so the sphere cannot be seen. */
static void test_a_white_furnace_stays_white_EN_1(void **state) {
    UNUSED(state);
    static const float roughnesses[] = {0.05f, 0.3f, 0.6f, 1};
    for (uint32_t i = 0; i < COUNT_OF(roughnesses); i++) {
        fnl_material_params metal = fnl_material_params_default(), plastic = metal, half = metal;
        metal.metallic = 1;
        plastic.metallic = 0;
        half.metallic = 0.5f;
        metal.roughness = plastic.roughness = half.roughness = roughnesses[i];
        const double off[3] = {furnace(&metal), furnace(&plastic), i == 2 ? furnace(&half) : 0};
        print_message("roughness %.2f: metal %.4f, dielectric %.4f, half %.4f off\n", (double)roughnesses[i], off[0], off[1], off[2]);
        assert_true(off[0] < 0.01 && off[1] < 0.02 && off[2] < 0.02);
    }
}

/* ---- directions ---- */

/* A mirror that faces the camera shows what is behind it; a turn of the environment by 90 degrees moves +Z's colour to +X. */
static void test_the_sky_and_mirrors_follow_the_rotation_EN_4_MP_11_MB_10(void **state) {
    UNUSED(state);
    for (int k = 0; k < 3; k++) {
        const bool turned = k == 1, rough = k == 2; /* from the front the roughest lobe is as wide as a diffuse one */
        fnl_scene *scene = coarse_scene();
        fnl_material_params params = fnl_material_params_default();
        fnl_material_id material;
        params.metallic = 1;
        params.roughness = rough;
        assert_int_equal(fnl_scene_add_material(scene, &params, &material), FNL_OK);
        coarse_add_sphere(scene, material, 1);
        surround(scene, false, turned ? PI / 2 : 0, 2, true);
        struct stage s = stage_open_scene(scene);
        s.frame.width = s.frame.height = 65;
        s.frame.outputs = FNL_OUTPUT_RADIANCE;
        s.frame.energy = FNL_ENERGY_CONSERVING;
        s.frame.camera = fnl_camera_default();
        s.frame.camera.position = (fnl_vec3){0, 0, 4};
        s.frame.camera.target = (fnl_vec3){0, 0, 0};
        s.frame.camera.vertical_fov = 1.2f;
        struct shot shot = stage_shoot(&s, &s.frame);
        /* The camera looks to -Z: there blue is 0 in the picture, 2 behind the camera. Turned anticlockwise by 90 degrees, what was at +X is at -Z. */
        const float *sky = pixel(&shot, 2, 32), *mirror = pixel(&shot, 32, 32);
        const vec3 left = vec3_normalize(vec3_make((2.5f / 65 * 2 - 1) * tanf(0.6f), 0, -1));
        const vec3 looked = turned ? vec3_make(-left.z, left.y, left.x) : left;
        assert_float_equal(sky[0], 2 * (1 + looked.x), 0.06f);
        assert_float_equal(sky[1], 2 * (1 + looked.y), 0.06f);
        assert_float_equal(sky[2], 2 * (1 + looked.z), 0.06f);
        assert_float_equal(mirror[0], turned ? 0 : 2, 0.08f);
        assert_float_equal(mirror[2], turned ? 2 : rough ? 2 * (1 + 2.0f / 3) : 4, 0.08f);
        shot_free(&shot);
        stage_close(&s);
    }
}

/* ---- orders ---- */

/* Root of the squared differences over that of the squares. */
static double relative_error(const fnl_image *a, const fnl_image *b) {
    const float *x = a->pixels, *y = b->pixels;
    double error = 0, sum = 0;
    for (size_t i = 0; i < (size_t)a->width * a->height * 4; i++) {
        if (i % 4 == 3) continue;
        error += (double)(x[i] - y[i]) * (double)(x[i] - y[i]);
        sum += (double)y[i] * (double)y[i];
    }
    return sqrt(error / sum);
}

/* A ball before a wall and the sky; without textures, which some orders filter otherwise. */
static fnl_scene *ball_and_wall(void) {
    fnl_scene *scene = coarse_scene();
    fnl_material_params params = fnl_material_params_default();
    fnl_material_id metal, paint;
    params.metallic = 0.7f;
    params.roughness = 0.3f;
    params.base_color[2] = 0.4f;
    assert_int_equal(fnl_scene_add_material(scene, &params, &metal), FNL_OK);
    params.metallic = 0;
    params.roughness = 0.6f;
    params.base_color[0] = 0.5f;
    assert_int_equal(fnl_scene_add_material(scene, &params, &paint), FNL_OK);
    coarse_add_sphere(scene, metal, 1);
    coarse_add_plane(scene, paint, -3, 1, -1.5f, 0.2f, 0);
    return scene;
}

/* `lit`: with a sun and a lamp beside it. */
static void expect_every_order_alike(fnl_energy energy, bool lit, uint32_t msaa) {
    fnl_scene *scene = ball_and_wall();
    fnl_light_params light = fnl_light_params_default();
    fnl_light_id id;
    surround(scene, false, 0.3f, 1, true);
    light.position = vec3_make(1, 2, 3);
    light.intensity = lit ? 5 : 0;
    assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
    light.kind = FNL_LIGHT_DIRECTIONAL;
    light.direction = vec3_make(1, -1, -1);
    light.intensity = lit ? 1 : 0;
    assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
    struct stage s = stage_open_scene(scene);
    s.frame.energy = energy;
    s.frame.width = 97, s.frame.height = 55;
    s.frame.outputs = FNL_OUTPUT_RADIANCE;
    s.frame.camera = fnl_camera_default();
    s.frame.camera.position = (fnl_vec3){0, 0, 5};
    s.frame.camera.target = (fnl_vec3){0, 0, 0};
    s.frame.msaa = msaa;
    s.frame.shading = FNL_SHADING_FORWARD;
    struct shot want = stage_shoot(&s, &s.frame);
    assert_int_equal(count_broken(&want.radiance), 0);
    for (int shading = 0; shading < FNL_SHADING_AUTO; shading++) {
        s.frame.shading = (fnl_shading)shading;
        const bool exact = shading == FNL_SHADING_DEFERRED || shading == FNL_SHADING_FORWARD_PREPASS || shading == FNL_SHADING_VISIBILITY;
        if (shading == FNL_SHADING_LOW_RES || shading == FNL_SHADING_INFERRED || (msaa > 1 && !exact)) continue; /* those two light fewer pixels */
        struct shot shot = stage_shoot(&s, &s.frame);
        const double off = relative_error(&shot.radiance, &want.radiance);
        print_message("%s, %u samples: %.4f off\n", fnl_value_name(FNL_ENUM_SHADING, s.frame.shading), msaa, off);
        assert_true(off < (shading_is(s.frame.shading, SHADING_APPROXIMATE) ? 0.012 : 0.002));
        shot_free(&shot);
    }
    shot_free(&want);
    stage_close(&s);
}

static void test_every_order_has_the_same_environment_EN_5(void **state) {
    UNUSED(state);
    for (int energy = 0; energy < FNL_ENERGY_COUNT; energy++) expect_every_order_alike((fnl_energy)energy, true, 1);
    expect_every_order_alike(FNL_ENERGY_GLTF, false, 1);
    expect_every_order_alike(FNL_ENERGY_CONSERVING, false, 4);
}

/* ---- lights that are parted off ---- */

static uint32_t light_count(const fnl_scene *scene) {
    fnl_scene_info info;
    assert_int_equal(fnl_scene_query_info(scene, &info), FNL_OK);
    return info.light_count;
}

/* The sun of the built-in sky becomes a light, follows the rotation, and goes with the environment; without parting it stays in the picture. */
static void test_bright_sources_become_lights_EN_3(void **state) {
    UNUSED(state);
    fnl_scene *scene = coarse_scene();
    fnl_environment_params params = fnl_environment_params_default();
    fnl_light_params sun;
    params.source = "builtin:sky";
    const uint32_t before = light_count(scene);
    assert_int_equal(fnl_scene_set_environment(scene, &params), FNL_OK);
    assert_int_equal(light_count(scene), before + 1);
    assert_int_equal(fnl_scene_query_light(scene, before, &sun), FNL_OK);
    assert_int_equal(sun.kind, FNL_LIGHT_DIRECTIONAL);
    assert_true(sun.casts_shadows);
    const float height = 40 * PI / 180, azimuth = 60 * PI / 180;
    assert_float_equal(sun.direction.y, -sinf(height), 0.01f);
    assert_float_equal(sun.direction.x, -cosf(height) * cosf(azimuth), 0.01f);
    const float strength = sun.intensity * sun.color[0];
    assert_true(strength > 7e4f && strength < 1.2e5f);
    params.rotation = 30 * PI / 180; /* anticlockwise from above: +X goes towards -Z */
    params.intensity = 2;
    assert_int_equal(fnl_scene_set_environment(scene, &params), FNL_OK);
    assert_int_equal(light_count(scene), before + 1);
    assert_int_equal(fnl_scene_query_light(scene, before, &sun), FNL_OK);
    assert_float_equal(sun.direction.x, -cosf(height) * cosf(azimuth - params.rotation), 0.01f);
    assert_float_equal(sun.direction.z, -cosf(height) * sinf(azimuth - params.rotation), 0.01f);
    assert_float_equal(sun.intensity * sun.color[0], 2 * strength, 1);
    params.lights = false;
    assert_int_equal(fnl_scene_set_environment(scene, &params), FNL_OK);
    assert_int_equal(light_count(scene), before);
    params.lights = true;
    assert_int_equal(fnl_scene_set_environment(scene, &params), FNL_OK);
    assert_int_equal(fnl_scene_set_environment(scene, NULL), FNL_OK);
    assert_int_equal(light_count(scene), before);
    fnl_scene_destroy(&scene);
}

/* ---- what it costs ---- */

static bool has_pass(const struct stage *s, const char *name) {
    fnl_frame_stats stats;
    assert_int_equal(fnl_renderer_query_stats(s->renderer, &stats), FNL_OK);
    for (uint32_t i = 0; i < stats.pass_count; i++)
        if (strstr(stats.passes[i].name, name)) return true;
    return false;
}

/* Maps are made once, and again when the picture changes, not when it turns; without an environment no pass is added. A hidden one is not seen. */
static void test_maps_are_made_once_EN_6(void **state) {
    UNUSED(state);
    struct stage s = stage_open("builtin:spheres?lights=1", 0);
    s.frame.timers = true;
    s.frame.outputs = FNL_OUTPUT_RADIANCE;
    const bool filters[] = {false, true, false, false, true, false}, sky[] = {false, true, true, true, false, false};
    struct shot plain = {0};
    for (uint32_t i = 0; i < 6; i++) {
        if (i == 1) surround(s.scene, false, 0, 1, true);
        fnl_environment_params params = fnl_environment_params_default();
        params.source = "builtin:overcast";
        if (i == 3) assert_int_equal(fnl_scene_query_info(s.scene, &(fnl_scene_info){0}), FNL_OK);
        params.background = false;
        if (i == 4) assert_int_equal(fnl_scene_set_environment(s.scene, &params), FNL_OK);
        if (i == 5) assert_int_equal(fnl_scene_set_environment(s.scene, NULL), FNL_OK);
        struct shot shot = stage_shoot(&s, &s.frame);
        assert_true(has_pass(&s, "environment filter") == filters[i]);
        assert_true(has_pass(&s, "sky") == sky[i]);
        const bool off = i == 0 || i == 5; /* not one pass, and no number */
        assert_true(has_pass(&s, "environment") == filters[i] && has_pass(&s, "reflectance") == filters[i]);
        assert_true(has_counter(&shot.stats, "environment.filtered") == !off && has_counter(&shot.stats, "environment.cached") == !off);
        assert_true(off || (counter(&shot.stats, "environment.filtered") == filters[i] && counter(&shot.stats, "environment.cached") == 0));
        if (i == 0) plain = shot;
        if (i == 5) assert_int_equal(count_differing(&plain.radiance, &shot.radiance), 0);
        if (i > 0) shot_free(&shot);
    }
    shot_free(&plain);
    stage_close(&s);
}

/* A compressed cube map shows the same picture, also when it is asked for later, and is of BC6H where the device can. */
static void test_frames_with_a_compressed_cube_BC_14(void **state) {
    UNUSED(state);
    const bool able = gpu_info(harness_device())->texture_compression;
    struct stage s = stage_open_scene(ball_and_wall());
    s.frame.width = 97, s.frame.height = 55;
    s.frame.outputs = FNL_OUTPUT_RADIANCE;
    struct shot want = {0};
    for (int i = 0; i < 3; i++) { /* the last frame reads what the one before has made */
        if (i < 2) surround_by(s.scene, false, 0.3f, 1, true, i);
        struct shot shot = stage_shoot(&s, &s.frame);
        const VkFormat format = s.renderer->device_scene->environment.cube.params.format;
        assert_int_equal(format, i && able ? VK_FORMAT_BC6H_UFLOAT_BLOCK : VK_FORMAT_R16G16B16A16_SFLOAT);
        if (i == 0) {
            want = shot;
            continue;
        }
        const double off = relative_error(&shot.radiance, &want.radiance);
        print_message("compressed: %.4f off\n", off);
        assert_true(off < 0.01 && (off > 0) == able);
        shot_free(&shot);
    }
    shot_free(&want);
    stage_close(&s);
}

/* A power of two on the picture, and its reciprocal as the intensity: half floats hold bright pictures and dim ones alike, with their colors. */
static void test_frames_of_bright_and_dim_pictures(void **state) {
    UNUSED(state);
    static const int powers[] = {0, 20, 60, -19};
    struct shot shots[COUNT_OF(powers)];
    for (uint32_t i = 0; i < COUNT_OF(powers); i++) {
        fnl_scene *scene = coarse_scene();
        fnl_material_params material = fnl_material_params_default();
        fnl_material_id id;
        material.metallic = 0.5f;
        material.roughness = 0.3f;
        assert_int_equal(fnl_scene_add_material(scene, &material, &id), FNL_OK);
        coarse_add_sphere(scene, id, 1);
        fnl_image image = picture(false);
        for (uint32_t k = 0; k < image.width * image.height * 4; k++) ((float *)image.pixels)[k] *= ldexpf(1, powers[i]);
        fnl_environment_params params = fnl_environment_params_default();
        params.image = &image;
        params.lights = false;
        params.intensity = ldexpf(1, -powers[i]);
        assert_int_equal(fnl_scene_set_environment(scene, &params), FNL_OK);
        free(image.pixels);
        struct stage s = stage_open_scene(scene);
        s.frame.width = s.frame.height = 32;
        s.frame.outputs = FNL_OUTPUT_RADIANCE;
        s.frame.camera = fnl_camera_default();
        s.frame.camera.position = (fnl_vec3){0, 0, 3};
        s.frame.camera.target = (fnl_vec3){0, 0, 0};
        shots[i] = stage_shoot(&s, &s.frame);
        stage_close(&s);
        if (i > 0 && memcmp(shots[0].radiance.pixels, shots[i].radiance.pixels, (size_t)32 * 32 * 16) != 0) fail_msg("2^%d: %g, must be %g", powers[i], (double)pixel(&shots[i], 16, 16)[0], (double)pixel(&shots[0], 16, 16)[0]);
    }
    for (uint32_t i = 0; i < COUNT_OF(powers); i++) shot_free(&shots[i]);
}

/* What is asked for and cannot be had changes nothing. */
static void test_bad_environments_change_nothing_EN_7(void **state) {
    UNUSED(state);
    fnl_scene *scene = coarse_scene();
    fnl_environment_params params = fnl_environment_params_default();
    float pixels[4 * 3 * 2] = {0};
    fnl_image odd = {3, 2, FNL_PIXEL_FORMAT_RGBA32F, pixels};
    params.source = "builtin:sky";
    assert_int_equal(fnl_scene_set_environment(scene, &params), FNL_OK);
    const uint32_t lights = light_count(scene);
    params.source = "builtin:nowhere";
    assert_int_equal(fnl_scene_set_environment(scene, &params), FNL_ERROR_UNSUPPORTED);
    params.source = "/nonexistent/picture.hdr";
    assert_int_not_equal(fnl_scene_set_environment(scene, &params), FNL_OK);
    params.source = NULL;
    params.image = &odd;
    assert_int_equal(fnl_scene_set_environment(scene, &params), FNL_ERROR_UNSUPPORTED);
    params.intensity = NAN;
    assert_int_equal(fnl_scene_set_environment(scene, &params), FNL_ERROR_INVALID);
    assert_int_equal(light_count(scene), lights);
    fnl_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_frames_with_a_compressed_cube_BC_14, harness_check),
        cmocka_unit_test_teardown(test_a_white_furnace_stays_white_EN_1, harness_check),
        cmocka_unit_test_teardown(test_the_sky_and_mirrors_follow_the_rotation_EN_4_MP_11_MB_10, harness_check),
        cmocka_unit_test_teardown(test_every_order_has_the_same_environment_EN_5, harness_check),
        cmocka_unit_test_teardown(test_bright_sources_become_lights_EN_3, harness_check),
        cmocka_unit_test_teardown(test_frames_of_bright_and_dim_pictures, harness_check),
        cmocka_unit_test_teardown(test_maps_are_made_once_EN_6, harness_check),
        cmocka_unit_test_teardown(test_bad_environments_change_nothing_EN_7, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
