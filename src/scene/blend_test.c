/* SPDX-License-Identifier: MIT */
/* fnl_scene_set_times: known values of a generated file. */
#include "tests/gltf_test_file.h"

#include <setjmp.h>

#include <cmocka.h>

static struct test_log lines;

/* Keys at 0 and 1 s. */
static const struct {
    float positions[9], morph[9], times[2];
    float move_a[6], move_b[6], turn_a[8], turn_b[8], weights_a[4], weights_b[2], color[8];
    unsigned char visible_a[4], visible_b[4];
} data = {{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 0, 1, 0, 0, 1, 0, 0, 1}, {0, 1},
          {0, 0, 0, 4, 0, 0}, {0, 8, 0, 0, 8, 0},
          {0, 0, 0, 1, 0, 0.70710678f, 0, 0.70710678f},    /* to 90 degrees about y */
          {0, 0, 0, -1, 0, -0.38268343f, 0, -0.92387953f}, /* to 45 degrees, from the other side */
          {0, 0, 1, 0.5f}, {0, 0.8f}, {0, 0, 0, 1, 1, 1, 1, 1}, {1, 1}, {0}};

#define AT(member) ((int)offsetof(__typeof__(data), member))

static fnl_scene *make(void) {
    static const struct {
        int offset, size, count;
        const char *type;
    } arrays[] = {{AT(positions), 36, 3, "VEC3"}, {AT(morph), 36, 3, "VEC3"},   {AT(times), 8, 2, "SCALAR"},     {AT(move_a), 24, 2, "VEC3"},
                  {AT(move_b), 24, 2, "VEC3"},    {AT(turn_a), 32, 2, "VEC4"},  {AT(turn_b), 32, 2, "VEC4"},     {AT(weights_a), 16, 4, "SCALAR"},
                  {AT(weights_b), 8, 2, "SCALAR"}, {AT(visible_a), 2, 2, "SCALAR"}, {AT(visible_b), 2, 2, "SCALAR"}, {AT(color), 32, 2, "VEC4"}};
    char json[8192], views[2048] = "", accessors[2048] = "";
    for (size_t i = 0; i < COUNT_OF(arrays); i++) {
        snprintf(views + strlen(views), sizeof views - strlen(views), "%s{\"buffer\": 0, \"byteOffset\": %d, \"byteLength\": %d}", i ? ", " : "", arrays[i].offset, arrays[i].size);
        snprintf(accessors + strlen(accessors), sizeof accessors - strlen(accessors), "%s{\"bufferView\": %zu, \"componentType\": %d, \"count\": %d, \"type\": \"%s\"%s}",
                 i ? ", " : "", i, arrays[i].size == 2 ? 5121 : 5126, arrays[i].count, arrays[i].type, i == 0 ? ", \"min\": [0,0,0], \"max\": [1,1,0]" : i == 2 ? ", \"min\": [0], \"max\": [1]" : "");
    }
    snprintf(json, sizeof json,
             "{\"asset\": {\"version\": \"2.0\"}, \"extensionsUsed\": [\"KHR_animation_pointer\", \"KHR_node_visibility\"], \"scenes\": [{\"nodes\": [0, 1]}],\n"
             "\"nodes\": [{\"mesh\": 0}, {\"name\": \"only\", \"extensions\": {\"KHR_node_visibility\": {}}}], \"buffers\": [{\"byteLength\": %zu}], \"bufferViews\": [%s], \"accessors\": [%s],\n"
             "\"materials\": [{\"pbrMetallicRoughness\": {}}],\n"
             "\"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0}, \"material\": 0, \"targets\": [{\"POSITION\": 1}, {\"POSITION\": 1}]}]}],\n"
             "\"animations\": [{\"samplers\": [{\"input\": 2, \"output\": 3}, {\"input\": 2, \"output\": 5}, {\"input\": 2, \"output\": 7}, {\"input\": 2, \"output\": 9, "
             "\"interpolation\": \"STEP\"}, {\"input\": 2, \"output\": 11}], \"channels\": [\n"
             " {\"sampler\": 0, \"target\": {\"node\": 0, \"path\": \"translation\"}}, {\"sampler\": 1, \"target\": {\"node\": 0, \"path\": \"rotation\"}},\n"
             " {\"sampler\": 2, \"target\": {\"node\": 0, \"path\": \"weights\"}}, {\"sampler\": 0, \"target\": {\"node\": 1, \"path\": \"translation\"}},\n"
             " {\"sampler\": 3, \"target\": {\"path\": \"pointer\", \"extensions\": {\"KHR_animation_pointer\": {\"pointer\": \"/nodes/1/extensions/KHR_node_visibility/visible\"}}}},\n"
             " {\"sampler\": 4, \"target\": {\"path\": \"pointer\", \"extensions\": {\"KHR_animation_pointer\": {\"pointer\": \"/materials/0/pbrMetallicRoughness/baseColorFactor\"}}}}]},\n"
             "{\"samplers\": [{\"input\": 2, \"output\": 4}, {\"input\": 2, \"output\": 6}, {\"input\": 2, \"output\": 8}, {\"input\": 2, \"output\": 10, \"interpolation\": \"STEP\"}],\n"
             "\"channels\": [{\"sampler\": 0, \"target\": {\"node\": 0, \"path\": \"translation\"}}, {\"sampler\": 1, \"target\": {\"node\": 0, \"path\": \"rotation\"}},\n"
             " {\"sampler\": 2, \"target\": {\"path\": \"pointer\", \"extensions\": {\"KHR_animation_pointer\": {\"pointer\": \"/nodes/0/weights/1\"}}}},\n"
             " {\"sampler\": 3, \"target\": {\"path\": \"pointer\", \"extensions\": {\"KHR_animation_pointer\": {\"pointer\": \"/nodes/1/extensions/KHR_node_visibility/visible\"}}}}]}]}",
             sizeof data, views, accessors);
    fnl_scene *scene = NULL;
    if (test_load(&lines, json, &data, sizeof data, &scene) != FNL_OK) fail_msg("%s", lines.text);
    return scene;
}

