/* SPDX-License-Identifier: MIT */
/** The picture a newcomer sees: default frames of many scenes, by how bright their surfaces are, and how much is lost in white or black. */
#include "tests/render_harness.h"
#include "tests/stand_in.h"

#include <math.h>

struct look {
    const char *source, *environment;
    /* Bounds, 0: those of all. Scenes by night, and rooms with one lamp, have their own. */
    double least_mean, most_bright, most_dark; /* mean of surfaces, of 255; parts of them above 253 and below 2 */
    bool shared;
};

static const struct look looks[] = {
    {.source = "builtin:city", .most_dark = 0.05}, /* night: gaps between houses that no lamp reaches */
    {.source = "builtin:hall"},
    {.source = "builtin:interior"},
    {.source = "builtin:wall", .least_mean = 50}, /* half of it is in the shadow of the other half */
    {.source = "builtin:spheres"},
    {.source = "builtin:pole"},
    {.source = "builtin:lamps"},
    {.source = "builtin:grass"},
    {.source = "builtin:onetile"},
    {.source = "builtin:nearplane"},
    {.source = "builtin:sky"},
    {.source = "builtin:glass"},
    {.source = "builtin:room"},
    {.source = "builtin:city?lights=0&blocks=2&sun=60000", .environment = "builtin:sky"},
    {.source = "FlightHelmet/FlightHelmet.gltf", .shared = true},
    {.source = "FlightHelmet/FlightHelmet.gltf", .environment = "peppermint_powerplant_1k.hdr", .shared = true},
    {.source = "DamagedHelmet.glb", .shared = true},
    {.source = "DamagedHelmet.glb", .environment = "spiaggia_di_mondello_1k.hdr", .shared = true},
    {.source = "Fox.glb", .shared = true},
    {.source = "CesiumMan.glb", .shared = true},
    {.source = "materials/ClearCoatCarPaint.glb", .shared = true},
    {.source = "materials/MetalRoughSpheresNoTextures.glb", .shared = true},
    {.source = "materials/SheenChair/SheenChair.gltf", .shared = true},
};

static struct stage open_look(const struct look *look) {
    fnl_scene *scene;
    fnl_environment_params environment = fnl_environment_params_default();
    fnl_load_params params = fnl_load_params_default();
    fnl_image panorama = {0};
    const char *path = look->shared ? stand_in_sample(look->source) : look->source;
    unsigned char *model = path ? NULL : stand_in_model(look->source, &params.size);
    params.data = model;
    assert_int_equal(fnl_scene_load(gpu_host(harness_device()), path ? path : look->source, &params, &scene), FNL_OK);
    free(model);
    environment.source = look->shared && look->environment ? stand_in_sample(look->environment) : look->environment;
    if (look->environment && !environment.source) panorama = stand_in_panorama(look->environment), environment.image = &panorama;
    if (look->environment) assert_int_equal(fnl_scene_set_environment(scene, &environment), FNL_OK);
    free(panorama.pixels);
    return stage_open_scene(scene);
}

struct seen {
    double mean, bright, dark, surfaces;
};

/* Of pixels that show a surface. */
static struct seen look_at(struct stage *s, const fnl_camera *camera) {
    fnl_frame frame = fnl_frame_default();
    frame.width = 128, frame.height = 72;
    frame.camera = *camera;
    frame.lists = FNL_LISTS_CLUSTERED;
    frame.outputs = FNL_OUTPUT_COLOR | FNL_OUTPUT_NORMAL;
    frame.timers = false;
    struct shot shot = stage_shoot(s, &frame);
    struct seen out = {0};
    for (size_t i = 0; i < 128 * 72; i++) {
        const uint8_t *c = (const uint8_t *)shot.color.pixels + 4 * i;
        const double luminance = 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
        if (!(((const float *)shot.normal.pixels)[4 * i + 3] > 0)) continue;
        out.surfaces++;
        out.mean += luminance;
        out.bright += luminance > 253;
        out.dark += luminance < 2;
    }
    shot_free(&shot);
    if (out.surfaces > 0) out.mean /= out.surfaces, out.bright /= out.surfaces, out.dark /= out.surfaces;
    return out;
}

