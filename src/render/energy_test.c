/* SPDX-License-Identifier: MIT */
/** The energy model of materials: white balls in uniform white light from an environment, from ambient light or from suns all around. */
#include "tests/coarse_cases.h"
#include "tests/render_test.h"

enum { SIDE = 16, SUNS = 256 };

enum light { LIGHT_ENVIRONMENT, LIGHT_AMBIENT, LIGHT_SUNS };

struct ball {
    float metallic, roughness, coat, sheen;
};

static void add_suns(fnl_scene *scene) {
    for (uint32_t i = 0; i < SUNS; i++) { /* spread evenly along a spiral */
        fnl_light_params sun = fnl_light_params_default();
        fnl_light_id id;
        const float z = 1 - 2 * ((float)i + 0.5f) / SUNS, angle = 2.39996323f * (float)i, away = sqrtf(1 - z * z);
        sun.kind = FNL_LIGHT_DIRECTIONAL;
        sun.direction = vec3_make(away * cosf(angle), away * sinf(angle), z);
        sun.intensity = 4 * PI / SUNS;
        assert_int_equal(fnl_scene_add_light(scene, &sun, &id), FNL_OK);
    }
}

static struct stage open_ball(const struct ball *b, enum light light) {
    fnl_scene *scene = coarse_scene();
    fnl_material_params params = fnl_material_params_default();
    fnl_material_id material;
    params.metallic = b->metallic;
    params.roughness = b->roughness;
    params.clearcoat = (fnl_clearcoat_params){.strength = b->coat, .roughness = 0.3f};
    params.sheen = (fnl_sheen_params){.color = {b->sheen, b->sheen, b->sheen}, .roughness = 0.5f};
    assert_int_equal(fnl_scene_add_material(scene, &params, &material), FNL_OK);
    test_place(scene, test_sphere_mesh(scene, material.index, 64), (vec3){0, 0, 0}, (vec3){1, 1, 1}); /* its normals lean very little */
    assert_int_equal(fnl_scene_set_ambient(scene, (fnl_vec3){light == LIGHT_AMBIENT, light == LIGHT_AMBIENT, light == LIGHT_AMBIENT},
                                           (fnl_vec3){light == LIGHT_AMBIENT, light == LIGHT_AMBIENT, light == LIGHT_AMBIENT}),
                     FNL_OK);
    if (light == LIGHT_SUNS) add_suns(scene);
    if (light == LIGHT_ENVIRONMENT) {
        float texels[8] = {1, 1, 1, 1, 1, 1, 1, 1};
        fnl_image even = {2, 1, FNL_PIXEL_FORMAT_RGBA32F, texels};
        fnl_environment_params environment = fnl_environment_params_default();
        environment.image = &even;
        assert_int_equal(fnl_scene_set_environment(scene, &environment), FNL_OK);
    }
    struct stage s = stage_open_scene(scene);
    s.frame.width = s.frame.height = SIDE;
    s.frame.outputs = FNL_OUTPUT_RADIANCE;
    s.frame.shading = FNL_SHADING_FORWARD;
    s.frame.studio = false;
    s.frame.shadows = FNL_SHADOWS_OFF;
    s.frame.camera = fnl_camera_default();
    s.frame.camera.position = vec3_make(0, 0, 6);
    s.frame.camera.target = vec3_make(0, 0, 0);
    s.frame.camera.vertical_fov = 0.2f; /* within the ball: no silhouette */
    return s;
}

static double mean_of(const fnl_image *image) {
    const float *pixels = image->pixels;
    double sum = 0;
    for (size_t i = 0; i < SIDE * SIDE; i++) sum += (double)pixels[4 * i + 1];
    return sum / (SIDE * SIDE);
}

static double drawn(struct stage *s, fnl_energy energy) {
    s->frame.energy = energy;
    struct shot shot = stage_shoot(s, &s->frame);
    const double mean = mean_of(&shot.radiance);
    shot_free(&shot);
    return mean;
}

