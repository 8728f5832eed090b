/* SPDX-License-Identifier: MIT */
/** Environments of a scene: those made by code, their units, their suns, and how they stand beside the scene's own lights. */
#include "scene/scene.h"
#include "tests/gltf_test_file.h"

#include <setjmp.h>
#include <stdlib.h>
#include <unistd.h>

#include <cmocka.h>

static struct test_log lines;

static fnl_scene *empty(void) {
    fnl_host host = test_host(&lines);
    fnl_scene *scene;
    lines = (struct test_log){0};
    assert_int_equal(scene_create(&host, "test", &scene), FNL_OK);
    return scene;
}

static void surround(fnl_scene *scene, const char *source, float rotation, bool lights) {
    fnl_environment_params params = fnl_environment_params_default();
    params.source = source;
    params.rotation = rotation;
    params.lights = lights;
    if (fnl_scene_set_environment(scene, &params) != FNL_OK) fail_msg("%s: %s", source, lines.text);
}

static float luminance(const float *c) { return 0.2126f * c[0] + 0.7152f * c[1] + 0.0722f * c[2]; }

static float seen(const fnl_scene *scene, vec3 direction) {
    const struct panorama *p = &scene->environment.panorama;
    float x, y;
    panorama_place(p, direction, &x, &y);
    const uint32_t column = (uint32_t)(lroundf(x) + (long)p->width) % p->width, row = (uint32_t)CLAMP(lroundf(y), 0, (long)p->height - 1);
    return luminance(p->texels + 3 * ((size_t)row * p->width + column));
}

static uint32_t add_sun(fnl_scene *scene, vec3 toward, float lux) {
    fnl_light_params sun = fnl_light_params_default();
    fnl_light_id id;
    sun.kind = FNL_LIGHT_DIRECTIONAL;
    sun.direction = vec3_scale(vec3_normalize(toward), -1);
    sun.intensity = lux;
    assert_int_equal(fnl_scene_add_light(scene, &sun, &id), FNL_OK);
    return id.index;
}

/* ---- skies ---- */

/* The sun dims and reddens as it sinks, and is gone below the horizon; the sky is as bright as tables of daylight and twilight say. */
static void test_skies_are_in_physical_units(void **state) {
    UNUSED(state);
    static const struct {
        int elevation;
        float sun[2], zenith[2]; /* lux, cd/m^2: between */
    } cases[] = {{80, {8.5e4f, 1.2e5f}, {3e3f, 2e4f}}, {40, {7e4f, 1e5f}, {1e3f, 5e3f}}, {10, {1e4f, 5e4f}, {500, 3e3f}}, {2, {100, 1e4f}, {200, 1500}}, {-3, {0, 0}, {2, 40}}};
    float before = FLT_MAX, red_before = 0;
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        char name[64];
        fnl_scene *scene = empty();
        snprintf(name, sizeof name, "builtin:sky?elevation=%d&azimuth=30", cases[i].elevation);
        surround(scene, name, 0, true);
        const float zenith = seen(scene, vec3_make(0, 1, 0)), height = (float)cases[i].elevation * (PI / 180);
        assert_true(zenith > cases[i].zenith[0] && zenith < cases[i].zenith[1] && zenith < before);
        before = zenith;
        assert_int_equal(scene->suns.count, cases[i].elevation > 0);
        if (cases[i].elevation > 0) {
            const fnl_light_params *sun = &scene->lights.data[0].params;
            const float lux = sun->intensity * luminance(sun->color), red = sun->color[0] / sun->color[2];
            print_message("%d degrees: %.0f lux, red over blue %.2f, zenith %.0f cd/m^2\n", cases[i].elevation, (double)lux, (double)red, (double)zenith);
            assert_true(lux > cases[i].sun[0] && lux < cases[i].sun[1] && red > red_before);
            assert_float_equal(sun->direction.y, -sinf(height), 1e-5f);
            assert_float_equal(sun->direction.x, -cosf(height) * cosf(PI / 6), 1e-5f);
            assert_float_equal(sun->direction.z, -cosf(height) * sinf(PI / 6), 1e-5f);
            assert_float_equal(sun->source_angle, 0.00465f, 1e-5f);
            red_before = red;
        }
        fnl_scene_destroy(&scene);
    }
    fnl_scene *scene = empty();
    surround(scene, "builtin:overcast", 0, true);
    assert_float_equal(seen(scene, vec3_make(0, 1, 0)), 4000, 40);
    assert_int_equal(scene->lights.count, 0);
    surround(scene, "builtin:sky?turbidity=2", 0, true);
    const float clear = scene->lights.data[0].params.intensity;
    surround(scene, "builtin:sky?turbidity=8.5", 0, true);
    assert_true(scene->lights.data[0].params.intensity < 0.6f * clear);
    fnl_scene_destroy(&scene);
}

