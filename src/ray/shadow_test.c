/* SPDX-License-Identifier: MIT */
/* Shadows of the tracer: those whose edges are known, lights in awkward places, and soft ones. */
#include "tests/shadow_cases.h"

#include "scene/scene.h"
#include "tests/frame_plain.h"

enum { SIZE = SHADOW_SIZE };
static const vec3 LIGHT = {0.3f, 3, -0.2f};

static void measure(fnl_scene *scene, const fnl_trace_params *view, float *out) {
    fnl_trace_params p = *view;
    p.visibility = true;
    fnl_trace trace = trace_scene(scene, &p);
    for (uint32_t i = 0; i < SIZE * SIZE; i++) out[i] = pixel_at(&trace.visibility, i % SIZE, i / SIZE)[0];
    fnl_trace_free(NULL, &trace);
    fnl_scene_destroy(&scene);
}

static void test_known_shadows(void **state) {
    UNUSED(state);
    shadow_cases(&(struct shadow_cases){measure, 1e-6, 1e-3, true});
}

/* From just above the floor, where nothing hides it. */
static fnl_trace trace_floor(const fnl_scene *scene) {
    fnl_trace_params p = look_down(vec3_make(0, 0, 0), 8, 0.5f, SIZE);
    p.visibility = true;
    return trace_scene(scene, &p);
}

/* ---- lights in awkward places ---- */

static void test_light_inside_a_wall(void **state) {
    UNUSED(state);
    fnl_scene *scene = shadow_floor();
    fnl_material_params wall = matt(1);
    add_square(scene, &wall, (vec3){10, 1, 10},
               (vec3){0, LIGHT.y + 0.01f, 0}); /* two faces, a centimetre from the light each */
    add_square(scene, &wall, (vec3){10, 1, 10}, (vec3){0, LIGHT.y - 0.01f, 0});
    fnl_trace trace = trace_floor(scene);
    assert_float_equal(mean_of(&trace.visibility, 0), 0, 0);
    assert_float_equal(mean_of(&trace.radiance, 0), 0, 0);
    assert_true(mean_of(&trace.visibility, 1) > 0.1);
    fnl_trace_free(NULL, &trace);
    fnl_scene_destroy(&scene);
}

/* Where the triangle is turned away, there is no light, whatever its normals say. */
static void test_light_from_behind_the_triangle(void **state) {
    UNUSED(state);
    static const float positions[12] = {-1, 0, -1, -1, 0, 1, 1, 0, 1, 1, 0, -1};
    static const float normals[12] = {0.8f, 0.6f, 0, 0.8f, 0.6f, 0, 0.8f, 0.6f, 0, 0.8f, 0.6f, 0};
    static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    fnl_scene *scene = world_create(NULL);
    fnl_material_params white = matt(1);
    fnl_mesh_params params = {.vertex_count = 4,
                              .index_count = 6,
                              .positions = positions,
                              .normals = normals,
                              .indices = indices,
                              .material = add_material(scene, &white)};
    fnl_mesh_id mesh;
    assert_int_equal(fnl_scene_add_mesh(scene, &params, &mesh), FNL_OK);
    add_instance(scene, mesh, mat4_identity());
    fnl_light_params behind = fnl_light_params_default();
    fnl_light_id light = add_point_light(scene, (vec3){5, 1, 0}, 100);
    behind.position = (vec3){5, -1, 0};
    behind.intensity = 100;
    behind.range = 1000;
    fnl_trace_params p = look_down((vec3){0, 0, 0}, 1, 1, 4);
    p.visibility = true;
    fnl_trace trace = trace_scene(scene, &p);
    assert_true(pixel_at(&trace.radiance, 1, 1)[0] > 0.1f && pixel_at(&trace.visibility, 1, 1)[1] > 0.1f);
    fnl_trace_free(NULL, &trace);
    assert_int_equal(fnl_scene_set_light(scene, light, &behind), FNL_OK);
    for (int i = 0; i < 3; i++) {
        trace = trace_scene(scene, &p);
        assert_float_equal(pixel_at(&trace.radiance, 1, 1)[0], 0, 0);
        assert_float_equal(pixel_at(&trace.visibility, 1, 1)[1], 0, 0);
        fnl_trace_free(NULL, &trace);
        white.alpha_mode = FNL_ALPHA_BLEND; /* glass is no lamp for its own other side either */
        white.base_color[3] = 0.5f;
        assert_int_equal(fnl_scene_set_material(scene, params.material, &white), FNL_OK);
        p.shadows = i == 0;
    }
    fnl_scene_destroy(&scene);
}

