/* SPDX-License-Identifier: MIT */
/* How far lights without a range reach: everywhere, or to a threshold that follows from the scene as it is and from nothing else. */
#include "scene/scene.h"
#include "tests/gltf_test_file.h"

#include <setjmp.h>

#include <cmocka.h>

static struct test_log lines;

struct world {
    fnl_scene *scene;
    fnl_instance_id triangle;
    fnl_light_id lights[FNL_UNLIMITED_LIGHTS_MAX + 100];
    uint32_t count;
};

/* A triangle that spans 2 x 2 x 0 units of `scale` metres round the origin. */
static struct world world_of(float scale) {
    struct world w = {0};
    fnl_host host = test_host(&lines);
    assert_int_equal(fnl_scene_create(&host, &w.scene), FNL_OK);
    const fnl_vec3 positions[3] = {{-scale, -scale, 0}, {scale, -scale, 0}, {0, scale, 0}};
    fnl_mesh_params params = {0};
    params.positions = &positions[0].x;
    params.vertex_count = 3;
    fnl_mesh_id mesh;
    const fnl_mat4 identity = mat4_identity();
    assert_int_equal(fnl_scene_add_mesh(w.scene, &params, &mesh), FNL_OK);
    assert_int_equal(fnl_scene_add_instance(w.scene, mesh, &identity, &w.triangle), FNL_OK);
    return w;
}

static void add_light(struct world *w, float x, float candela) {
    fnl_light_params light = fnl_light_params_default();
    light.position = vec3_make(x, 0, 1);
    light.intensity = candela;
    assert_int_equal(fnl_scene_add_light(w->scene, &light, &w->lights[w->count++]), FNL_OK);
}

static float reach_of(struct world *w, uint32_t light) {
    scene_follow_reach(w->scene);
    return light_effective_range(&w->scene->lights.data[w->lights[light].index]);
}

static double threshold_of(const struct world *w) {
    fnl_scene_info info;
    assert_int_equal(fnl_scene_query_info(w->scene, &info), FNL_OK);
    return info.light_threshold;
}

/* `count` lights of 1, 2, 3, 1, 2, 3 … times `candela`, along a line of `scale` metres; `backwards`: the last first. */
static struct world crowd(uint32_t count, float scale, float candela, bool backwards) {
    struct world w = world_of(scale);
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t k = backwards ? count - 1 - i : i;
        add_light(&w, scale * (float)k / 256, candela * (float)(1 + k % 3));
    }
    return w;
}

static void test_a_few_lights_have_no_limit(void **state) {
    UNUSED(state);
    struct world w = crowd(FNL_UNLIMITED_LIGHTS_MAX, 1, 1e-6f, false); /* however dim */
    const double farthest = hypot(1, hypot(1, 1));
    assert_true(threshold_of(&w) == 0);
    assert_true((double)reach_of(&w, 0) >= 64 * farthest && (double)reach_of(&w, 0) < 128 * farthest);
    fnl_light_params light = fnl_light_params_default();
    light.position = vec3_make(1e5f, 0, 0); /* far from everything */
    assert_int_equal(fnl_scene_set_light(w.scene, w.lights[0], &light), FNL_OK);
    assert_true(reach_of(&w, 0) >= 64e5f && reach_of(&w, 1) < 1000);
    light.range = 3;
    assert_int_equal(fnl_scene_set_light(w.scene, w.lights[0], &light), FNL_OK);
    assert_true(reach_of(&w, 0) == 3);
    assert_int_equal(w.scene->unlimited.count, FNL_UNLIMITED_LIGHTS_MAX - 1);
    fnl_scene_destroy(&w.scene);
}

static void test_an_empty_scene_has_them_too(void **state) {
    UNUSED(state);
    struct world w = {0};
    fnl_host host = test_host(&lines);
    assert_int_equal(fnl_scene_create(&host, &w.scene), FNL_OK);
    scene_follow_reach(w.scene);
    for (uint32_t i = 0; i <= FNL_UNLIMITED_LIGHTS_MAX; i++) {
        add_light(&w, 0, 0); /* without light, all at one place */
        assert_true(isfinite(reach_of(&w, i)));
    }
    fnl_scene_destroy(&w.scene);
}

static void test_reaches_follow_the_scene(void **state) {
    UNUSED(state);
    struct world w = crowd(1, 1, 1, false);
    const float before = reach_of(&w, 0);
    const uint64_t seen = w.scene->light_version;
    fnl_mat4 place = mat4_from_trs(vec3_make(0.01f, 0, 0), quat_identity(), vec3_make(1, 1, 1));
    assert_int_equal(fnl_scene_set_instance_transform(w.scene, w.triangle, &place), FNL_OK);
    assert_true(reach_of(&w, 0) == before && w.scene->light_version == seen); /* an edit rarely changes a light */
    place.m[12] = 1000;
    assert_int_equal(fnl_scene_set_instance_transform(w.scene, w.triangle, &place), FNL_OK);
    assert_true(reach_of(&w, 0) >= 64000 && w.scene->light_version > seen);
    fnl_instance_info info;
    assert_int_equal(fnl_scene_query_instance(w.scene, 0, &info), FNL_OK);
    place.m[12] = -1e6f;
    fnl_instance_id other;
    assert_int_equal(fnl_scene_add_instance(w.scene, info.mesh, &place, &other), FNL_OK);
    assert_true(reach_of(&w, 0) >= 64e6f);
    fnl_scene_destroy(&w.scene);
}

