/* SPDX-License-Identifier: MIT */
/* When frames cull occluded surfaces by themselves. */
#include "tests/render_harness.h"
#include "tests/render_test.h"

enum { RINGS = 162, SPHERES = 10, PARTS = 256 }; /* a sphere has 104 976 triangles */

/* Renders with auto and says whether that was on. Then the picture is the same to the bit, and without it nothing is hidden. */
static bool culls(struct stage *s) {
    s->frame.occlusion = FNL_OCCLUSION_AUTO;
    s->frame.count_lights = true; /* counts triangles as well */
    struct shot shot = stage_shoot(s, &s->frame);
    bool on = shot.stats.occlusion;
    assert_int_equal(shot.stats.items_occluded > 0, on);
    if (on && s->frame.view_count == 0) {
        s->frame.occlusion = FNL_OCCLUSION_OFF;
        struct shot plain = stage_shoot(s, &s->frame);
        assert_false(plain.stats.occlusion);
        assert_int_equal(plain.stats.items_occluded, 0);
        assert_int_equal(count_differing(&shot.radiance, &plain.radiance), 0);
        print_message("%llu of %llu triangles drawn\n", (unsigned long long)shot.stats.triangles_visible,
                      (unsigned long long)plain.stats.triangles_visible);
        assert_true(shot.stats.triangles_visible < plain.stats.triangles_visible / 2);
        shot_free(&plain);
    }
    shot_free(&shot);
    s->frame.occlusion = FNL_OCCLUSION_AUTO;
    return on;
}

/* A million triangles behind a wall, then as many in 256 parts. */
static void test_large_scenes_of_many_parts_cull_occluded_surfaces(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_scene();
    uint32_t sphere = test_sphere_mesh(scene, SCENE_NONE, RINGS), quad = test_quad_mesh(scene, SCENE_NONE), last = SCENE_NONE;
    test_place(scene, quad, (vec3){0, 0, 2}, (vec3){20, 20, 1});
    for (int i = 0; i < SPHERES; i++) last = test_place(scene, sphere, (vec3){(float)i - 4.5f, 0, -2}, (vec3){1, 1, 1});
    scene_update_transforms(scene);
    struct stage s = stage_open_scene(scene);
    s.frame.width = 67;
    s.frame.height = 35;
    s.frame.outputs = FNL_OUTPUT_RADIANCE;
    s.frame.camera = fnl_camera_default();
    s.frame.camera.position.z = 8;
    assert_int_equal(fnl_frame_default().occlusion, FNL_OCCLUSION_AUTO);
    assert_false(culls(&s)); /* in 11 parts */
    for (int i = SPHERES + 1; i < PARTS + 1; i++) test_place(scene, quad, (vec3){0.01f * (float)i, 0, -4}, (vec3){1, 1, 1});
    scene_update_transforms(scene);
    scene_structure_changed(scene);
    assert_true(culls(&s));
    /* Where it would show, or rule something out. */
    s.frame.debug = FNL_DEBUG_OVERDRAW;
    assert_false(culls(&s));
    s.frame.debug = FNL_DEBUG_NONE;
    const fnl_camera cameras[] = {s.frame.camera, s.frame.camera};
    s.frame.views = cameras;
    s.frame.view_count = 2;
    assert_false(culls(&s));
    s.frame.stereo.eyes = 2;
    assert_true(culls(&s));
    s.frame.stereo.mono_distance = 10;
    assert_false(culls(&s));
    s.frame.stereo.mono_distance = 0;
    s.frame.stereo.eyes = 0;
    s.frame.views = NULL;
    s.frame.view_count = 0;
    s.frame.shading = FNL_SHADING_LOW_RES; /* which looks at other samples */
    assert_false(culls(&s));
    s.frame.shading = FNL_SHADING_DEFERRED;
    assert_true(culls(&s));
    /* Less than a million triangles. */
    assert_int_equal(scene_remove_node(scene, last), FNL_OK);
    assert_false(culls(&s));
    stage_close(&s);
}

/* The city takes less time with it, the hall more (docs/techniques/culling.md): a frame that asks for nothing has what is faster. */
static void test_the_city_culls_and_the_hall_does_not(void **state) {
    UNUSED(state);
    static const struct {
        const char *name;
        bool culls;
    } scenes[] = {{"builtin:city", true}, {"builtin:hall", false}};
    for (uint32_t i = 0; i < COUNT_OF(scenes); i++) {
        struct stage s = stage_open(scenes[i].name, 16);
        s.frame.width = 67;
        s.frame.height = 35;
        s.frame.outputs = FNL_OUTPUT_RADIANCE;
        s.frame.culling = fnl_frame_default().culling;
        assert_int_equal(culls(&s), scenes[i].culls);
        stage_close(&s);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_large_scenes_of_many_parts_cull_occluded_surfaces, harness_check),
        cmocka_unit_test_teardown(test_the_city_culls_and_the_hall_does_not, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