static double traced(const struct stage *s, fnl_energy energy) {
    fnl_trace_params p = trace_plain();
    fnl_trace trace;
    p.width = p.height = SIDE, p.camera = s->frame.camera;
    p.energy = energy;
    p.shadows = false;
    p.samples = 8;
    assert_int_equal(fnl_scene_trace(s->scene, &p, &trace), FNL_OK);
    const double mean = mean_of(&trace.radiance);
    fnl_trace_free(&s->scene->host, &trace);
    return mean;
}

static const struct ball balls[] = {
    {0, 0.4f, 0, 0}, {0, 0.7f, 0, 0}, {0, 1, 0, 0}, {0.5f, 0.7f, 0, 0}, {1, 0.4f, 0, 0}, {1, 0.7f, 0, 0}, {1, 1, 0, 0},
    {1, 1, 1, 0},    {0, 0.7f, 1, 0}, {1, 0.7f, 0, 1}, {0, 0.4f, 0, 1}, {0.5f, 1, 1, 1},
};

/* The same light in another form gives the same ball, in frames and traced; conserving, all of it. */
static void test_one_model_for_all_light(void **state) {
    UNUSED(state);
    for (uint32_t i = 0; i < COUNT_OF(balls); i++) {
        double means[FNL_ENERGY_COUNT][3][2];
        for (int light = 0; light < 3; light++) {
            struct stage s = open_ball(&balls[i], (enum light)light);
            for (int energy = 0; energy < FNL_ENERGY_COUNT; energy++) {
                means[energy][light][0] = drawn(&s, (fnl_energy)energy);
                means[energy][light][1] = traced(&s, (fnl_energy)energy);
            }
            stage_close(&s);
        }
        const struct ball *b = &balls[i];
        for (int energy = 0; energy < FNL_ENERGY_COUNT; energy++) {
            double(*m)[2] = means[energy];
            const double truth = m[LIGHT_ENVIRONMENT][0];
            print_message("%s, metal %.1f, roughness %.1f, coat %.0f, sheen %.0f: environment %.4f traced %.4f, ambient %.4f traced %.4f, suns %.4f traced %.4f\n",
                          fnl_value_name(FNL_ENUM_ENERGY, (uint32_t)energy), (double)b->metallic, (double)b->roughness, (double)b->coat, (double)b->sheen, m[0][0], m[0][1],
                          m[1][0], m[1][1], m[2][0], m[2][1]);
            for (int light = 0; light < 3; light++)
                for (int how = 0; how < 2; how++) {
                    const bool fitted = light == LIGHT_AMBIENT && energy == FNL_ENERGY_GLTF && b->coat == 0 && b->sheen == 0; /* environment_brdf() */
                    const bool sampled = light == LIGHT_ENVIRONMENT && how == 1;
                    assert_true(fabs(m[light][how] - truth) < (fitted || sampled ? 0.025 : 0.01));
                }
            if (energy == FNL_ENERGY_CONSERVING) assert_true(fabs(truth - 1) < 0.02);
        }
        if (b->metallic == 1 && b->roughness == 1) assert_true(means[FNL_ENERGY_GLTF][LIGHT_SUNS][0] < 0.6); /* it makes a difference */
    }
}

/* Frames with either model may follow each other, and conserving ones can be warmed up: the reflectance table exists in time. */
static void test_the_model_may_change_between_frames(void **state) {
    UNUSED(state);
    const struct ball ball = {1, 1, 0, 0};
    struct stage s = open_ball(&ball, LIGHT_SUNS);
    const double gltf = drawn(&s, FNL_ENERGY_GLTF);
    s.frame.energy = FNL_ENERGY_CONSERVING;
    assert_int_equal(fnl_renderer_warm(s.renderer, &s.frame, NULL, true, NULL), FNL_OK);
    const double conserving = drawn(&s, FNL_ENERGY_CONSERVING);
    assert_true(conserving > 1.5 * gltf && fabs(conserving - 1) < 0.02);
    assert_true(drawn(&s, FNL_ENERGY_GLTF) == gltf && drawn(&s, FNL_ENERGY_CONSERVING) == conserving);
    stage_close(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_one_model_for_all_light, harness_check),
        cmocka_unit_test_teardown(test_the_model_may_change_between_frames, harness_check),
    };
    return cmocka_run_group_tests_name("energy", tests, test_group_begin, test_group_end);
}