static void test_wrong_environments_are_explained(void **state) {
    UNUSED(state);
    static const struct {
        const char *name, *message;
    } cases[] = {{"builtin:ski", "there is no environment 'ski'; there are: studio, sky, overcast"},
                 {"builtin:sky?elevation=91", "elevation=91 is not a number from -6 to 90"},
                 {"builtin:sky?elevation=-6.5", "elevation=-6.5 is not a number from -6 to 90"},
                 {"builtin:sky?turbidity=1e1", "turbidity=1e1 is not a number from 2 to 10"},
                 {"builtin:sky?azimuth=", "azimuth= is not a number from -360 to 360"},
                 {"builtin:sky?azimuth=-", "azimuth=- is not a number"},
                 {"builtin:sky?sun=0.5", "sun=0.5 is not a whole number from 0 to 1"},
                 {"builtin:sky?clouds=1", "'clouds=1' is not a key of sky with a value; there are: elevation=-6..90, azimuth=-360..360, turbidity=2..10, sun=0..1"},
                 {"builtin:studio?sun=1", "'sun=1' is not a key of studio with a value; there are: none"}};
    fnl_scene *scene = empty();
    fnl_environment_params params = fnl_environment_params_default();
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        lines = (struct test_log){0};
        params.source = cases[i].name;
        assert_int_not_equal(fnl_scene_set_environment(scene, &params), FNL_OK);
        if (!strstr(lines.text, cases[i].message)) fail_msg("%s: %s", cases[i].name, lines.text);
        assert_int_equal(scene->environment.panorama.width, 0);
    }
    fnl_scene_destroy(&scene);
}

/* One sun: the scene's. The sky is bright where it is, however the environment is turned; who says otherwise gets both. */
static void test_a_sky_beside_a_sun(void **state) {
    UNUSED(state);
    for (int turned = 0; turned < 2; turned++) {
        const vec3 toward = vec3_normalize(vec3_make(-0.6f, 0.5f, 0.3f));
        const float rotation = turned ? 1.1f : 0;
        fnl_scene *scene = empty();
        fnl_environment_params params;
        const uint32_t sun = add_sun(scene, toward, 60000);
        surround(scene, "builtin:sky?turbidity=3", rotation, true);
        assert_int_equal(scene->suns.count, 1);
        assert_true(scene->lights.data[sun].params.intensity == 60000);
        vec3 rows[3];
        scene_environment_axes(&scene->environment, rows);
        const vec3 there = vec3_make(vec3_dot(rows[0], toward), vec3_dot(rows[1], toward), vec3_dot(rows[2], toward));
        const float at_sun = seen(scene, there);
        for (int k = 0; k < 12; k++) {
            const float turn = (float)k * (PI / 6), across = sqrtf(1 - toward.y * toward.y);
            const vec3 other = vec3_make(across * cosf(turn), toward.y, across * sinf(turn));
            if (vec3_dot(other, there) < 0.98f) assert_true(seen(scene, other) < 0.7f * at_sun);
        }
        assert_int_equal(fnl_scene_query_environment(scene, &params), FNL_OK);
        assert_true(strstr(params.source, "sun=0&elevation=36.70&azimuth=") != NULL);
        assert_int_equal(fnl_scene_set_environment(scene, &params), FNL_OK); /* what is queried is what is set */
        assert_int_equal(scene->suns.count, 1);
        surround(scene, "builtin:sky?elevation=20", rotation, true);
        assert_int_equal(scene->suns.count, 1);
        assert_string_equal(scene->environment.name, "builtin:sky?elevation=20&sun=0");
        surround(scene, "builtin:sky?sun=1", rotation, true);
        assert_int_equal(scene->suns.count, 2);
        surround(scene, "builtin:sky", rotation, true); /* its own sun is none of the scene's */
        assert_int_equal(scene->suns.count, 1);
        fnl_scene_destroy(&scene);
    }
}

