/* SPDX-License-Identifier: MIT */
/** Frames of materials with layers: energy, every shading order, against rays, and what the others pay for them. */
#include "fanal/trace.h"
#include "render/shading.h"
#include "tests/coarse_cases.h"
#include "tests/render_harness.h"

/* ---- balls ---- */

enum { RINGS = 24, SEGMENTS = 48, VERTICES = (RINGS + 1) * (SEGMENTS + 1) };

/* Of radius 0.5; tangents run along its circles of latitude. */
static void add_ball(fnl_scene *scene, fnl_material_id material, float x, float y) {
    static float positions[VERTICES * 3], normals[VERTICES * 3], tangents[VERTICES * 4], uv[VERTICES * 2];
    static uint32_t indices[RINGS * SEGMENTS * 6];
    uint32_t count = 0;
    for (uint32_t i = 0; i < VERTICES; i++) {
        const float u = (float)(i % (SEGMENTS + 1)) / SEGMENTS, v = (float)(i / (SEGMENTS + 1)) / RINGS, phi = 2 * PI * u, theta = PI * v;
        const vec3 n = {sinf(theta) * cosf(phi), cosf(theta), -sinf(theta) * sinf(phi)};
        const float tangent[4] = {-sinf(phi), 0, -cosf(phi), 1};
        memcpy(&normals[i * 3], &n, sizeof n);
        for (int c = 0; c < 3; c++) positions[i * 3 + (uint32_t)c] = 0.5f * (&n.x)[c];
        memcpy(&tangents[i * 4], tangent, sizeof tangent);
        uv[i * 2] = u, uv[i * 2 + 1] = v;
    }
    for (uint32_t i = 0; i < RINGS * SEGMENTS; i++) {
        const uint32_t a = i / SEGMENTS * (SEGMENTS + 1) + i % SEGMENTS, b = a + SEGMENTS + 1, quad[6] = {a, b, a + 1, a + 1, b, b + 1};
        memcpy(&indices[count], quad, sizeof quad);
        count += 6;
    }
    const fnl_mesh_params mesh = {VERTICES, count, positions, normals, tangents, uv, NULL, indices, material};
    const fnl_mat4 place = mat4_translation((vec3){x, y, 0});
    fnl_mesh_id id;
    fnl_instance_id instance;
    assert_int_equal(fnl_scene_add_mesh(scene, &mesh, &id), FNL_OK);
    assert_int_equal(fnl_scene_add_instance(scene, id, &place, &instance), FNL_OK);
}

enum ball { CORE, COAT, CLOTH, SOAP, STEEL, BRUSHED, ALL, BALLS };

static fnl_material_params material_of(enum ball ball) {
    fnl_material_params p = fnl_material_params_default();
    const float colors[BALLS][3] = {{0.7f, 0.5f, 0.3f}, {0.6f, 0.05f, 0.05f}, {0.1f, 0.2f, 0.5f}, {0.1f, 0.1f, 0.1f}, {0.8f, 0.8f, 0.8f}, {0.9f, 0.8f, 0.6f}, {0.5f, 0.4f, 0.3f}};
    memcpy(p.base_color, colors[ball], sizeof colors[ball]);
    p.metallic = ball == STEEL || ball == BRUSHED ? 1 : ball == ALL ? 0.5f : 0;
    p.roughness = ball == BRUSHED || ball == ALL ? 0.4f : 0.6f;
    if (ball == COAT || ball == ALL) p.clearcoat = (fnl_clearcoat_params){.strength = 0.9f, .roughness = 0.25f};
    if (ball == CLOTH || ball == ALL) p.sheen = (fnl_sheen_params){.color = {0.9f, 0.6f, 0.8f}, .roughness = 0.4f};
    if (ball == SOAP || ball == STEEL || ball == ALL) p.iridescence = (fnl_iridescence_params){.strength = 1, .ior = 1.4f, .thickness_maximum = 450};
    if (ball == BRUSHED || ball == ALL) p.anisotropy = (fnl_anisotropy_params){.strength = 0.8f, .rotation = 0.6f};
    return p;
}

static fnl_scene *balls(bool layered) {
    fnl_scene *scene = coarse_scene();
    for (int ball = 0; ball < BALLS; ball++) {
        fnl_material_params p = material_of((enum ball)ball);
        const fnl_material_params plain = {.clearcoat = {0}};
        fnl_material_id id;
        if (!layered) p.clearcoat = plain.clearcoat, p.sheen = plain.sheen, p.iridescence = plain.iridescence, p.anisotropy = plain.anisotropy;
        assert_int_equal(fnl_scene_add_material(scene, &p, &id), FNL_OK);
        add_ball(scene, id, -1.8f + 1.2f * (float)(ball % 4), ball < 4 ? 0.65f : -0.65f);
    }
    return scene;
}