static void test_many_lights_share_a_threshold(void **state) {
    UNUSED(state);
    enum { COUNT = FNL_UNLIMITED_LIGHTS_MAX + 1 };
    struct world w = crowd(COUNT, 1, 1, false);
    const double threshold = threshold_of(&w);
    int exponent;
    assert_true(frexp(threshold, &exponent) == 0.5); /* a power of two */
    /* Of the mean that this header promises; the box round triangle and lights is 2 x 2 x 1 metres. */
    const double mean = exp((log(1) * 22 + log(2) * 22 + log(3) * 21) / COUNT) * 3 * COUNT / (0.25 * (4 + 4 + 1));
    assert_true(threshold <= mean / 1024 && threshold > mean / 2048);
    for (uint32_t i = 0; i < COUNT; i++) {
        const double candela = 1 + i % 3;
        assert_true(fabs(candela / ((double)reach_of(&w, i) * (double)reach_of(&w, i)) / threshold - 1) < 1e-5);
    }
    assert_int_equal(fnl_scene_remove_light(w.scene, w.lights[7]), FNL_OK);
    assert_true(threshold_of(&w) == 0 && reach_of(&w, 0) >= 64);
    add_light(&w, 0, 1);
    assert_true(threshold_of(&w) > 0 && reach_of(&w, 0) < 64);
    fnl_scene_destroy(&w.scene);
}

static void test_the_threshold_scales_and_forgets(void **state) {
    UNUSED(state);
    enum { COUNT = FNL_UNLIMITED_LIGHTS_MAX + 36 };
    struct world usual = crowd(COUNT, 1, 1, false), backwards = crowd(COUNT, 1, 1, true), dim = crowd(COUNT, 1, 0x1p-20f, false);
    struct world bright = crowd(COUNT - 1, 1, 1, false);
    add_light(&bright, 0, 1e6f);
    assert_true(threshold_of(&usual) == threshold_of(&backwards));
    assert_true(threshold_of(&dim) == threshold_of(&usual) * 0x1p-20);
    assert_true(threshold_of(&bright) <= 2 * threshold_of(&usual)); /* one lamp leaves the others' reach nearly as it was */
    for (uint32_t i = 0; i < COUNT; i++) assert_true(reach_of(&usual, i) == reach_of(&dim, i));
    /* What a scene was before does not matter. */
    const double threshold = threshold_of(&usual);
    fnl_mat4 place = mat4_from_trs(vec3_make(1000, 0, 0), quat_identity(), vec3_make(1, 1, 1));
    assert_int_equal(fnl_scene_set_instance_transform(usual.scene, usual.triangle, &place), FNL_OK);
    const float far = reach_of(&usual, 0);
    assert_true(threshold_of(&usual) < threshold / 1000 && far > 10 * reach_of(&dim, 0));
    place.m[12] = 0;
    assert_int_equal(fnl_scene_set_instance_transform(usual.scene, usual.triangle, &place), FNL_OK);
    for (uint32_t i = 0; i < COUNT; i++) assert_true(reach_of(&usual, i) == reach_of(&dim, i));
    /* Nor what it was while its lights were unlimited. */
    struct world few = crowd(1, 1, 1, false);
    assert_true(reach_of(&few, 0) > 0);
    for (int k = 1; k >= 0; k--) {
        place.m[12] = 1000 * (float)k;
        assert_int_equal(fnl_scene_set_instance_transform(few.scene, few.triangle, &place), FNL_OK);
        assert_true(reach_of(&few, 0) > 0);
    }
    for (uint32_t i = 1; i < COUNT; i++) add_light(&few, (float)i / 256, (float)(1 + i % 3));
    for (uint32_t i = 0; i < COUNT; i++) assert_true(reach_of(&few, i) == reach_of(&dim, i));
    fnl_scene_destroy(&few.scene);
    fnl_scene_destroy(&usual.scene);
    fnl_scene_destroy(&backwards.scene);
    fnl_scene_destroy(&dim.scene);
    fnl_scene_destroy(&bright.scene);
}

static void test_a_cutoff_of_ones_own(void **state) {
    UNUSED(state);
    struct world w = crowd(3, 1, 20, false);
    const float unlimited = reach_of(&w, 0);
    fnl_light_params light = fnl_light_params_default();
    light.intensity = 20;
    assert_int_equal(fnl_scene_set_light_cutoff(w.scene, 0.3f, 0.05f), FNL_OK);
    assert_true(reach_of(&w, 0) == fnl_light_range(&light, 0.3f, 0.05f) && threshold_of(&w) == (double)0.05f);
    assert_int_equal(fnl_scene_set_light_cutoff(w.scene, 1, 0.2f), FNL_OK);
    assert_true(reach_of(&w, 0) == fnl_light_range(&light, 1, 0.2f));
    assert_int_equal(fnl_scene_set_light_cutoff(w.scene, 1, 0), FNL_OK);
    assert_true(reach_of(&w, 0) == unlimited && threshold_of(&w) == 0);
    fnl_scene_destroy(&w.scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_few_lights_have_no_limit), cmocka_unit_test(test_an_empty_scene_has_them_too),     cmocka_unit_test(test_reaches_follow_the_scene),
        cmocka_unit_test(test_many_lights_share_a_threshold), cmocka_unit_test(test_the_threshold_scales_and_forgets), cmocka_unit_test(test_a_cutoff_of_ones_own),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