/* ---- what the camera sees ---- */

/* Unlit squares above one another show their colours. */
static void test_camera_sees_fronts_and_layers(void **state) {
    UNUSED(state);
    static const struct {
        float scale_x; /* negative: mirrored, which keeps the front where it was */
        float turn;
        bool double_sided, seen;
    } cases[] = {
        {1, 0, false, true}, {-1, 0, false, true}, {1, PI, false, false}, {-1, PI, false, false}, {1, PI, true, true}};
    fnl_trace_params p = look_down((vec3){0, 0, 0}, 1, 5, 4);
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        fnl_scene *scene = world_create(NULL);
        fnl_material_params m = matt(0.25f);
        m.unlit = true;
        m.double_sided = cases[i].double_sided;
        fnl_mesh_id mesh = add_square_mesh(scene, add_material(scene, &m));
        add_instance(
            scene, mesh,
            mat4_from_trs((vec3){0, 0, 0}, quat_axis_angle((vec3){1, 0, 0}, cases[i].turn), (vec3){cases[i].scale_x, 1, 1}));
        fnl_trace trace = trace_scene(scene, &p);
        if ((pixel_at(&trace.radiance, 1, 1)[0] == 0.25f) != cases[i].seen)
            fail_msg("case %u is %s", i, cases[i].seen ? "not seen" : "seen");
        fnl_trace_free(NULL, &trace);
        fnl_scene_destroy(&scene);
    }
    fnl_scene *scene = world_create(NULL);
    fnl_material_params m = matt(1);
    m.unlit = true;
    add_square(scene, &m, (vec3){1, 1, 1}, (vec3){0, 0, 0});
    m.alpha_mode = FNL_ALPHA_BLEND;
    const float layers[][2] = {
        {0.5f, 0.25f}, {0, 0.5f}, {0.75f, 0.5f}, {0.9f, 1}}; /* colour, coverage; upward: the last is above the camera */
    for (int k = 0; k < 4; k++) {
        for (int c = 0; c < 3; c++) m.base_color[c] = layers[k][0];
        m.base_color[3] = layers[k][1];
        add_square(scene, &m, (vec3){1, 1, 1}, (vec3){0, k < 3 ? 1 + (float)k : 6, 0});
    }
    fnl_trace trace = trace_scene(scene, &p);
    double wanted = 0.5 * 0.75 + 0.5 * (0.5 * 0 + 0.5 * (0.25 * 0.5 + 0.75 * 1));
    assert_float_equal(pixel_at(&trace.radiance, 1, 1)[0], wanted, 1e-6);
    fnl_trace_free(NULL, &trace);
    fnl_scene_destroy(&scene);
}

/* A mirrored instance is lit from its front, as any other. */
static void test_mirrored_instances_are_lit(void **state) {
    UNUSED(state);
    fnl_trace_params p = look_down((vec3){0, 0, 0}, 1, 5, 4);
    fnl_trace traces[2];
    for (int mirrored = 0; mirrored < 2; mirrored++) {
        fnl_scene *scene = world_create(NULL);
        fnl_material_params white = matt(1);
        add_square(scene, &white, (vec3){mirrored ? -2 : 2, 1, 2}, (vec3){0, 0, 0});
        add_point_light(scene, LIGHT, 50);
        traces[mirrored] = trace_scene(scene, &p);
        fnl_scene_destroy(&scene);
    }
    assert_true(pixel_at(&traces[1].radiance, 1, 1)[0] > 0.1f);
    for (uint32_t i = 0; i < 16; i++)
        assert_float_equal(pixel_at(&traces[0].radiance, i % 4, i / 4)[0], pixel_at(&traces[1].radiance, i % 4, i / 4)[0],
                           1e-6);
    fnl_trace_free(NULL, &traces[0]);
    fnl_trace_free(NULL, &traces[1]);
}