static void add_lights(fnl_scene *scene) {
    for (int i = 0; i < 8; i++)
        coarse_add_light(scene, i % 2 ? FNL_LIGHT_POINT : FNL_LIGHT_SPOT, (vec3){-2.4f + 0.7f * (float)i, i % 3 ? 1.6f : -1.5f, 1.2f + 0.2f * (float)(i % 4)}, 6);
    assert_int_equal(fnl_scene_set_ambient(scene, (fnl_vec3){0.5f, 0.6f, 0.8f}, (fnl_vec3){0.3f, 0.2f, 0.1f}), FNL_OK);
}

static struct stage open_balls(fnl_scene *scene) {
    struct stage s = stage_open_scene(scene);
    s.frame.width = 96, s.frame.height = 54;
    s.frame.outputs = FNL_OUTPUT_RADIANCE;
    s.frame.camera = fnl_camera_default();
    s.frame.camera.position = (fnl_vec3){0, 0, 4};
    s.frame.camera.target = (fnl_vec3){0, 0, 0};
    s.frame.camera.vertical_fov = 0.65f;
    return s;
}

/* Root of the squared differences over that of the squares; of the columns and rows of one ball. Edges may be a pixel off: what is black in
 * one of them is left out. */
static double difference(const fnl_image *a, const fnl_image *b, int ball) {
    const float *x = a->pixels, *y = b->pixels;
    double error = 0, sum = 0;
    for (uint32_t i = 0; i < a->width * a->height; i++) {
        const uint32_t column = i % a->width, row = i / a->width;
        if ((int)(column * 4 / a->width) != ball % 4 || (int)(row * 2 / a->height) != ball / 4) continue;
        if (x[4 * i] == 0 || y[4 * i] == 0) continue;
        for (uint32_t c = 0; c < 3; c++) {
            error += pow((double)x[4 * i + c] - (double)y[4 * i + c], 2);
            sum += pow((double)y[4 * i + c], 2);
        }
    }
    return sqrt(error / sum);
}

/* ---- the same as in double precision ---- */

static void test_layers_are_those_of_rays_MA_1(void **state) {
    UNUSED(state);
    static const char *const names[BALLS] = {"core", "clearcoat", "sheen", "film on plastic", "film on metal", "anisotropy", "all"};
    fnl_scene *scene = balls(true);
    add_lights(scene);
    struct stage s = open_balls(scene);
    s.frame.shading = FNL_SHADING_FORWARD;
    struct shot shot = stage_shoot(&s, &s.frame);
    fnl_trace_params p = fnl_trace_params_default();
    p.width = s.frame.width, p.height = s.frame.height, p.camera = s.frame.camera;
    p.shadows = false;
    fnl_trace trace;
    assert_int_equal(fnl_scene_trace(s.scene, &p, &trace), FNL_OK);
    for (int ball = 0; ball < BALLS; ball++) {
        const double off = difference(&shot.radiance, &trace.radiance, ball);
        print_message("%s: %.4f off\n", names[ball], off);
        assert_true(off < 0.01);
    }
    fnl_trace_free(&s.scene->host, &trace);
    shot_free(&shot);
    stage_close(&s);
}

/* ---- energy ---- */

/* White in white light: nothing gets lost between the layers, and nothing comes from nowhere. */
static void test_layers_keep_a_white_furnace_white_MA_2(void **state) {
    UNUSED(state);
    for (int i = 0; i < 6; i++) {
        fnl_scene *scene = coarse_scene();
        fnl_material_params m = fnl_material_params_default();
        const float roughness = 0.2f + 0.4f * (float)(i % 3);
        fnl_material_id id;
        float texel[8] = {1, 1, 1, 1, 1, 1, 1, 1};
        fnl_image image = {2, 1, FNL_PIXEL_FORMAT_RGBA32F, texel};
        fnl_environment_params even = fnl_environment_params_default();
        m.metallic = 0;
        m.roughness = i % 2 ? 0.3f : 0.8f;
        m.clearcoat = (fnl_clearcoat_params){.strength = 1, .roughness = roughness};
        if (i >= 3) m.sheen = (fnl_sheen_params){.color = {1, 1, 1}, .roughness = roughness};
        even.image = &image;
        assert_int_equal(fnl_scene_add_material(scene, &m, &id), FNL_OK);
        add_ball(scene, id, 0, 0);
        assert_int_equal(fnl_scene_set_environment(scene, &even), FNL_OK);
        struct stage s = open_balls(scene);
        s.frame.width = s.frame.height = 40;
        s.frame.camera.position.z = 2;
        struct shot shot = stage_shoot(&s, &s.frame);
        const float *pixels = shot.radiance.pixels;
        double worst = 0;
        for (uint32_t k = 0; k < 40 * 40 * 4; k++) worst = fmax(worst, k % 4 == 3 ? 0 : fabs((double)pixels[k] - 1));
        print_message("coat of roughness %.1f%s: %.4f off\n", (double)roughness, i >= 3 ? ", fibres" : "", worst);
        assert_true(worst < 0.02);
        shot_free(&shot);
        stage_close(&s);
    }
}