/* ---- the studio ---- */

/* Its key light is a directional light of some size; or all of that light is in the picture. */
static void test_the_studio_has_a_key_light(void **state) {
    UNUSED(state);
    fnl_scene *scene = empty();
    surround(scene, "builtin:studio", 0, true);
    assert_int_equal(scene->suns.count, 1);
    const fnl_light_params key = scene->lights.data[0].params;
    assert_true(key.casts_shadows && key.source_angle > 0.02f && key.source_angle < 5 * PI / 180 && key.direction.y < -0.4f);
    const double without = panorama_flux(&scene->environment.panorama);
    surround(scene, "builtin:studio", 0, false);
    assert_int_equal(scene->suns.count, 0);
    const double with = panorama_flux(&scene->environment.panorama), lux = (double)(key.intensity * luminance(key.color));
    assert_true(fabs((with - without) / lux - 1) < 0.01);
    fnl_scene_destroy(&scene);
}

/* ---- pictures ---- */

enum { WIDTH = 64, HEIGHT = 32 };

static void show(fnl_scene *scene, float even, uint32_t at, float bright, bool lights, bool automatic) {
    static float pixels[WIDTH * HEIGHT * 4];
    for (uint32_t i = 0; i < WIDTH * HEIGHT * 4; i++) pixels[i] = even;
    for (uint32_t c = 0; c < 3; c++) pixels[4 * at + c] = bright;
    const fnl_image image = {WIDTH, HEIGHT, FNL_PIXEL_FORMAT_RGBA32F, pixels};
    fnl_environment_params params = fnl_environment_params_default();
    params.image = &image;
    params.lights = lights;
    params.intensity_auto = automatic;
    assert_int_equal(fnl_scene_set_environment(scene, &params), FNL_OK);
}

/* Half floats hold the picture in its unit: a power of two that leaves the greatest value the most bits. */
static void check_unit(const struct scene_environment *e) {
    float most = 0;
    int exponent;
    for (uint32_t i = 0; i < WIDTH * HEIGHT * 3; i++) most = fmaxf(most, e->panorama.texels[i]);
    assert_true(frexpf(e->unit, &exponent) == 0.5f);
    if (!(most / e->unit <= 65504 && most / e->unit > 32000)) fail_msg("%g in units of %g", (double)most, (double)e->unit);
}

/* A sun becomes a light with all that it gives; left in the picture it stays what it is, with its color. */
static void test_suns_keep_their_light(void **state) {
    UNUSED(state);
    const uint32_t at = 10 * WIDTH + 20;
    const float step = PI / HEIGHT, angle = 2 * PI / WIDTH * (cosf(step * 10) - cosf(step * 11));
    for (int lights = 0; lights < 2; lights++) {
        fnl_scene *scene = empty();
        show(scene, 3000, at, 1e9f, lights, false);
        const struct panorama *p = &scene->environment.panorama;
        check_unit(&scene->environment);
        assert_true(lights ? p->texels[3 * at] < 65504 : p->texels[3 * at] == 1e9f);
        assert_int_equal(scene->suns.count, lights);
        if (lights) {
            const fnl_light_params *sun = &scene->lights.data[0].params;
            assert_true(fabsf(sun->intensity / (1e9f * angle) - 1) < 1e-3f);
            assert_true(fabsf(sun->source_angle / acosf(1 - angle / (2 * PI)) - 1) < 1e-3f);
        }
        fnl_scene_destroy(&scene);
    }
}

