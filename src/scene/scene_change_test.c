/* SPDX-License-Identifier: MIT */
/* Calls that change much at once. What they refuse changes nothing. */
#include "tests/gltf_test_file.h"
#include "tests/test_memory.h"

#include <float.h>
#include <setjmp.h>
#include <time.h>

#include <cmocka.h>

static struct {
    struct test_memory memory;
    struct test_log log;
} host_state;
#define lines host_state.log

static void log_line(void *user, fnl_log_level level, const char *text) {
    UNUSED(user);
    test_log_line(&lines, level, text);
}

static fnl_scene *make_scene(void) {
    fnl_scene *scene = NULL;
    fnl_host host = test_host(&lines);
    host.user = &host_state.memory;
    host.log = log_line;
    host.reallocate = test_memory_reallocate;
    host_state.memory.live_bytes = 0; /* what a test that failed left */
    assert_int_equal(fnl_scene_create(&host, &scene), FNL_OK);
    return scene;
}

static void expect_misuse(fnl_result result, const char *words) {
    assert_int_equal(result, FNL_ERROR_INVALID);
    if (!strstr(lines.text, words)) fail_msg("no '%s' in:\n%s", words, lines.text);
    lines.length = 0;
    lines.text[0] = 0;
}

static double seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static fnl_light_params lamp(float x) {
    fnl_light_params light = fnl_light_params_default();
    light.position.x = x;
    light.range = 2;
    return light;
}

/* ---- lights ---- */

static void test_many_lights_change_at_once(void **state) {
    UNUSED(state);
    enum { COUNT = 8 };
    fnl_scene *scene = make_scene();
    fnl_light_id ids[COUNT + 1];
    fnl_light_params params[COUNT + 1];
    for (uint32_t i = 0; i < COUNT; i++) {
        params[i] = lamp((float)i);
        assert_int_equal(fnl_scene_add_light(scene, &params[i], &ids[i]), FNL_OK);
        params[i].position.y = 3;
    }
    params[2].kind = params[5].kind = FNL_LIGHT_DIRECTIONAL; /* which need no place among the local ones */
    params[2].direction = vec3_make(0, -5, 0);
    const uint64_t version = scene->light_version;

    params[6].range = -1;
    expect_misuse(fnl_scene_set_lights(scene, ids, params, COUNT),
                  "fnl_scene_set_lights: element 6: range is -1, must be above 0 metres");
    params[6].range = 2;
    ids[COUNT] = (fnl_light_id){ids[1].index, ids[1].generation + 99};
    params[COUNT] = params[1];
    expect_misuse(fnl_scene_set_lights(scene, ids, params, COUNT + 1), "element 8: light (index 1, generation");
    expect_misuse(fnl_scene_set_lights(scene, NULL, params, 1), "lights is NULL");
    expect_misuse(fnl_scene_set_lights(scene, ids, NULL, 1), "fnl_scene_set_lights: params is NULL");
    assert_int_equal(fnl_scene_set_lights(scene, NULL, NULL, 0), FNL_OK);
    assert_int_equal(scene->light_version, version);
    for (uint32_t i = 0; i < COUNT; i++) assert_true(scene->lights.data[ids[i].index].params.position.y == 0);

    assert_int_equal(fnl_scene_set_lights(scene, ids, params, COUNT), FNL_OK);
    assert_int_equal(scene->light_version, version + 1); /* one step for all */
    assert_int_equal(scene->suns.count, 2);
    assert_true(scene->lights.data[ids[2].index].slot == SCENE_NONE && scene->lights.data[ids[2].index].params.direction.y == -1);
    for (uint32_t i = 0; i < COUNT; i++) assert_true(scene->lights.data[ids[i].index].params.position.y == 3);

    /* Of an id that stands there twice the last parameters count, whatever kind it had between. */
    const fnl_light_id twice[3] = {ids[0], ids[0], ids[0]};
    const fnl_light_params kinds[3] = {params[2], lamp(7), params[2]};
    assert_int_equal(fnl_scene_set_lights(scene, twice, kinds, 3), FNL_OK);
    assert_int_equal(scene->suns.count, 3);
    assert_int_equal(fnl_scene_set_lights(scene, twice, kinds, 2), FNL_OK);
    assert_true(scene->suns.count == 2 && scene->lights.data[ids[0].index].params.position.x == 7);
    fnl_scene_destroy(&scene);
}