/* The texel leans the normal up in the picture, which is -z here: to z where the instance mirrors z. */
static void test_normal_maps_lean_with_the_texture(void **state) {
    UNUSED(state);
    static uint8_t texel[4] = {128, 230, 204, 255}; /* (0, 0.8, 0.6) */
    const double n[3] = {128 / 255.0 * 2 - 1, 230 / 255.0 * 2 - 1, 204 / 255.0 * 2 - 1};
    const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int mirrored = 0; mirrored < 4; mirrored++) {
        const float x = mirrored & 1 ? -2 : 2, z = mirrored & 2 ? -2 : 2;
        fnl_scene *scene = world_create(NULL);
        fnl_material_params bent = matt(1);
        fnl_image image = {1, 1, FNL_PIXEL_FORMAT_RGBA8, texel};
        assert_int_equal(fnl_scene_add_image(scene, &image, false, &bent.normal_image), FNL_OK);
        add_square(scene, &bent, (vec3){x, 1, z}, (vec3){0, 0, 0});
        fnl_light_params sun = fnl_light_params_default();
        fnl_light_id id;
        sun.kind = FNL_LIGHT_DIRECTIONAL;
        sun.direction = (vec3){0, -0.8f, 0.6f}; /* from -z */
        sun.intensity = (float)PI;
        assert_int_equal(fnl_scene_add_light(scene, &sun, &id), FNL_OK);
        fnl_trace_params p = look_down((vec3){0, 0, 0}, 0.5f, 5, 4);
        fnl_trace trace = trace_scene(scene, &p);
        double wanted = (0.8 * n[2] + 0.6 * n[1] * (mirrored & 2 ? -1 : 1)) / length;
        if (fabs((double)pixel_at(&trace.radiance, 1, 1)[0] - fmax(wanted, 0)) > 1e-3)
            fail_msg("mirrored by %d: %g, must be %g", mirrored, (double)pixel_at(&trace.radiance, 1, 1)[0], wanted);
        fnl_trace_free(NULL, &trace);
        fnl_scene_destroy(&scene);
    }
}

/* ---- soft shadows ---- */

/* Below the edge of a half-plane at the height h, half of a round source is seen; beyond h tan(angle) all or nothing. */
static void test_sun_casts_a_penumbra(void **state) {
    UNUSED(state);
    fnl_scene *scene = world_create(NULL);
    fnl_material_params white = matt(1);
    add_square(scene, &white, (vec3){10, 1, 10}, (vec3){0, 0, 0});
    add_square(scene, &white, (vec3){10, 1, 10}, (vec3){10, 1, 0}); /* covers x > 0 */
    fnl_light_params sun = fnl_light_params_default();
    fnl_light_id id;
    sun.kind = FNL_LIGHT_DIRECTIONAL;
    sun.direction = (vec3){0, -1, 0};
    assert_int_equal(fnl_scene_add_light(scene, &sun, &id), FNL_OK);
    fnl_trace_params p = look_down((vec3){0, 0, 0}, 2, 0.5f, 20);
    p.visibility = true;
    p.sun_angle = atanf(0.55f); /* the penumbra is 1.1 m wide */
    p.samples = 128;
    fnl_trace trace = trace_scene(scene, &p);
    /* The same where the light says so itself, or says what the trace does not heed. */
    for (int own = 0; own < 2; own++) {
        sun.source_angle = own ? p.sun_angle : 0.1f;
        assert_int_equal(fnl_scene_set_light(scene, id, &sun), FNL_OK);
        fnl_trace_params q = p;
        if (own) q.sun_angle = trace_plain().sun_angle;
        fnl_trace same = trace_scene(scene, &q);
        assert_memory_equal(same.visibility.pixels, trace.visibility.pixels, 20 * 20 * 16);
        fnl_trace_free(NULL, &same);
    }
    double before = 2;
    for (uint32_t x = 0; x < 20; x++) {
        double mean = 0, at = (x + 0.5) * 0.1 - 1;
        for (uint32_t y = 0; y < 20; y++) mean += (double)pixel_at(&trace.visibility, x, y)[0] / 20;
        double part = CLAMP(at / 0.55, -1.0, 1.0),
               wanted = (acos(part) - part * sqrt(1 - part * part)) / (double)PI; /* of a disk cut by a line */
        if (fabs(mean - wanted) > 0.03) fail_msg("at %g: %g, must be %g", at, mean, wanted);
        assert_true(mean <= before + 0.01);
        before = mean;
    }
    fnl_trace_free(NULL, &trace);
    fnl_scene_destroy(&scene);
}