/* ---- which sources are taken out ---- */

#define EVEN 3000.0f

static double angle_of(uint32_t row) { /* of a texel: steradian */
    const double step = (double)PI / HEIGHT;
    return 2 * (double)PI / WIDTH * (cos(step * row) - cos(step * (row + 1)));
}

/* A gray picture with its own value in each texel, whose sources are taken out. */
static fnl_scene *show_texels(const float *luminances) {
    static float pixels[WIDTH * HEIGHT * 4];
    fnl_scene *scene = empty();
    for (uint32_t i = 0; i < WIDTH * HEIGHT * 4; i++) pixels[i] = luminances[i / 4];
    const fnl_image image = {WIDTH, HEIGHT, FNL_PIXEL_FORMAT_RGBA32F, pixels};
    fnl_environment_params params = fnl_environment_params_default();
    params.image = &image;
    params.lights = true;
    assert_int_equal(fnl_scene_set_environment(scene, &params), FNL_OK);
    return scene;
}

static float *even_texels(void) {
    static float texels[WIDTH * HEIGHT];
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) texels[i] = EVEN;
    return texels;
}

static void expect_unchanged(const fnl_scene *scene, const float *luminances) {
    assert_int_equal(scene->suns.count, 0);
    for (uint32_t i = 0; i < WIDTH * HEIGHT * 3; i++) assert_true(scene->environment.panorama.texels[i] == luminances[i / 3]);
}

/* What is left in the picture where a source of this size was taken out: twelve times the mean of the picture as it is then. */
static double left_of(double angle) {
    const double part = angle / (4 * (double)PI);
    return 12 * (double)EVEN * (1 - part) / (1 - 12 * part);
}

/* A source is taken out when what it has above its surroundings is 2 % of all light: the rest stays in the picture, and nothing gets lost. */
static void test_sources_of_two_percent_are_taken_out(void **state) {
    UNUSED(state);
    static const struct {
        uint32_t row, column, count;
    } cases[] = {{16, 20, 1}, {10, 63, 1}, {9, 30, 2}, {14, 63, 2}, {6, 62, 4}}; /* the last two lie across the edge of the picture */
    for (uint32_t i = 0; i < COUNT_OF(cases); i++)
        for (int above = 0; above < 2; above++) {
            const double angle = cases[i].count * angle_of(cases[i].row), left = left_of(angle);
            const double others = (double)EVEN * (4 * (double)PI - angle);
            const float bright = (float)((0.02 * others + left * angle) / (0.98 * angle) * (above ? 1.005 : 0.995));
            float *texels = even_texels();
            for (uint32_t k = 0; k < cases[i].count; k++) texels[cases[i].row * WIDTH + (cases[i].column + k) % WIDTH] = bright;
            fnl_scene *scene = show_texels(texels);
            if (!above) {
                expect_unchanged(scene, texels);
                fnl_scene_destroy(&scene);
                continue;
            }
            if (scene->suns.count != 1) fail_msg("case %u: %u suns", i, scene->suns.count);
            const fnl_light_params *sun = &scene->lights.data[0].params;
            const double lux = (double)(sun->intensity * luminance(sun->color));
            assert_true(fabs(lux / (((double)bright - left) * angle) - 1) < 2e-3);
            assert_true(fabs((double)sun->source_angle / acos(1 - angle / (2 * (double)PI)) - 1) < 1e-3);
            const struct panorama *p = &scene->environment.panorama;
            const vec3 toward = panorama_direction(p, (float)cases[i].column + 0.5f * (float)(cases[i].count - 1), (float)cases[i].row);
            assert_true(vec3_dot(toward, sun->direction) < -0.9995f);
            for (uint32_t t = 0; t < WIDTH * HEIGHT; t++)
                if (fabs((double)p->texels[3 * t] / (texels[t] == bright ? left : (double)EVEN) - 1) > 1e-3) fail_msg("case %u: %g in texel %u", i, (double)p->texels[3 * t], t);
            fnl_scene_destroy(&scene);
        }
}

