/* SPDX-License-Identifier: MIT */
/**
 * Every light list gives the same picture, with one sample a pixel: bit-equal radiance for one shading order, and 2/255 after tone mapping
 * between the orders. lists_samples_test.c does this with several samples, lists_limits_test.c goes to the limits of lists.
 */
#include "tests/list_pairs.h"

/* ---- EQ: every scene, shading order and list ---- */

struct scene_case {
    const char *source;
    uint32_t scattered;
    float ev;
};

static void test_scene(void **state) {
    const struct scene_case *c = *state;
    struct stage stage = stage_open(c->source, c->scattered);
    fnl_frame frame = stage.frame;
    frame.ev = c->ev;
    frame.width = 81;
    frame.height = 47;
    pairs_check_orders(&stage, frame);
    stage_close(&stage);
}

/* A few pairs at a size that divides by nothing. */
static void test_odd_size(void **state) {
    UNUSED(state);
    static const struct {
        fnl_shading shading;
        fnl_light_lists lists;
    } pairs[] = {{FNL_SHADING_DEFERRED, FNL_LISTS_TILED},
                 {FNL_SHADING_DEFERRED, FNL_LISTS_CLUSTERED},
                 {FNL_SHADING_FORWARD_PREPASS, FNL_LISTS_TILED},
                 {FNL_SHADING_FORWARD_PREPASS, FNL_LISTS_CLUSTERED_CPU}};
    struct stage stage = stage_open("builtin:spheres?lights=24", 0);
    fnl_frame frame = stage.frame;
    frame.width = 161;
    frame.height = 91;
    struct shot all = {0};
    for (uint32_t i = 0; i < COUNT_OF(pairs); i++) {
        frame.shading = pairs[i].shading;
        if (i % 2 == 0) {
            shot_free(&all);
            frame.lists = FNL_LISTS_ALL;
            all = stage_shoot(&stage, &frame);
        }
        frame.lists = pairs[i].lists;
        struct shot shot = stage_shoot(&stage, &frame);
        if (count_differing(&all.radiance, &shot.radiance)) fail_msg("%s differs from all", pair_name(&frame));
        shot_free(&shot);
    }
    shot_free(&all);
    stage_close(&stage);
}

/* ---- EQ: cameras ---- */

static fnl_frame small_frame(const struct stage *stage) {
    fnl_frame frame = stage->frame;
    frame.width = 65;
    frame.height = 37;
    return frame;
}

static void test_cameras(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:spheres?lights=100", 0);
    fnl_camera scene_camera = stage.frame.camera;
    for (uint32_t kind = 0; kind < 5; kind++) {
        fnl_frame frame = small_frame(&stage);
        fnl_camera *camera = &frame.camera;
        if (kind == 0) { /* inside of many lights, one of them a hair away */
            fnl_light_params light;
            assert_int_equal(fnl_scene_query_light(stage.scene, 5, &light), FNL_OK);
            camera->position = light.position;
            camera->position.x += 1e-3f;
        } else if (kind == 1) {
            camera->orthographic = true;
            camera->vertical_extent = 8;
            camera->far_distance = 40;
        } else if (kind == 2) {
            camera->shift = (fnl_vec2){0.7f, -0.4f};
        } else if (kind == 3) { /* upside down, very wide */
            camera->up = (fnl_vec3){0.2f, -1, 0};
            camera->vertical_fov = 2.6f;
        } else { /* looks away: nothing but sky */
            camera->target = (fnl_vec3){scene_camera.position.x, scene_camera.position.y + 10, scene_camera.position.z + 10};
        }
        pairs_check_orders(&stage, frame);
    }
    stage_close(&stage);
}