/* Whoever follows the list of changed places, or re-reads where it must, knows every one. */
static void test_100000_lights_change_in_milliseconds(void **state) {
    UNUSED(state);
    enum { COUNT = 100000 };
    fnl_scene *scene = make_scene();
    fnl_light_id *ids = malloc(COUNT * sizeof *ids);
    fnl_light_params *params = malloc(COUNT * sizeof *params);
    for (uint32_t i = 0; i < COUNT; i++) {
        params[i] = lamp((float)i);
        assert_int_equal(fnl_scene_add_light(scene, &params[i], &ids[i]), FNL_OK);
        params[i].intensity = 5;
    }
    const uint64_t seen = scene->light_version;
    double start = seconds();
    assert_int_equal(fnl_scene_set_lights(scene, ids, params, COUNT), FNL_OK);
    double all = seconds() - start;
    for (uint32_t i = 0; i < COUNT; i++) assert_true(scene->light_slots.data[i].changed_version > seen);
    assert_true(seen < scene->changed_slots_since); /* too many to list: all are read again */
    start = seconds();
    for (uint32_t i = 0; i < COUNT; i++) assert_int_equal(fnl_scene_set_light(scene, ids[i], &params[i]), FNL_OK);
    print_message("%d lights: %.1f ms in one call, %.1f ms in a call for each\n", COUNT, all * 1e3, (seconds() - start) * 1e3);
    assert_true(all < 1);
    free(ids);
    free(params);
    fnl_scene_destroy(&scene);
}

/* ---- transforms ---- */

static fnl_instance_id id_of(const fnl_scene *scene, uint32_t node) {
    return (fnl_instance_id){node, scene->nodes.data[node].generation};
}

static void test_many_instances_move_at_once(void **state) {
    UNUSED(state);
    fnl_scene *scene = make_scene();
    const mat4 up = mat4_translation(vec3_make(0, 1, 0)), identity = mat4_identity();
    uint32_t parent = scene_add_node(scene, "", SCENE_NONE, &up, SCENE_NONE),
             child = scene_add_node(scene, "", parent, &up, SCENE_NONE),
             leaf = scene_add_node(scene, "", child, &up, SCENE_NONE);
    fnl_light_params params = lamp(0);
    uint32_t light = scene_add_light(scene, &params, leaf);
    for (uint32_t i = 0; i < 3; i++) scene->nodes.data[i].linked = true;
    scene_update_transforms(scene);
    const uint64_t version = scene->transform_version, lights = scene->light_version;
    const fnl_instance_id ids[4] = {id_of(scene, leaf), id_of(scene, parent), {leaf, 77}, id_of(scene, child)};
    fnl_mat4 moves[4] = {mat4_translation(vec3_make(5, 0, 0)), mat4_translation(vec3_make(0, 3, 0)), identity, identity};

    expect_misuse(fnl_scene_set_instance_transforms(scene, ids, moves, 3), "element 2: instance (index 2, generation 77) must be");
    moves[1].m[13] = NAN;
    expect_misuse(fnl_scene_set_instance_transforms(scene, ids, moves, 2), "element 1: transform.m[13] is NaN");
    moves[1].m[13] = 3;
    expect_misuse(fnl_scene_set_instance_transforms(scene, NULL, moves, 2), "instances is NULL");
    expect_misuse(fnl_scene_set_instance_transforms(scene, ids, NULL, 2), "transforms is NULL");
    assert_int_equal(fnl_scene_set_instance_transforms(scene, NULL, NULL, 0), FNL_OK);
    assert_true(scene->transform_version == version && scene->nodes.data[leaf].local.m[12] == 0);

    /* A leaf before what it hangs on: both count, and the light follows in one step. */
    assert_int_equal(fnl_scene_set_instance_transforms(scene, ids, moves, 2), FNL_OK);
    const float *world = scene->nodes.data[leaf].world.m;
    assert_true(world[12] == 5 && world[13] == 4 && scene->nodes.data[child].world.m[13] == 4);
    assert_true(scene->lights.data[light].params.position.x == 5 && scene->lights.data[light].params.position.y == 4);
    assert_true(scene->transform_version == version + 1 && scene->light_version == lights + 1);
    assert_int_equal(scene->moved.count, 3);
    fnl_scene_destroy(&scene);
}

