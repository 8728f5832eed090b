/* SPDX-License-Identifier: MIT */
/* Calls that change much at once: lights, transforms, meshes and poses. What they refuse changes nothing. */
#include "tests/gltf_test_file.h"
#include "tests/guard.h"
#include "tests/test_memory.h"

#include <float.h>
#include <setjmp.h>

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
static void test_100000_lights_change_at_once(void **state) {
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
    assert_int_equal(fnl_scene_set_lights(scene, ids, params, COUNT), FNL_OK);
    for (uint32_t i = 0; i < COUNT; i++) assert_true(scene->light_slots.data[i].changed_version > seen);
    assert_true(seen < scene->changed_slots_since); /* too many to list: all are read again */
    for (uint32_t i = 0; i < COUNT; i++) assert_int_equal(fnl_scene_set_light(scene, ids[i], &params[i]), FNL_OK);
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
    assert_true(scene->transform_version == version && scene_node_local(scene, &scene->nodes.data[leaf]).m[12] == 0);

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
    uint64_t placed = scene->nodes_placed;
    assert_int_equal(fnl_scene_set_instance_transforms(scene, ids, moves, COUNT), FNL_OK);
    assert_int_equal(scene->nodes_placed - placed, COUNT); /* each once */
    assert_true(scene->nodes.data[above].world.m[13] == COUNT);
    placed = scene->nodes_placed;
    for (uint32_t i = 0; i < COUNT; i++) assert_int_equal(fnl_scene_set_instance_transform(scene, ids[i], &flat), FNL_OK);
    assert_int_equal(scene->nodes_placed - placed, COUNT * (COUNT + 1) / 2); /* with what hangs from it */

    /* Many under one, which moves too. */
    uint32_t parent = scene_add_node(scene, "", SCENE_NONE, &flat, SCENE_NONE);
    for (uint32_t i = 0; i < FLAT; i++) {
        ids[i] = id_of(scene, scene_add_node(scene, "", parent, &flat, SCENE_NONE));
        moves[i] = up;
    }
    placed = scene->nodes_placed;
    assert_int_equal(fnl_scene_set_instance_transforms(scene, ids, moves, FLAT), FNL_OK);
    assert_int_equal(scene->nodes_placed - placed, FLAT);
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

/* ---- meshes ---- */

static void test_meshes_change(void **state) {
    UNUSED(state);
    static const float square[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}, tall[12] = {0, 0, 0, 1, 0, 0, 0, 9, 0, 1, 9, 0};
    static const uint32_t indices[6] = {0, 1, 2, 2, 1, 3};
    fnl_scene *scene = make_scene();
    fnl_mesh_params params = {.vertex_count = 4, .index_count = 6, .positions = square, .indices = indices};
    fnl_mesh_id mesh;
    fnl_material_id material;
    fnl_instance_id instance;
    fnl_mesh_info info;
    const fnl_mat4 identity = mat4_identity();
    assert_int_equal(fnl_scene_add_material(scene, NULL, &material), FNL_OK);
    assert_int_equal(fnl_scene_add_mesh(scene, &params, &mesh), FNL_OK);
    assert_int_equal(fnl_scene_add_instance(scene, mesh, &identity, &instance), FNL_OK);
    assert_int_equal(fnl_scene_query_mesh(scene, 0, 0, &info), FNL_OK);
    assert_true(info.primitive_count == 1 && info.corner_count == 3 && info.morph_target_count == 0);
    assert_true(info.params.vertex_count == 6 && info.params.normals[2] == 1 && !info.params.uv); /* a vertex for each corner: flat normals */
    assert_true(info.bounds_high.x == 1 && info.params.material.generation == 0);

    /* What is refused changes nothing. */
    struct scene_primitive before = scene->primitives.data[0];
    const uint64_t version = scene->structure_version;
    params.positions = (const float[12]){0, 0, 0, 1, 0, 0, 0, NAN};
    expect_misuse(fnl_scene_set_mesh(scene, mesh, 0, &params), "fnl_scene_set_mesh: positions[7] is NaN, must be finite");
    params.positions = tall;
    params.indices = (const uint32_t[6]){0, 1, 2, 2, 1, 4};
    expect_misuse(fnl_scene_set_mesh(scene, mesh, 0, &params), "indices[5] is 4, must be below vertex_count, 4");
    params.indices = indices;
    params.material = (fnl_material_id){7, 1};
    expect_misuse(fnl_scene_set_mesh(scene, mesh, 0, &params), "material (index 7, generation 1)");
    params.material = material;
    expect_misuse(fnl_scene_set_mesh(scene, mesh, 1, &params), "primitive is 1, must be 0 .. 0");
    expect_misuse(fnl_scene_set_mesh(scene, (fnl_mesh_id){1, 1}, 0, &params), "mesh (index 1, generation 1)");
    expect_misuse(fnl_scene_query_mesh(scene, 0, 1, &info), "primitive is 1");
    assert_memory_equal(&before, &scene->primitives.data[0], sizeof before);
    assert_int_equal(scene->structure_version, version);

    /* Flat normals are made here, too; bounds follow, and nothing of the caller's is kept. */
    float *positions = malloc(sizeof tall);
    memcpy(positions, tall, sizeof tall);
    params.positions = positions;
    assert_int_equal(fnl_scene_set_mesh(scene, mesh, 0, &params), FNL_OK);
    free(positions);
    assert_int_equal(fnl_scene_query_mesh(scene, 0, 0, &info), FNL_OK);
    assert_true(info.params.vertex_count == 6 && info.params.positions[7] == 9 && info.bounds_high.y == 9);
    assert_true(info.params.material.index == material.index && info.params.material.generation == material.generation);
    fnl_scene_info all;
    assert_int_equal(fnl_scene_query_info(scene, &all), FNL_OK);
    assert_true(all.bounds_high.y == 9);
    assert_true(scene->structure_version > version && scene->primitives.data[0].shape_version == before.shape_version + 1);

    /* What the mesh has anyway, handed back, is no change; a colour is one of attributes alone. */
    const uint64_t same = scene->structure_version;
    assert_int_equal(fnl_scene_set_mesh(scene, mesh, 0, &info.params), FNL_OK);
    assert_int_equal(scene->structure_version, same);
    const float colors[24] = {1, 0, 0, 1};
    info.params.colors = colors;
    assert_int_equal(fnl_scene_set_mesh(scene, mesh, 0, &info.params), FNL_OK);
    assert_int_equal(scene->primitives.data[0].version, before.version + 2);
    assert_int_equal(scene->primitives.data[0].shape_version, before.shape_version + 1);
    fnl_scene_destroy(&scene);
    assert_int_equal(host_state.memory.live_bytes, 0);
}

/* ---- poses ---- */

/* A triangle with two morph targets and a skin of two joints, one below the other; an animation of the first joint, one of the weights. */
static fnl_scene *bendable(uint32_t *node, uint32_t joints[2]) {
    fnl_scene *scene = make_scene();
    struct arena *arena = &scene->arena;
    static const vec3 corners[3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, moves[3] = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
    static const vec3 normals[3] = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
    static const uint32_t indices[3] = {0, 1, 2};
    static const uint16_t joint_indices[12];
    static const float weights[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, defaults[2] = {0, 0.25f}, times[2] = {0, 1};
    static const float heights[6] = {0, 0, 0, 0, 2, 0}, levels[4] = {0, 0, 1, 0.5f};
    static const struct scene_morph_target targets[2] = {{.positions = moves}, {.positions = moves}};
    const struct scene_primitive p = {.material = SCENE_NONE,
                                      .vertex_count = 3,
                                      .index_count = 3,
                                      .indices = indices,
                                      .positions = corners,
                                      .normals = normals,
                                      .joints = joint_indices,
                                      .weights = weights,
                                      .joint_count = 4,
                                      .morph_targets = targets,
                                      .morph_target_count = 2};
    uint32_t mesh = scene_add_mesh(scene, "", &p, 1);
    scene->meshes.data[mesh].morph_weights = defaults;
    const mat4 identity = mat4_identity();
    joints[0] = scene_add_node(scene, "", SCENE_NONE, &identity, SCENE_NONE);
    joints[1] = scene_add_node(scene, "", joints[0], &identity, SCENE_NONE);
    *node = scene_add_node(scene, "", SCENE_NONE, &identity, mesh);
    for (uint32_t i = 0; i < 3; i++) scene->nodes.data[i].has_matrix = false;
    const mat4 bind[2] = {identity, identity};
    const struct scene_skin skin = {
        .joints = arena_copy(arena, joints, 8), .inverse_bind = arena_copy(arena, bind, sizeof bind), .joint_count = 2};
    assert_true(array_push(&scene->host, &scene->skins, skin));
    scene->nodes.data[*node].skin = 0;
    const struct scene_channel channels[2] = {{.node = joints[0],
                                               .path = SCENE_PATH_TRANSLATION,
                                               .interpolation = SCENE_INTERPOLATION_LINEAR,
                                               .key_count = 2,
                                               .width = 3,
                                               .times = times,
                                               .values = heights},
                                              {.node = *node,
                                               .path = SCENE_PATH_WEIGHTS,
                                               .interpolation = SCENE_INTERPOLATION_LINEAR,
                                               .key_count = 2,
                                               .width = 2,
                                               .times = times,
                                               .values = levels}};
    for (uint32_t i = 0; i < 2; i++) {
        const struct scene_animation animation = {
            .channels = arena_copy(arena, &channels[i], sizeof *channels), .channel_count = 1, .duration = 1};
        assert_true(array_push(&scene->host, &scene->animations, animation));
    }
    scene_update_transforms(scene);
    return scene;
}

static fnl_instance_info ask(const fnl_scene *scene, uint32_t node) {
    fnl_instance_info info;
    assert_int_equal(fnl_scene_query_instance(scene, node, &info), FNL_OK);
    return info;
}

static void test_a_pose_lasts_until_it_is_animated(void **state) {
    UNUSED(state);
    uint32_t node, joints[2];
    fnl_scene *scene = bendable(&node, joints);
    const fnl_instance_id id = id_of(scene, node);
    fnl_instance_info info = ask(scene, node);
    assert_true(info.morph_target_count == 2 && info.joint_count == 2 && info.morph_weights[1] == 0.25f);

    float weights[2] = {0.5f, NAN};
    fnl_mat4 transforms[2] = {mat4_translation(vec3_make(0, 1, 0)), mat4_translation(vec3_make(3, 0, 0))};
    fnl_pose pose = {.morph_weights = weights, .morph_weight_count = 2, .joints = transforms, .joint_count = 2};
    const uint64_t version = scene->transform_version;
    expect_misuse(fnl_scene_set_pose(scene, id, &pose), "fnl_scene_set_pose: morph_weights[1] is NaN");
    weights[1] = 0;
    transforms[1].m[15] = 2;
    expect_misuse(fnl_scene_set_pose(scene, id, &pose), "element 1: the last row of transform is 0, 0, 0, 2");
    transforms[1].m[15] = 1;
    pose.joint_count = 1;
    expect_misuse(fnl_scene_set_pose(scene, id, &pose), "joint_count is 1, must be 2, the number of joints of the skin");
    pose.joint_count = 2;
    pose.morph_weight_count = 3;
    expect_misuse(fnl_scene_set_pose(scene, id, &pose), "morph_weight_count is 3, must be 2, the number of morph targets");
    pose.morph_weights = NULL;
    expect_misuse(fnl_scene_set_pose(scene, id, &pose), "morph_weight_count is 3, must be 0: morph_weights is NULL");
    expect_misuse(fnl_scene_set_pose(scene, id_of(scene, joints[0]), &(fnl_pose){.morph_weights = weights, .morph_weight_count = 2}),
                  "morph_weight_count is 2, must be 0, the number of morph targets");
    expect_misuse(fnl_scene_set_pose(scene, id, NULL), "pose is NULL");
    assert_true(scene->transform_version == version && ask(scene, node).morph_weights[0] == 0);
    assert_true(scene->nodes.data[joints[1]].world.m[12] == 0);

    pose.morph_weights = weights;
    pose.morph_weight_count = 2;
    assert_int_equal(fnl_scene_set_pose(scene, id, &pose), FNL_OK);
    assert_true(ask(scene, node).morph_weights[0] == 0.5f && ask(scene, node).morph_weights[1] == 0);
    assert_true(ask(scene, joints[1]).world.m[12] == 3 && ask(scene, joints[1]).world.m[13] == 1);
    assert_true(scene->nodes.data[node].moved_version > version && scene->nodes.data[joints[1]].moved_version > version);
    assert_int_equal(fnl_scene_set_pose(scene, id, &(fnl_pose){0}), FNL_OK);
    assert_true(ask(scene, node).morph_weights[0] == 0.5f && ask(scene, joints[1]).world.m[12] == 3);

    /* An animation of one joint moves that joint; weights and the other joint stay as they were posed. */
    assert_int_equal(fnl_scene_set_time(scene, 0, 1), FNL_OK);
    assert_true(ask(scene, joints[0]).world.m[13] == 2 && ask(scene, joints[1]).transform.m[12] == 3);
    assert_true(ask(scene, node).morph_weights[0] == 0.5f);
    /* One of the weights sets them, and leaves the joints. */
    assert_int_equal(fnl_scene_set_time(scene, 1, 1), FNL_OK);
    assert_true(ask(scene, node).morph_weights[0] == 1 && ask(scene, node).morph_weights[1] == 0.5f);
    assert_true(ask(scene, joints[0]).world.m[13] == 2 && ask(scene, joints[1]).transform.m[12] == 3);
    assert_int_equal(fnl_scene_set_pose(scene, id, &pose), FNL_OK);
    assert_true(ask(scene, joints[0]).world.m[13] == 1 && ask(scene, node).morph_weights[0] == 0.5f);

    /* Joints and weights belong to vertices: their number and order stay. */
    fnl_mesh_info mesh;
    assert_int_equal(fnl_scene_query_mesh(scene, 0, 0, &mesh), FNL_OK);
    fnl_mesh_params params = mesh.params;
    params.normals = NULL;
    expect_misuse(fnl_scene_set_mesh(scene, (fnl_mesh_id){0, 1}, 0, &params), "normals is NULL, must be given: the mesh has morph targets");
    params = mesh.params;
    params.vertex_count = 2;
    expect_misuse(fnl_scene_set_mesh(scene, (fnl_mesh_id){0, 1}, 0, &params), "indices[2] is 2");
    params.index_count = 3;
    params.indices = (const uint32_t[3]){0, 1, 1};
    expect_misuse(fnl_scene_set_mesh(scene, (fnl_mesh_id){0, 1}, 0, &params), "vertex_count is 2, must stay 3: the mesh has morph targets");
    params = mesh.params;
    params.positions = (const float[9]){0, 0, 0, 2, 0, 0, 0, 2, 0};
    assert_int_equal(fnl_scene_set_mesh(scene, (fnl_mesh_id){0, 1}, 0, &params), FNL_OK);
    const struct scene_primitive *p = &scene->primitives.data[0];
    assert_true(p->joint_count == 4 && p->morph_target_count == 2 && p->joints && p->bounds.high.x == 2 && p->bounds.high.z == 2);

    /* Weights of instances that come and go are not kept. */
    fnl_instance_id other;
    const fnl_mat4 identity = mat4_identity();
    long long held = 0;
    for (uint32_t i = 0; i < 50; i++) {
        assert_int_equal(fnl_scene_add_instance(scene, (fnl_mesh_id){0, 1}, &identity, &other), FNL_OK);
        assert_int_equal(fnl_scene_set_pose(scene, other, &(fnl_pose){.morph_weights = weights, .morph_weight_count = 2}), FNL_OK);
        assert_int_equal(fnl_scene_remove_instance(scene, other), FNL_OK);
        if (i == 0) held = host_state.memory.live_bytes;
    }
    assert_int_equal(host_state.memory.live_bytes, held);
    fnl_scene_destroy(&scene);
    assert_int_equal(host_state.memory.live_bytes, 0);
    assert_int_equal(host_state.memory.wrong_sizes, 0);
}

/* ---- memory that runs out ---- */

/* Each allocation of a call fails in turn: the scene is as it was, and the call succeeds in the end. */
static void test_without_memory_nothing_changes(void **state) {
    UNUSED(state);
    for (int what = 0; what < 3; what++) {
        uint32_t node, joints[2], failures = 0;
        fnl_scene *scene = bendable(&node, joints);
        fnl_light_id light;
        fnl_light_params params = lamp(1);
        assert_int_equal(fnl_scene_add_light(scene, &params, &light), FNL_OK);
        fnl_light_id many[40];
        fnl_light_params suns[40];
        for (uint32_t i = 0; i < 40; i++) {
            many[i] = light;
            suns[i] = fnl_light_params_default();
            suns[i].kind = FNL_LIGHT_DIRECTIONAL;
        }
        const float weights[2] = {1, 1}, uv[6] = {0, 0, 1, 0, 0, 1}, tangents[12] = {1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1};
        const fnl_mat4 transforms[2] = {mat4_translation(vec3_make(1, 0, 0)), mat4_identity()};
        const fnl_pose pose = {weights, 2, transforms, 2};
        fnl_mesh_info mesh;
        assert_int_equal(fnl_scene_query_mesh(scene, 0, 0, &mesh), FNL_OK);
        mesh.params.uv = uv;
        mesh.params.tangents = tangents;
        fnl_result result = FNL_ERROR_MEMORY;
        for (uint32_t allocation = 1; result == FNL_ERROR_MEMORY; allocation++) {
            const uint64_t versions[3] = {scene->structure_version, scene->transform_version, scene->light_version};
            const long long held = host_state.memory.live_bytes;
            lines.count = 0;
            host_state.memory.allocations = 0;
            host_state.memory.fail_at = allocation;
            result = what == 0   ? fnl_scene_set_lights(scene, many, suns, 40)
                     : what == 1 ? fnl_scene_set_mesh(scene, (fnl_mesh_id){0, 1}, 0, &mesh.params)
                                 : fnl_scene_set_pose(scene, id_of(scene, node), &pose);
            host_state.memory.fail_at = 0;
            if (result == FNL_OK) break;
            assert_int_equal(result, FNL_ERROR_MEMORY);
            assert_true(lines.count > 0); /* told */
            failures++;
            assert_true(scene->structure_version == versions[0] && scene->transform_version == versions[1] &&
                        scene->light_version == versions[2]);
            assert_true(!scene->primitives.data[0].uv[0] && scene->suns.count == 0 && ask(scene, node).morph_weights[0] == 0);
            if (what == 1) assert_int_equal(host_state.memory.live_bytes, held);
        }
        assert_true(failures > 0);
        fnl_scene_destroy(&scene);
        assert_int_equal(host_state.memory.live_bytes, 0);
    }
}

/* Some allocations of a scattering fail in turn: there are no new lights, decals or pictures, and in the end there are all. */
static void test_scattering_is_all_or_nothing(void **state) {
    UNUSED(state);
    enum { COUNT = 300 };
    for (int what = 0; what < 2; what++) {
        uint32_t node, joints[2], failures = 0;
        fnl_scene *scene = bendable(&node, joints);
        scene->nodes.data[node].skin = SCENE_NONE; /* decals that are scattered avoid what a skin deforms */
        fnl_result result = FNL_ERROR_MEMORY;
        for (uint32_t allocation = 1; result == FNL_ERROR_MEMORY; allocation += allocation < 3 ? 1 : 8) {
            lines.count = 0;
            host_state.memory.allocations = 0;
            host_state.memory.fail_at = allocation;
            result = what == 0 ? fnl_scene_scatter_lights(scene, COUNT, 1) : fnl_scene_scatter_decals(scene, COUNT, 1);
            host_state.memory.fail_at = 0;
            if (result == FNL_OK) break;
            assert_int_equal(result, FNL_ERROR_MEMORY);
            assert_true(lines.count > 0); /* told */
            failures++;
            assert_true(scene->lights.count + scene->light_slots.count + scene->decals.count + scene->images.count == 0);
        }
        assert_true(failures >= 2);
        if (what == 0) assert_true(scene->lights.count == COUNT && scene->light_slots.count == COUNT);
        if (what == 1) assert_true(scene->decals.count > COUNT / 2 && scene->images.count == 12);
        fnl_scene_destroy(&scene);
    }
}

/* ---- limits ---- */

static void expect_too_many(fnl_result result, const char *words) {
    assert_int_equal(result, FNL_ERROR_UNSUPPORTED);
    if (!strstr(lines.text, words)) fail_msg("no '%s' in:\n%s", words, lines.text);
    lines.length = 0;
    lines.text[0] = 0;
}

/* Of more local lights the device could not find the shapes. No call goes beyond, and what is there stays as it was. */
static void test_too_many_lights(void **state) {
    UNUSED(state);
    fnl_scene *scene = make_scene();
    fnl_light_id ids[3];
    fnl_light_params local = lamp(1), sun = fnl_light_params_default();
    sun.kind = FNL_LIGHT_DIRECTIONAL;
    for (uint32_t i = 0; i < 3; i++) assert_int_equal(fnl_scene_add_light(scene, i ? &local : &sun, &ids[i]), FNL_OK);
    const long long held = host_state.memory.live_bytes;
    expect_too_many(fnl_scene_scatter_lights(scene, SCENE_LOCAL_LIGHTS_MAX - 1, 1),
                    "too many lights: 47999999 to add to 2 that are not directional, of which there can be at most 48000000");
    const uint32_t slots = scene->light_slots.count;
    scene->light_slots.count = SCENE_LOCAL_LIGHTS_MAX; /* as if there were so many; nothing looks at them */
    fnl_light_id id;
    expect_too_many(fnl_scene_add_light(scene, &local, &id), "too many lights: 1 to add to 48000000 that");
    assert_true(id.generation == 0 && scene->lights.count == 3);
    expect_too_many(fnl_scene_set_light(scene, ids[0], &local), "too many lights: 1 to add");
    assert_int_equal(scene->lights.data[ids[0].index].params.kind, FNL_LIGHT_DIRECTIONAL);
    assert_int_equal(fnl_scene_set_light(scene, ids[1], &local), FNL_OK);
    assert_int_equal(host_state.memory.live_bytes, held);
    scene->light_slots.count = slots;
    assert_int_equal(fnl_scene_remove_light(scene, ids[1]), FNL_OK);
    scene->light_slots.count = SCENE_LOCAL_LIGHTS_MAX; /* and one place is free */
    assert_int_equal(scene->free_light_slots.count, 1);
    host_state.memory.allocations = 0;
    host_state.memory.fail_at = 1; /* one more would be allowed, if there were memory for so many */
    assert_int_equal(scene_reserve_lights(scene, 1), FNL_ERROR_MEMORY);
    host_state.memory.fail_at = 0;
    lines.length = 0;
    expect_too_many(scene_reserve_lights(scene, 2), "too many lights: 2 to add to 47999999 that");
    scene->light_slots.count = slots;
    fnl_scene_destroy(&scene);
    assert_int_equal(host_state.memory.live_bytes, 0);
}

/* Indices skip what was removed, whether little was or much, and come cheap where little was. */
static void test_indices_skip_holes(void **state) {
    UNUSED(state);
    enum { COUNT = 20000 };
    static fnl_light_id ids[COUNT];
    const fnl_light_params light = fnl_light_params_default();
    fnl_scene *scene = make_scene();
    struct random_state random = {5};
    uint32_t count = COUNT;
    for (uint32_t i = 0; i < COUNT; i++) assert_int_equal(fnl_scene_add_light(scene, &light, &ids[i]), FNL_OK);
    for (uint32_t step = 0; step < 6; step++) {
        static const uint32_t wanted[] = {1, 2, 5, 40, 12000, 7000};
        for (uint32_t k = 0; k < wanted[step]; k++) {
            const uint32_t at = step == 0 ? 0 : step == 1 ? count - 1 : (uint32_t)(random_float(&random) * (float)count) % count;
            assert_int_equal(fnl_scene_remove_light(scene, ids[at]), FNL_OK);
            memmove(ids + at, ids + at + 1, (--count - at) * sizeof *ids);
        }
        for (uint32_t i = 0; i < count; i++) {
            fnl_entity_info info;
            assert_int_equal(fnl_scene_query_entity(scene, FNL_ENTITY_LIGHT, i, &info), FNL_OK);
            assert_int_equal(info.id.light.index, ids[i].index);
        }
        if (step >= 3) continue;
        fnl_entity_info info; /* the last one is found without a look at those before it */
        struct guard guard = guard_begin(scene->lights.data, (COUNT - 64) * sizeof *scene->lights.data);
        assert_true(guard.size > 0);
        assert_int_equal(fnl_scene_query_entity(scene, FNL_ENTITY_LIGHT, count - 1, &info), FNL_OK);
        guard_end(&guard);
        assert_int_equal(info.id.light.index, ids[count - 1].index);
    }
    fnl_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_many_lights_change_at_once),
        cmocka_unit_test(test_100000_lights_change_at_once),
        cmocka_unit_test(test_many_instances_move_at_once),
        cmocka_unit_test(test_a_batch_costs_each_node_once),
        cmocka_unit_test(test_a_node_is_listed_once),
        cmocka_unit_test(test_meshes_change),
        cmocka_unit_test(test_a_pose_lasts_until_it_is_animated),
        cmocka_unit_test(test_without_memory_nothing_changes),
        cmocka_unit_test(test_scattering_is_all_or_nothing),
        cmocka_unit_test(test_too_many_lights),
        cmocka_unit_test(test_indices_skip_holes),
    };
    return cmocka_run_group_tests_name("scene: changes", tests, NULL, NULL);
}