/* Far from the origin rays start farther off the surface; the way to the sun stays what it is. */
static void test_sun_far_from_the_origin(void **state) {
    UNUSED(state);
    const float o = 1000;
    fnl_scene *scene = world_create(NULL);
    fnl_material_params white = matt(1);
    add_square(scene, &white, (vec3){20, 1, 20}, (vec3){o, 0, o});
    add_square(scene, &white, (vec3){10, 1, 10}, (vec3){o - 7.5f + 10, 10, o}); /* covers x > o - 7.5: its shadow begins at o */
    fnl_light_params sun = fnl_light_params_default();
    fnl_light_id id;
    sun.kind = FNL_LIGHT_DIRECTIONAL;
    sun.direction = (vec3){0.6f, -0.8f, 0};
    assert_int_equal(fnl_scene_add_light(scene, &sun, &id), FNL_OK);
    fnl_trace_params p = look_down((vec3){o, 0, o}, 0.0625f, 0.5f, 32);
    p.visibility = true;
    fnl_trace trace = trace_scene(scene, &p);
    for (uint32_t x = 0; x < 32; x++) {
        double at = ((x + 0.5) / 32 - 0.5) * 0.0625;
        if (fabs(at) > 2e-3) assert_float_equal(pixel_at(&trace.visibility, x, 16)[0], at < 0, 0);
    }
    fnl_trace_free(NULL, &trace);
    fnl_scene_destroy(&scene);
}

/* A shade over half of a tube hides the half that it covers, as seen from below its edge. */
static void test_capsule_is_hidden_in_part(void **state) {
    UNUSED(state);
    fnl_scene *scene = world_create(NULL);
    fnl_material_params white = matt(1);
    fnl_light_params tube = fnl_light_params_default();
    fnl_light_id id;
    tube.kind = FNL_LIGHT_CAPSULE;
    tube.position = (vec3){0, 2, 0};
    tube.direction = (vec3){1, 0, 0};
    tube.length = 2;
    tube.intensity = 10;
    add_square(scene, &white, (vec3){10, 1, 10}, (vec3){0, 0, 0});
    add_square(scene, &white, (vec3){10, 1, 10},
               (vec3){10.25f, 1, 0}); /* covers x > 0.25: of the tube 0.5 .. 1 from the middle below */
    assert_int_equal(fnl_scene_add_light(scene, &tube, &id), FNL_OK);
    fnl_trace_params p = look_down((vec3){0, 0, 0}, 0.01f, 0.5f, 16);
    p.visibility = true;
    p.samples = 64;
    fnl_trace trace = trace_scene(scene, &p);
    assert_float_equal(mean_of(&trace.visibility, 0), 1, 0); /* the nearest point of the tube */
    fnl_trace_free(NULL, &trace);
    for (int own = 0; own < 2; own++) { /* as the trace says, or the light itself */
        p.light_radius = own ? trace_plain().light_radius : 1e-3f;
        tube.source_radius = own ? 1e-3f : 0;
        assert_int_equal(fnl_scene_set_light(scene, id, &tube), FNL_OK);
        trace = trace_scene(scene, &p);
        assert_float_equal(mean_of(&trace.visibility, 0), 0.75, 0.02);
        fnl_trace_free(NULL, &trace);
    }
    p.light_radius = 0;
    trace = trace_scene(scene, &p);
    assert_float_equal(mean_of(&trace.visibility, 0), 1, 0);
    fnl_trace_free(NULL, &trace);
    fnl_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_known_shadows),
        cmocka_unit_test(test_light_inside_a_wall),
        cmocka_unit_test(test_light_from_behind_the_triangle),
        cmocka_unit_test(test_camera_sees_fronts_and_layers),
        cmocka_unit_test(test_mirrored_instances_are_lit),
        cmocka_unit_test(test_normal_maps_lean_with_the_texture),
        cmocka_unit_test(test_sun_casts_a_penumbra),
        cmocka_unit_test(test_sun_far_from_the_origin),
        cmocka_unit_test(test_capsule_is_hidden_in_part),
    };
    return cmocka_run_group_tests_name("trace_shadows", tests, NULL, NULL);
}