/* Lights of all shapes, a third of them cut by hulls, seen from outside and from inside of one of each shape. */
static void test_light_shapes(void **state) {
    UNUSED(state);
    struct stage stage = stage_open("builtin:spheres?lights=0", 0);
    fnl_scatter_params scatter = fnl_scatter_params_default();
    scatter.count = 60;
    for (int k = FNL_LIGHT_POINT; k < FNL_LIGHT_RECTANGLE; k++) scatter.shares[k] = 1; /* rectangles have a test of their own: their shaders take long to make */
    assert_int_equal(fnl_scene_scatter_light_shapes(stage.scene, &scatter), FNL_OK);
    struct random_state random = {6};
    for (uint32_t i = 0; i < scatter.count; i += 3) {
        fnl_light_id id = {i, stage.scene->lights.data[i].generation};
        const fnl_light_params *light = &stage.scene->lights.data[i].params;
        vec3 corners[20];
        for (uint32_t k = 0; k < COUNT_OF(corners); k++)
            corners[k] = vec3_add(light->position, vec3_make(random_range(&random, -2, 2), random_range(&random, -2, 2),
                                                             random_range(&random, -2, 2)));
        assert_int_equal(fnl_scene_set_light_hull(stage.scene, id, corners, COUNT_OF(corners)), FNL_OK);
    }
    pairs_check_orders(&stage, small_frame(&stage));
    for (uint32_t i = 1; i <= 5; i++) { /* without hulls: 1, 2, 4, 5, 7 */
        const fnl_light_params *light = &stage.scene->lights.data[i + (i > 2) + (i > 4)].params;
        fnl_frame frame = stage.frame;
        frame.width = 75;
        frame.height = 53;
        frame.shading = i & 1 ? FNL_SHADING_DEFERRED : FNL_SHADING_FORWARD_PREPASS;
        frame.camera.position =
            vec3_add_scaled(light->position, light->direction, light->kind == FNL_LIGHT_BOX ? 0 : 0.2f * light->range);
        struct shot all = pairs_check_lists(&stage, frame, 4, i);
        shot_free(&all);
    }
    stage_close(&stage);
}

/* A mirrored instance among lights. */
static void test_mirrored_instance(void **state) {
    UNUSED(state);
    static const float positions[] = {-3, 0, 0, 3, 0, 0, 3, 4, 0, -3, 4, 0};
    static const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    struct stage stage = stage_open("builtin:spheres?lights=60", 0);
    fnl_mesh_params params = {.vertex_count = 4, .index_count = 6, .positions = positions, .indices = indices};
    fnl_mesh_id mesh;
    fnl_instance_id instance;
    fnl_mat4 mirror = {{-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.5f, 0, 1.2f, 1}};
    assert_int_equal(fnl_scene_add_mesh(stage.scene, &params, &mesh), FNL_OK);
    assert_int_equal(fnl_scene_add_instance(stage.scene, mesh, &mirror, &instance), FNL_OK);
    pairs_check_orders(&stage, small_frame(&stage));
    stage_close(&stage);
}

/* After the tests above: between them they have seen every pair that can be compared. */
static void test_every_pair_was_tried(void **state) {
    UNUSED(state);
    pairs_check_tried(1, 1);
}

#define SCENE(name, source, scattered, ev)                                                                                  \
    {                                                                                                                       \
        "EQ of all orders and lists, ES-41 ES-42 ES-58: " name, test_scene, NULL, harness_check,                            \
            &(struct scene_case) {                                                                                          \
            source, scattered, ev                                                                                           \
        }                                                                                                                   \
    }

int main(void) {
    const struct CMUnitTest tests[] = {
        SCENE("hall", "builtin:hall?lights=256", 0, 3),
        SCENE("interior", "builtin:interior", 0, 5),
        SCENE("city", "builtin:city?blocks=1&lights=512", 0, 3),
        SCENE("spheres", "builtin:spheres", 0, 5),
        SCENE("pole", "builtin:pole", 0, 5),
        SCENE("lamps", "builtin:lamps", 0, 5),
        SCENE("grass", "builtin:grass", 0, 5),
        SCENE("onetile", "builtin:onetile", 0, 5),
        SCENE("nearplane", "builtin:nearplane", 0, 5),
        SCENE("sky", "builtin:sky", 0, 5),
        SCENE("glass", "builtin:glass", 0, 5),
        SCENE("FlightHelmet", "FlightHelmet/FlightHelmet.gltf", 500, 2),
        cmocka_unit_test_teardown(test_odd_size, harness_check),
        cmocka_unit_test_teardown(test_cameras, harness_check),
        {"ES-1: EQ of lights of all shapes and hulls, seen from within", test_light_shapes, NULL, harness_check, NULL},
        cmocka_unit_test_teardown(test_mirrored_instance, harness_check),
        cmocka_unit_test_teardown(test_every_pair_was_tried, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