static void near(float a, float b) {
    if (!(fabsf(a - b) < 1e-6f)) fail_msg("%g is not %g", (double)a, (double)b);
}

static void pose(fnl_scene *scene, float weight_a, float weight_b) {
    const fnl_animation_time times[] = {{0, 1, weight_a}, {1, 1, weight_b}};
    assert_int_equal(fnl_scene_set_times(scene, times, 2), FNL_OK);
}

static void test_means_by_weights(void **state) {
    UNUSED(state);
    fnl_scene *scene = make();
    const struct scene_node *node = &scene->nodes.data[0], *only = &scene->nodes.data[1];
    const uint64_t before = scene->transform_version;
    pose(scene, 0.75f, 2.25f); /* a quarter, three quarters */
    assert_true(scene->transform_version > before);
    near((float)node->translation[0], 1);
    near((float)node->translation[1], 6);
    near(node->world.m[12], 1);
    /* The first weight is that of the one that sets it. */
    near(node->morph_weights[0], 1);
    near(node->morph_weights[1], 0.25f * 0.5f + 0.75f * 0.8f);
    near(only->translation[0], 4);
    assert_true(only->translation[0] == 4 && node->morph_weights[0] == 1); /* without rounding */
    assert_true(only->hidden);                                             /* the heavier one hides it */
    near(scene->materials.data[0].base_color.y, 1);
    /* Of unit quaternions about one axis, on one side. */
    const double *r = node->rotation;
    quat q = {(float)r[0], (float)r[1], (float)r[2], (float)r[3]};
    const float y = 0.25f * 0.70710678f + 0.75f * 0.38268343f, w = 0.25f * 0.70710678f + 0.75f * 0.92387953f, length = sqrtf(y * y + w * w);
    if (q.w < 0) q = (quat){-q.x, -q.y, -q.z, -q.w};
    near(q.y, y / length);
    near(q.w, w / length);
    near(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w, 1);
    pose(scene, 2, 1);
    assert_false(only->hidden);
    near((float)node->translation[0], 8 / 3.0f);
    fnl_scene_destroy(&scene);
}

static void expect_same(const fnl_scene *a, const fnl_scene *b) {
    for (uint32_t i = 0; i < a->nodes.count; i++) {
        assert_memory_equal(&a->nodes.data[i].world, &b->nodes.data[i].world, sizeof(mat4));
        assert_true(a->nodes.data[i].hidden == b->nodes.data[i].hidden);
    }
    assert_memory_equal(a->nodes.data[0].morph_weights, b->nodes.data[0].morph_weights, 2 * sizeof(float));
    assert_memory_equal(&a->materials.data[0].base_color, &b->materials.data[0].base_color, sizeof(vec4));
}

static void test_one_animation_is_set_time_to_the_bit(void **state) {
    UNUSED(state);
    fnl_scene *blended = make(), *plain = make();
    for (uint32_t i = 0; i <= 10; i++) {
        const double seconds = i * 0.113;
        const fnl_animation_time lone = {0, seconds, 0.3f}, with_none[] = {{1, seconds, 0}, {0, seconds, 7}}, twice[] = {{0, seconds, 1}, {0, seconds, 1}};
        assert_int_equal(fnl_scene_set_time(plain, 0, seconds), FNL_OK);
        assert_int_equal(fnl_scene_set_times(blended, &lone, 1), FNL_OK);
        expect_same(blended, plain);
        assert_int_equal(fnl_scene_set_times(blended, with_none, 2), FNL_OK);
        expect_same(blended, plain);
        assert_int_equal(fnl_scene_set_times(blended, twice, 2), FNL_OK);
        for (int k = 0; k < 16; k++) near(blended->nodes.data[0].world.m[k], plain->nodes.data[0].world.m[k]);
    }
    /* What one alone sets is not rounded by the weights. */
    assert_int_equal(fnl_scene_set_time(plain, 0, 0.4975), FNL_OK);
    for (int i = 1; i < 50; i++) {
        const fnl_animation_time times[] = {{0, 0.4975, (float)i * 0.037f}, {1, 0.9, 0.7f}};
        assert_int_equal(fnl_scene_set_times(blended, times, 2), FNL_OK);
        assert_true(blended->nodes.data[1].translation[0] == plain->nodes.data[1].translation[0]);
        assert_true(blended->nodes.data[0].morph_weights[0] == plain->nodes.data[0].morph_weights[0]);
    }
    fnl_scene_destroy(&blended);
    fnl_scene_destroy(&plain);
}

static void test_errors_change_nothing(void **state) {
    UNUSED(state);
    fnl_scene *scene = make(), *other = make();
    fnl_scene_set_time(scene, 0, 0.5);
    fnl_scene_set_time(other, 0, 0.5);
    const fnl_animation_time bad[] = {{1, 0.2, 1}, {2, 0.2, 1}};
    assert_int_equal(fnl_scene_set_times(scene, bad, 2), FNL_ERROR_INVALID);
    assert_non_null(strstr(lines.text, "animation"));
    expect_same(scene, other);
    fnl_scene_destroy(&scene);
    fnl_scene_destroy(&other);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_means_by_weights),
        cmocka_unit_test(test_one_animation_is_set_time_to_the_bit),
        cmocka_unit_test(test_errors_change_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