/* A chain, all of which moves: each node's world is computed once, not once for each that moves above it. */
static void test_a_batch_costs_each_node_once(void **state) {
    UNUSED(state);
    enum { COUNT = 3000, FLAT = 10000 };
    fnl_scene *scene = make_scene();
    const mat4 up = mat4_translation(vec3_make(0, 1, 0)), flat = mat4_identity();
    fnl_instance_id *ids = malloc(FLAT * sizeof *ids);
    fnl_mat4 *moves = malloc(FLAT * sizeof *moves);
    uint32_t above = SCENE_NONE;
    for (uint32_t i = 0; i < COUNT; i++) {
        above = scene_add_node(scene, "", above, &flat, SCENE_NONE);
        ids[COUNT - 1 - i] = id_of(scene, above); /* leaves first: the worst order */
        moves[i] = up;
    }
    double start = seconds();
    assert_int_equal(fnl_scene_set_instance_transforms(scene, ids, moves, COUNT), FNL_OK);
    double batch = seconds() - start;
    assert_true(scene->nodes.data[above].world.m[13] == COUNT);
    start = seconds();
    for (uint32_t i = 0; i < COUNT; i++) assert_int_equal(fnl_scene_set_instance_transform(scene, ids[i], &flat), FNL_OK);
    double single = seconds() - start;
    print_message("a chain of %d: %.2f ms in one call, %.1f ms in a call for each\n", COUNT, batch * 1e3, single * 1e3);
    assert_true(batch * 20 < single);

    /* Many under one, which moves too. */
    uint32_t parent = scene_add_node(scene, "", SCENE_NONE, &flat, SCENE_NONE);
    for (uint32_t i = 0; i < FLAT; i++) {
        ids[i] = id_of(scene, scene_add_node(scene, "", parent, &flat, SCENE_NONE));
        moves[i] = up;
    }
    start = seconds();
    assert_int_equal(fnl_scene_set_instance_transforms(scene, ids, moves, FLAT), FNL_OK);
    print_message("%d under one node: %.2f ms\n", FLAT, (seconds() - start) * 1e3);
    free(ids);
    free(moves);
    fnl_scene_destroy(&scene);
}

/* A place that is used again is still in the list of what moved: it must not stand there twice. */
static void test_a_node_is_listed_once(void **state) {
    UNUSED(state);
    fnl_scene *scene = make_scene();
    const mat4 up = mat4_translation(vec3_make(0, 1, 0)), identity = mat4_identity();
    for (uint32_t i = 0; i < 3; i++) {
        uint32_t node = scene_add_node(scene, "", SCENE_NONE, &identity, SCENE_NONE);
        assert_int_equal(node, 0);
        assert_int_equal(fnl_scene_set_instance_transform(scene, id_of(scene, node), &up), FNL_OK);
        assert_int_equal(scene->moved.count, 1);
        assert_int_equal(fnl_scene_remove_instance(scene, id_of(scene, node)), FNL_OK);
    }
    fnl_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_many_lights_change_at_once),
        cmocka_unit_test(test_100000_lights_change_in_milliseconds),
        cmocka_unit_test(test_many_instances_move_at_once),
        cmocka_unit_test(test_a_batch_costs_each_node_once),
        cmocka_unit_test(test_a_node_is_listed_once),
    };
    return cmocka_run_group_tests_name("scene: changes", tests, NULL, NULL);
}