static void test_default_pictures_are_well_exposed(void **state) {
    UNUSED(state);
    uint32_t wrong = 0;
    for (uint32_t i = 0; i < COUNT_OF(looks); i++) {
        const struct look *look = &looks[i];
        struct stage s = open_look(look);
        const struct seen seen = look_at(&s, &s.frame.camera);
        const double least = look->least_mean > 0 ? look->least_mean : 70, bright = look->most_bright > 0 ? look->most_bright : 0.01,
                     dark = look->most_dark > 0 ? look->most_dark : 0.02;
        const bool good = seen.surfaces > 0 && seen.mean >= least && seen.mean <= 150 && seen.bright <= bright && seen.dark <= dark;
        print_message("%s %s%s%s: mean %.0f, %.2f %% white, %.2f %% black\n", good ? "      " : "WRONG:", look->source, look->environment ? " in " : "",
                      look->environment ? look->environment : "", seen.mean, 100 * seen.bright, 100 * seen.dark);
        wrong += !good;
        stage_close(&s);
    }
    assert_int_equal(wrong, 0);
}

/* A dark thing on a turntable before a bright wall on one side: what is metered is the thing, so the exposure hardly changes. */
static void test_exposure_is_steady_on_a_turntable(void **state) {
    UNUSED(state);
    fnl_scene *scene;
    assert_int_equal(fnl_scene_create(gpu_host(harness_device()), &scene), FNL_OK);
    enum { WIDTH = 64, HEIGHT = 32 };
    static float pixels[WIDTH * HEIGHT * 4];
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        for (int c = 0; c < 4; c++) pixels[4 * i + c] = i % WIDTH < WIDTH / 4 ? 4 : 0.5f;
    const fnl_image image = {WIDTH, HEIGHT, FNL_PIXEL_FORMAT_RGBA32F, pixels};
    fnl_environment_params params = fnl_environment_params_default();
    params.image = &image;
    assert_int_equal(fnl_scene_set_environment(scene, &params), FNL_OK);
    fnl_material_params dark = fnl_material_params_default();
    fnl_material_id material;
    dark.base_color[0] = dark.base_color[1] = dark.base_color[2] = 0.05f;
    dark.metallic = 0;
    assert_int_equal(fnl_scene_add_material(scene, &dark, &material), FNL_OK);
    const float positions[] = {-1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1, -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1};
    const uint32_t indices[] = {0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4, 3, 7, 6, 3, 6, 2, 0, 4, 7, 0, 7, 3, 1, 2, 6, 1, 6, 5};
    const fnl_mesh_params cube = {.vertex_count = 8, .index_count = 36, .positions = positions, .indices = indices, .material = material};
    const fnl_mat4 identity = mat4_identity();
    fnl_mesh_id mesh;
    fnl_instance_id instance;
    assert_int_equal(fnl_scene_add_mesh(scene, &cube, &mesh), FNL_OK);
    assert_int_equal(fnl_scene_add_instance(scene, mesh, &identity, &instance), FNL_OK);
    struct stage s = stage_open_scene(scene);
    double low = 99, high = -99;
    for (int i = 0; i < 8; i++) {
        fnl_camera camera = s.frame.camera;
        const float angle = (float)i * PI / 4;
        camera.position = (fnl_vec3){5 * sinf(angle), 2, 5 * cosf(angle)};
        camera.target = (fnl_vec3){0, 0, 0};
        const struct seen seen = look_at(&s, &camera);
        if (!(seen.mean > 70 && seen.mean < 150)) fail_msg("%d degrees: mean %.0f", 45 * i, seen.mean);
        fnl_frame_stats stats;
        assert_int_equal(fnl_renderer_query_stats(s.renderer, &stats), FNL_OK);
        low = fmin(low, (double)stats.ev), high = fmax(high, (double)stats.ev);
    }
    print_message("EV100 %.2f to %.2f\n", low, high);
    assert_true(high - low < 2.1); /* a side that faces the wall gets that much more light */
    stage_close(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_default_pictures_are_well_exposed, harness_check),
        cmocka_unit_test_teardown(test_exposure_is_steady_on_a_turntable, harness_check),
    };
    return cmocka_run_group_tests_name("look", tests, harness_begin, harness_end);
}