/* What is wider than ten degrees is no sun, however bright; nor are lamps of which none gives much. Of more than eight the eight brightest go. */
static void test_windows_and_many_lamps_stay(void **state) {
    UNUSED(state);
    static const struct {
        uint32_t row, columns, rows, suns;
    } windows[] = {{6, 4, 1, 1}, {5, 5, 1, 0}, {15, 3, 1, 0}, {12, 12, 8, 0}}; /* half angles: 4.9, 5.09, 5.5 degrees, large */
    for (uint32_t i = 0; i < COUNT_OF(windows); i++) {
        float *texels = even_texels();
        for (uint32_t y = 0; y < windows[i].rows; y++)
            for (uint32_t x = 0; x < windows[i].columns; x++) texels[(windows[i].row + y) * WIDTH + 20 + x] = 1e6f;
        fnl_scene *scene = show_texels(texels);
        assert_int_equal(scene->suns.count, windows[i].suns);
        if (windows[i].suns == 0) expect_unchanged(scene, texels);
        fnl_scene_destroy(&scene);
    }
    for (uint32_t lamps = 1; lamps <= 60; lamps += lamps == 1 ? 9 : 50) { /* 1, 10, 60 */
        float *texels = even_texels();
        for (uint32_t k = 0; k < lamps; k++) texels[(11 + 2 * (k / 20)) * WIDTH + 3 * (k % 20)] = 1e6f * (1 + 0.01f * (float)(k * 7 % 10));
        fnl_scene *scene = show_texels(texels);
        if (lamps == 60) expect_unchanged(scene, texels);
        assert_int_equal(scene->suns.count, lamps == 60 ? 0 : MIN(lamps, ENVIRONMENT_LIGHTS_MAX));
        for (uint32_t k = 0; k < lamps && lamps <= 10; k++) /* 0 and 3 are the dimmest of ten */
            assert_int_equal(scene->environment.panorama.texels[3 * (11 * WIDTH + 3 * k)] > 9e5f, lamps == 10 && (k == 0 || k == 3));
        fnl_scene_destroy(&scene);
    }
}

static void test_pictures_keep_their_values(void **state) {
    UNUSED(state);
    static const float values[] = {1e-38f, 3e-7f, 0.9999f, 1, 65504, 65530, 2e6f, 1e19f};
    static float pixels[WIDTH * HEIGHT * 4];
    for (uint32_t k = 0; k < COUNT_OF(values); k++) {
        fnl_scene *scene = empty();
        for (uint32_t i = 0; i < WIDTH * HEIGHT * 4; i++) pixels[i] = values[k] * (i % 4 == 1 ? 0.25f : 1);
        const fnl_image image = {WIDTH, HEIGHT, FNL_PIXEL_FORMAT_RGBA32F, pixels};
        fnl_environment_params params = fnl_environment_params_default();
        params.image = &image;
        assert_int_equal(fnl_scene_set_environment(scene, &params), FNL_OK);
        for (uint32_t i = 0; i < WIDTH * HEIGHT * 3; i++) assert_true(scene->environment.panorama.texels[i] == values[k] * (i % 3 == 1 ? 0.25f : 1));
        if (values[k] > 1e-30f) check_unit(&scene->environment);
        assert_true(1 / scene->environment.unit < INFINITY && scene->environment.unit > 0);
        fnl_scene_destroy(&scene);
    }
}

