/* SPDX-License-Identifier: MIT */
/** What the tests of motion vectors and temporal antialiasing share: a fence with fine edges, and a square with a morph target. */
#ifndef FNL_TESTS_TEMPORAL_CASES_H
#define FNL_TESTS_TEMPORAL_CASES_H

#include "tests/render_test.h"

enum { WIDTH = 97, HEIGHT = 65 };

/** Those of temporal_history_test.c, which use the device of temporal_test.c. */
extern const struct CMUnitTest history_tests[];
extern const size_t history_test_count;

/* Bright and dark bars, spheres, a blended pane; in front of a background. */
static inline fnl_scene *fence(void) {
    fnl_scene *scene = test_scene();
    for (int i = 0; i < 12; i++) {
        struct scene_material bar = test_unlit(i % 3 == 0 ? 8.0f : 0.7f, 0.5f, i % 2 ? 0.1f : 0.9f);
        uint32_t mesh = test_quad_mesh(scene, scene_add_material(scene, &bar));
        mat4 m = mat4_from_trs((vec3){-3 + 0.5f * (float)i, 0, 0.1f * (float)i},
                               quat_axis_angle((vec3){0, 0, 1}, 0.05f + 0.02f * (float)i), (vec3){0.07f, 2, 1});
        scene_add_node(scene, "", SCENE_NONE, &m, mesh);
    }
    struct scene_material white = scene_material_default(), glass = test_unlit(0.2f, 0.7f, 0.4f);
    white.metallic = 0;
    test_place(scene, test_sphere_mesh(scene, scene_add_material(scene, &white), 12), (vec3){0, -0.8f, 1.5f},
               (vec3){0.7f, 0.7f, 0.7f});
    glass.alpha_mode = FNL_ALPHA_BLEND;
    glass.base_color.w = 0.5f;
    test_place(scene, test_quad_mesh(scene, scene_add_material(scene, &glass)), (vec3){1.2f, 0.3f, 2},
               (vec3){0.5f, 0.5f, 1});
    fnl_light_params light = test_point((vec3){2, 3, 4}, 40, 20);
    fnl_light_id id;
    assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
    assert_int_equal(fnl_scene_set_background(scene, (vec3){0.02f, 0.03f, 0.08f}), FNL_OK);
    return scene;
}

static inline fnl_frame fence_frame(uint32_t outputs) {
    fnl_frame frame = test_frame(outputs);
    frame.width = WIDTH;
    frame.height = HEIGHT;
    frame.camera = fnl_camera_default();
    frame.camera.position = (vec3){0.4f, 0.6f, 6};
    frame.camera.target = (vec3){0, 0, 0};
    frame.tonemap = FNL_TONEMAP_KHRONOS_NEUTRAL;
    frame.exposure = FNL_EXPOSURE_EV;
    frame.ev = -0.5f;
    return frame;
}

/* A square whose one morph target moves it right and up. */
static inline uint32_t morphed_square(fnl_scene *scene) {
    static const vec3 positions[4] = {{-0.2f, -0.2f, 0}, {0.2f, -0.2f, 0}, {0.2f, 0.2f, 0}, {-0.2f, 0.2f, 0}},
                      moves[4] = {{0.25f, 0.125f, 0}, {0.25f, 0.125f, 0}, {0.25f, 0.125f, 0}, {0.25f, 0.125f, 0}};
    static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    static const struct scene_morph_target target = {moves, NULL, NULL};
    struct scene_material white = test_unlit(1, 1, 1);
    struct scene_primitive p = {.material = scene_add_material(scene, &white),
                                .vertex_count = 4,
                                .index_count = 6,
                                .indices = indices,
                                .positions = positions,
                                .morph_targets = &target,
                                .morph_target_count = 1};
    assert_int_equal(mesh_complete(&scene->arena, &p), FNL_OK);
    return scene_add_mesh(scene, "", &p, 1);
}

static inline fnl_instance_id id_of(const fnl_scene *scene, uint32_t node) {
    return (fnl_instance_id){node, scene->nodes.data[node].generation};
}

static inline void set_weight(fnl_scene *scene, uint32_t node, float weight) {
    const fnl_pose pose = {.morph_weights = &weight, .morph_weight_count = 1};
    assert_int_equal(fnl_scene_set_pose(scene, id_of(scene, node), &pose), FNL_OK);
}

#endif