/* ---- orders ---- */

/* What an order cannot hold is drawn over its picture: all show the same. */
static void test_every_order_shades_layers_MA_3(void **state) {
    UNUSED(state);
    fnl_scene *scene = balls(true);
    add_lights(scene);
    struct stage s = open_balls(scene);
    for (uint32_t msaa = 1; msaa <= 4; msaa += 3) {
        s.frame.msaa = msaa;
        s.frame.shading = FNL_SHADING_FORWARD;
        struct shot want = stage_shoot(&s, &s.frame);
        for (int shading = 0; shading < FNL_SHADING_AUTO; shading++) {
            s.frame.shading = (fnl_shading)shading;
            const bool some = shading == FNL_SHADING_DEFERRED || shading == FNL_SHADING_LIGHT_PREPASS; /* visibility resolves edges otherwise, layers or not */
            if (msaa > 1 && !some) continue;
            struct shot shot = stage_shoot(&s, &s.frame);
            double worst = 0;
            for (int ball = COAT; ball < BALLS; ball++) worst = fmax(worst, difference(&shot.radiance, &want.radiance, ball));
            print_message("%s, %u samples: %.5f off\n", fnl_value_name(FNL_ENUM_SHADING, s.frame.shading), msaa, worst);
            assert_true(worst < 0.001);
            shot_free(&shot);
        }
        shot_free(&want);
    }
    stage_close(&s);
}

/* Beside them a core material keeps its bits, whatever is asked of the pipelines. */
static void test_core_materials_keep_their_bits_MA_4(void **state) {
    UNUSED(state);
    static const fnl_shading shadings[] = {FNL_SHADING_FORWARD, FNL_SHADING_DEFERRED, FNL_SHADING_VISIBILITY};
    fnl_scene *scenes[2] = {balls(false), balls(true)};
    struct shot shots[COUNT_OF(shadings)];
    for (int layered = 0; layered < 2; layered++) {
        add_lights(scenes[layered]);
        struct stage s = open_balls(scenes[layered]);
        for (uint32_t i = 0; i < COUNT_OF(shadings); i++) {
            s.frame.shading = shadings[i];
            struct shot shot = stage_shoot(&s, &s.frame);
            if (layered) {
                assert_true(difference(&shots[i].radiance, &shot.radiance, CORE) == 0);
                for (int ball = COAT; ball < BALLS; ball++) assert_true(difference(&shots[i].radiance, &shot.radiance, ball) > 0.02);
                shot_free(&shots[i]);
                shot_free(&shot);
            } else {
                shots[i] = shot;
            }
        }
        stage_close(&s);
    }
}

static bool has_pass(const struct stage *s, const char *name) {
    fnl_frame_stats stats;
    assert_int_equal(fnl_renderer_query_stats(s->renderer, &stats), FNL_OK);
    for (uint32_t i = 0; i < stats.pass_count; i++)
        if (strstr(stats.passes[i].name, name)) return true;
    return false;
}

/* Without layers no pass is added; with them one forward pass where the order cannot hold them, and the table is made once. */
static void test_layers_cost_only_where_they_are_MA_5(void **state) {
    UNUSED(state);
    for (int layered = 0; layered < 2; layered++) {
        fnl_scene *scene = balls(layered);
        add_lights(scene);
        struct stage s = open_balls(scene);
        s.frame.shading = FNL_SHADING_LIGHT_PREPASS;
        s.frame.timers = true;
        for (int frame = 0; frame < 2; frame++) {
            struct shot shot = stage_shoot(&s, &s.frame);
            assert_int_equal(has_pass(&s, "forward layers"), layered);
            assert_int_equal(has_pass(&s, "reflectance"), layered && frame == 0);
            shot_free(&shot);
        }
        stage_close(&s);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_layers_are_those_of_rays_MA_1, harness_check),
        cmocka_unit_test_teardown(test_layers_keep_a_white_furnace_white_MA_2, harness_check),
        cmocka_unit_test_teardown(test_every_order_shades_layers_MA_3, harness_check),
        cmocka_unit_test_teardown(test_core_materials_keep_their_bits_MA_4, harness_check),
        cmocka_unit_test_teardown(test_layers_cost_only_where_they_are_MA_5, harness_check),
    };
    return cmocka_run_group_tests_name("layers", tests, harness_begin, harness_end);
}