/* A sun of 60 000 lux gives 15 000 on average, a picture of 0.5 gives 1.57: the factor is 9549. Without it a line says so, once for each picture. */
static void test_relative_pictures_beside_lights(void **state) {
    UNUSED(state);
    for (int automatic = 0; automatic < 2; automatic++) {
        fnl_scene *scene = empty();
        fnl_environment_params params;
        show(scene, 0.5f, 0, 0.5f, true, automatic); /* without lights there is nothing to match */
        assert_int_equal(lines.count, 0);
        assert_int_equal(fnl_scene_query_environment(scene, &params), FNL_OK);
        assert_true(params.intensity == 1 && !params.intensity_auto);
        add_sun(scene, vec3_make(0, 1, 0), 60000);
        show(scene, 0.5f, 0, 0.5f, true, automatic);
        assert_int_equal(fnl_scene_query_environment(scene, &params), FNL_OK);
        assert_true(fabsf(params.intensity / (automatic ? 9549.3f : 1) - 1) < 1e-3f && !params.intensity_auto);
        assert_int_equal(lines.count, !automatic);
        if (!automatic && !strstr(lines.text, "its values look relative (mean 0.5, not cd/m^2), and the scene's lights give 9549 times as much")) fail_msg("%s", lines.text);
        lines = (struct test_log){0};
        show(scene, 2000, 0, 2000, true, false); /* in cd/m^2 */
        assert_int_equal(lines.count, 0);
        fnl_scene_destroy(&scene);
    }
}

static void test_pictures_are_counted_before_they_are_decoded(void **state) {
    UNUSED(state);
    static const struct {
        const char *name;
        uint64_t bytes; /* a pixel, with 12 as the scene keeps it */
        fnl_pixel_format format;
    } files[] = {{"a.exr", 16 + 12, FNL_PIXEL_FORMAT_RGBA32F}, {"a.hdr", 16 + 12, FNL_PIXEL_FORMAT_RGBA32F}, {"a.png", 4 + 12, FNL_PIXEL_FORMAT_RGBA8}, {"b.png", 8 + 12, FNL_PIXEL_FORMAT_RGBA16}};
    static uint8_t pixels[64 * 32 * 16];
    char folder[] = "/tmp/fanal-environment-XXXXXX";
    assert_non_null(mkdtemp(folder));
    for (uint32_t i = 0; i < COUNT_OF(files); i++) {
        char path[128], expected[256];
        snprintf(path, sizeof path, "%s/%s", folder, files[i].name);
        assert_int_equal(fnl_image_save(NULL, path, &(fnl_image){64, 32, files[i].format, pixels}), FNL_OK);
        fnl_scene *scene = empty();
        fnl_environment_params params = fnl_environment_params_default();
        const uint64_t usual = params.max_memory, needed = 64 * 32 * files[i].bytes;
        assert_true(usual >= (uint64_t)1 << 20);
        params.source = path;
        params.max_memory = needed - 1;
        assert_int_equal(fnl_scene_set_environment(scene, &params), FNL_ERROR_MEMORY);
        snprintf(expected, sizeof expected, "%s: the picture of 64 x 32 pixels needs %llu bytes of memory, over the limit of %llu", path,
                 (unsigned long long)needed, (unsigned long long)needed - 1);
        if (!strstr(lines.text, expected)) fail_msg("'%s' is not in '%s'", expected, lines.text);
        params.max_memory = needed;
        assert_int_equal(fnl_scene_set_environment(scene, &params), FNL_OK);
        assert_int_equal(fnl_scene_query_environment(scene, &params), FNL_OK);
        assert_true(params.max_memory == needed);
        fnl_scene_destroy(&scene);
        unlink(path);
    }
    rmdir(folder);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_skies_are_in_physical_units),     cmocka_unit_test(test_wrong_environments_are_explained),
        cmocka_unit_test(test_a_sky_beside_a_sun),              cmocka_unit_test(test_the_studio_has_a_key_light),
        cmocka_unit_test(test_pictures_keep_their_values),      cmocka_unit_test(test_sources_of_two_percent_are_taken_out),
        cmocka_unit_test(test_windows_and_many_lamps_stay),
        cmocka_unit_test(test_suns_keep_their_light),           cmocka_unit_test(test_relative_pictures_beside_lights),
        cmocka_unit_test(test_pictures_are_counted_before_they_are_decoded),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
