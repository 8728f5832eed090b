/* SPDX-License-Identifier: MIT */
/* Distant places: composed in doubles, returned in floats relative to an origin that moves without a trace. */
#include "tests/gltf_test_file.h"

#include <setjmp.h>

#include <cmocka.h>

#define ASSET "\"asset\":{\"version\":\"2.0\"}"
/* A triangle of 1 m, and a lamp. */
#define PARTS                                                                                                                          \
    "\"buffers\":[{\"byteLength\":36}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],"                                              \
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3,\"min\":[0,0,0],\"max\":[1,1,0]}],"           \
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],\"cameras\":[{\"type\":\"perspective\",\"perspective\":"           \
    "{\"yfov\":1,\"znear\":0.1}}],\"extensionsUsed\":[\"KHR_lights_punctual\"],\"extensions\":{\"KHR_lights_punctual\":{\"lights\":"     \
    "[{\"type\":\"point\",\"intensity\":5}]}}"
static const float triangle[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
static struct test_log file_log;

static fnl_scene *load(const char *nodes) {
    char json[4000];
    fnl_scene *scene = NULL;
    snprintf(json, sizeof json, "{" ASSET "," PARTS ",\"scenes\":[{\"nodes\":[0]}],\"scene\":0,\"nodes\":[%s]}", nodes);
    if (test_load(&file_log, json, triangle, sizeof triangle, &scene) != FNL_OK || file_log.count) fail_msg("%s", file_log.text);
    return scene;
}

static void expect_origin(const fnl_scene *scene, double x, double y, double z) {
    double o[3];
    assert_int_equal(fnl_scene_query_origin(scene, o), FNL_OK);
    if (o[0] != x || o[1] != y || o[2] != z) fail_msg("the origin is %.10g %.10g %.10g, not %.10g %.10g %.10g", o[0], o[1], o[2], x, y, z);
}

static void expect_place(const fnl_scene *scene, uint32_t node, double x, double y, double z, double error) {
    const double *m = scene->nodes.data[node].world_exact.m + 9;
    if (!(fabs(m[0] - x) <= error && fabs(m[1] - y) <= error && fabs(m[2] - z) <= error))
        fail_msg("node %u is at %.12g %.12g %.12g, not at %.12g %.12g %.12g", node, m[0], m[1], m[2], x, y, z);
}

#define LAMP "{\"translation\":[0.125,2,0.5],\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}}"

/* One place in four notations: exact in doubles, and the floats relative to the origin are the same to the bit. */
static void test_nodes_are_composed_in_doubles(void **state) {
    UNUSED(state);
    static const char *const files[] = {
        "{\"children\":[1,2,3],\"translation\":[6371000.25,-40.5,1234567.75]},{\"mesh\":0},{\"camera\":0,\"translation\":[0,0,3]}," LAMP,
        "{\"children\":[1,2,3],\"matrix\":[1,0,0,0,0,1,0,0,0,0,1,0,6371000.25,-40.5,1234567.75,1]},{\"mesh\":0},{\"camera\":0,\"translation\":[0,0,3]}," LAMP,
        /* Turned about y by an angle with the cosine 0.28 and the sine 0.96, and back. */
        "{\"children\":[4],\"rotation\":[0,0.6,0,0.8]},{\"mesh\":0},{\"camera\":0,\"translation\":[0,0,3]}," LAMP
        ",{\"children\":[1,2,3],\"translation\":[598695.03,-40.5,6461839.21],\"rotation\":[0,-0.6,0,0.8]}",
        /* The parent is far in the other direction. */
        "{\"children\":[4],\"translation\":[-6371000.25,0,0],\"scale\":[2,2,2]},{\"mesh\":0},{\"camera\":0,\"translation\":[0,0,3]}," LAMP
        ",{\"children\":[1,2,3],\"translation\":[6371000.25,-20.25,617283.875],\"scale\":[0.5,0.5,0.5]}"};
    fnl_camera first_camera = {0};
    fnl_light_params first_light = {0};
    mat4 first = mat4_identity();
    for (uint32_t i = 0; i < COUNT_OF(files); i++) {
        fnl_scene *scene = load(files[i]);
        fnl_camera camera;
        fnl_light_params light;
        expect_origin(scene, 6371008, -48, 1234560);
        expect_place(scene, 1, 6371000.25, -40.5, 1234567.75, 1e-8);
        const mat4 world = scene->nodes.data[1].world;
        assert_true(world.m[12] == -7.75f && world.m[13] == 7.5f && world.m[14] == 7.75f);
        assert_int_equal(fnl_scene_query_camera(scene, 0, &camera), FNL_OK);
        assert_int_equal(fnl_scene_query_light(scene, 0, &light), FNL_OK);
        assert_true(vec3_distance(camera.position, vec3_make(-7.75f, 7.5f, 10.75f)) < 2e-6f);
        assert_true(vec3_distance(light.position, vec3_make(-7.625f, 9.5f, 8.25f)) < 2e-6f);
        if (i == 0) {
            first = world;
            first_camera = camera;
            first_light = light;
        }
        for (int k = 0; k < 16; k++) assert_true(fabsf(world.m[k] - first.m[k]) < 1e-6f);
        if (i == 1) assert_true(memcmp(&camera.position, &first_camera.position, sizeof(vec3)) == 0 && memcmp(&light, &first_light, sizeof light) == 0);
        fnl_scene_destroy(&scene);
    }
}

/* Only distant scenes that are not large get an origin, by the bounds of the shown geometry. */
static void test_who_gets_an_origin(void **state) {
    UNUSED(state);
    static const struct {
        const char *nodes;
        double x, y, z;
    } cases[] = {{"{\"mesh\":0,\"translation\":[2000,0,0]}", 0, 0, 0},
                 {"{\"mesh\":0,\"translation\":[2100,0,3]}", 2096, 0, 0},
                 {"{\"mesh\":0,\"translation\":[0,-2000000,0]}", 0, -2000000, 0},
                 {"{\"mesh\":0,\"translation\":[6371000,0,0],\"scale\":[1000000,1000000,1]}", 6871008, 500000, 0},
                 {"{\"mesh\":0,\"translation\":[6371000,0,0],\"scale\":[10000000,10000000,1]}", 0, 0, 0}, /* a planet */
                 {"{\"children\":[1,2]},{\"mesh\":0,\"translation\":[-5000,0,0]},{\"mesh\":0,\"translation\":[5000,0,0]}", 0, 0, 0},
                 {"{\"translation\":[9000000,0,0]}", 0, 0, 0}, /* nothing is shown */
                 {"{\"mesh\":0,\"translation\":[1e15,0,0]}", 0, 0, 0}};
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        fnl_scene *scene = load(cases[i].nodes);
        expect_origin(scene, cases[i].x, cases[i].y, cases[i].z);
        fnl_scene_destroy(&scene);
    }
    /* Instances of one node, and the joints of a skin, count with their own positions. */
    fnl_scene *scene = load("{\"mesh\":0}");
    const mat4 far = mat4_translation(vec3_make(1 << 20, 0, 0));
    scene->nodes.data[0].instances = &far;
    scene_find_origin(scene);
    expect_origin(scene, (1 << 20), 0, 0);
    const mat4 world = scene_instance_world(scene, &scene->nodes.data[0], 0);
    assert_true(world.m[12] == 0);
    fnl_scene_destroy(&scene);
}

/* A hash of all float positions. */
static uint64_t places_of(const fnl_scene *scene) {
    uint64_t hash = 1;
    for (uint32_t i = 0; i < scene->nodes.count; i++) {
        hash = hash_bytes(&scene->nodes.data[i].world, sizeof(mat4), hash);
        const mat4 local = scene_node_local(scene, &scene->nodes.data[i]);
        hash = hash_bytes(&local, sizeof local, hash);
    }
    for (uint32_t i = 0; i < scene->lights.count; i++) {
        const struct scene_light *light = &scene->lights.data[i];
        hash = hash_bytes(&light->params.position, sizeof(vec3), hash);
        if (light->hull) hash = hash_bytes(&light->hull->center, sizeof(vec3), hash);
    }
    for (uint32_t i = 0; i < scene->decals.count; i++) hash = hash_bytes(&scene->decals.data[i].params.transform, sizeof(mat4), hash);
    for (uint32_t i = 0; i < scene->probes.count; i++) hash = hash_bytes(&scene->probes.data[i].params.centre, sizeof(vec3), hash);
    for (uint32_t i = 0; i < fnl_scene_count(scene, FNL_ENTITY_CAMERA); i++) {
        fnl_camera camera;
        assert_int_equal(fnl_scene_query_camera(scene, i, &camera), FNL_OK);
        hash = hash_bytes(&camera.position, sizeof(vec3), hash);
    }
    return hash;
}

struct world {
    fnl_scene *scene;
    fnl_instance_id root, child;
    fnl_light_id light;
    fnl_decal_id decal, carried;
    fnl_probe_id probe;
};

static const float hull[] = {-0.1f, 0, 0, 1, 0, 0, 0, 1.3f, 0, 0.1f, 0.2f, 1};

/* One free entity of each kind, and one that a node carries. */
static struct world make_world(void) {
    struct world w = {.scene = load("{\"children\":[1,2,3],\"translation\":[0.3,0,-0.7]},{\"mesh\":0,\"translation\":[0.1,0.7,0]},"
                                    "{\"camera\":0,\"translation\":[0,0,3]}," LAMP)};
    fnl_scene *s = w.scene;
    const fnl_mat4 place = mat4_translation(vec3_make(0.1f, -3.3f, 7));
    fnl_light_params light = fnl_light_params_default();
    fnl_decal_params decal = fnl_decal_params_default();
    fnl_probe_params probe = fnl_probe_params_default();
    fnl_camera camera = fnl_camera_default();
    fnl_entity_info info;
    light.position = vec3_make(0.3f, 1.7f, -0.9f);
    decal.transform = mat4_translation(vec3_make(1.1f, 0.2f, 0.3f));
    probe.centre = vec3_make(-0.7f, 0.1f, 0.9f);
    camera.position = vec3_make(3.3f, 1.1f, 0.7f);
    assert_int_equal(fnl_scene_add_instance(s, (fnl_mesh_id){0, FIRST_GENERATION}, &place, &w.root), FNL_OK);
    assert_int_equal(fnl_scene_add_light(s, &light, &w.light), FNL_OK);
    assert_int_equal(fnl_scene_set_light_hull(s, w.light, (const fnl_vec3 *)(const void *)hull, 4), FNL_OK);
    assert_int_equal(fnl_scene_add_decal(s, &decal, &w.decal), FNL_OK);
    assert_int_equal(fnl_scene_query_entity(s, FNL_ENTITY_INSTANCE, 1, &info), FNL_OK);
    w.child = decal.instance = info.id.instance;
    assert_int_equal(fnl_scene_add_decal(s, &decal, &w.carried), FNL_OK);
    assert_int_equal(fnl_scene_add_probe(s, &probe, &w.probe), FNL_OK);
    assert_int_equal(fnl_scene_add_camera(s, "own", &camera), FNL_OK);
    return w;
}

static void move(const struct world *w, double x, double y, double z) {
    assert_int_equal(fnl_scene_set_origin(w->scene, (const double[]){x, y, z}), FNL_OK);
}

/* Floats follow the origin, and are restored when it is back, independent of its path. */
static void test_origin_moves_and_comes_back(void **state) {
    UNUSED(state);
    struct world w = make_world();
    fnl_scene *s = w.scene;
    const uint64_t before = places_of(s), transforms = s->transform_version, lights = s->light_version;
    double planes[4][4];
    assert_int_equal(s->lights.data[w.light.index].hull->plane_count, 4);
    memcpy(planes, s->lights.data[w.light.index].hull->planes, sizeof planes);
    move(&w, 0, 0, 0);
    assert_true(s->transform_version == transforms && s->light_version == lights); /* nothing has changed */
    move(&w, 64, -32, 16);
    const vec3 by = {-64, 32, -16};
    const struct scene_light *light = &s->lights.data[w.light.index];
    fnl_instance_info info;
    fnl_camera camera;
    assert_true(s->transform_version > transforms && s->light_version > lights && s->origin_version == s->transform_version);
    assert_true(vec3_distance(light->params.position, vec3_add(vec3_make(0.3f, 1.7f, -0.9f), by)) < 4e-6f);
    assert_true(vec3_distance(s->lights.data[0].params.position, vec3_add(vec3_make(0.425f, 2, -0.2f), by)) < 4e-6f); /* of a node */
    assert_true(fabsf(s->decals.data[w.decal.index].params.transform.m[12] + 62.9f) < 4e-6f);
    assert_true(s->decals.data[w.carried.index].params.transform.m[12] == 1.1f); /* in its node's space */
    assert_true(fabsf(s->probes.data[w.probe.index].params.centre.z + 15.1f) < 2e-6f);
    assert_int_equal(fnl_scene_query_camera(s, 1, &camera), FNL_OK);
    assert_true(vec3_distance(camera.position, vec3_make(-60.7f, 33.1f, -15.3f)) < 4e-6f);
    assert_true(vec3_distance(camera.target, vec3_add(fnl_camera_default().target, by)) < 1e-5f);
    assert_int_equal(fnl_scene_query_instance(s, 4, &info), FNL_OK); /* root: relative to origin; child: to parent */
    assert_true(fabsf(info.transform.m[12] + 63.9f) < 4e-6f && info.transform.m[12] == info.world.m[12]);
    assert_int_equal(fnl_scene_query_instance(s, 1, &info), FNL_OK);
    assert_true(info.transform.m[12] == 0.1f && fabsf(info.world.m[12] + 63.6f) < 4e-6f);
    assert_true(vec3_distance(light->hull->center, vec3_make((float)(light->hull->place[0] - 64), (float)(light->hull->place[1] + 32),
                                                             (float)(light->hull->place[2] - 16))) == 0);
    for (int i = 0; i < 4; i++) { /* the hull's planes moved with its points */
        const double *n = light->hull->planes[i], *old = planes[i];
        const vec3 p = ((const vec3 *)(const void *)hull)[i];
        const double there = n[0] * ((double)p.x - 64) + n[1] * ((double)p.y + 32) + n[2] * ((double)p.z - 16) + n[3];
        const double here = old[0] * (double)p.x + old[1] * (double)p.y + old[2] * (double)p.z + old[3];
        assert_true(fabs(there - here) < 1e-9);
    }
    move(&w, 6371000.125, 1e11, -77777.7);
    move(&w, -0.1, 0.3, 12345678);
    move(&w, 0, 0, 0);
    assert_int_equal(places_of(s), before);
    for (int i = 0; i < 4; i++) assert_true(fabs(light->hull->planes[i][3] - planes[i][3]) < 1e-3);
    fnl_scene_destroy(&w.scene);
}

/* Added or set positions keep their place when the origin moves; setting queried parameters changes nothing. */
static void test_floats_mean_the_origin_of_their_time(void **state) {
    UNUSED(state);
    struct world w = make_world();
    fnl_scene *s = w.scene;
    move(&w, 6371000, 0, 0);
    const uint64_t far = places_of(s);
    fnl_light_params light;
    fnl_decal_params decal;
    fnl_probe_params probe;
    assert_int_equal(fnl_scene_query_light(s, 1, &light), FNL_OK);
    assert_int_equal(fnl_scene_query_decal(s, 0, &decal), FNL_OK);
    assert_int_equal(fnl_scene_query_probe(s, 0, &probe), FNL_OK);
    light.intensity = 7;
    assert_int_equal(fnl_scene_set_light(s, w.light, &light), FNL_OK);
    assert_int_equal(fnl_scene_set_decal(s, w.decal, &decal), FNL_OK);
    assert_int_equal(fnl_scene_set_probe(s, w.probe, &probe), FNL_OK);
    assert_int_equal(places_of(s), far);
    move(&w, 0, 0, 0);
    assert_true(s->lights.data[w.light.index].params.position.x == 0.3f && s->decals.data[w.decal.index].params.transform.m[12] == 1.1f &&
                s->probes.data[w.probe.index].params.centre.x == -0.7f);

    move(&w, 6371000, 0, 0);
    const fnl_mat4 near = mat4_translation(vec3_make(0.375f, 0, 0));
    light.position.x = 0.375f;
    decal.transform.m[12] = 0.375f;
    probe.centre.x = 0.375f;
    assert_int_equal(fnl_scene_set_light(s, w.light, &light), FNL_OK);
    assert_int_equal(fnl_scene_set_decal(s, w.decal, &decal), FNL_OK);
    assert_int_equal(fnl_scene_set_probe(s, w.probe, &probe), FNL_OK);
    assert_int_equal(fnl_scene_set_instance_transform(s, w.root, &near), FNL_OK);
    expect_place(s, w.root.index, 6371000.375, 0, 0, 0);
    assert_true(s->nodes.data[w.root.index].world.m[12] == 0.375f);
    move(&w, 6371001, 0, 0);
    assert_true(s->lights.data[w.light.index].params.position.x == -0.625f && s->decals.data[w.decal.index].params.transform.m[12] == -0.625f &&
                s->probes.data[w.probe.index].params.centre.x == -0.625f && s->nodes.data[w.root.index].world.m[12] == -0.625f);
    const fnl_mat4 beside = mat4_translation(vec3_make(0.5f, 0, 0)); /* children are relative to parents */
    assert_int_equal(fnl_scene_set_instance_transform(s, w.child, &beside), FNL_OK);
    assert_true(scene_node_local(s, &s->nodes.data[w.child.index]).m[12] == 0.5f);
    expect_place(s, w.child.index, 0.8, 0, -0.7, 1e-6);
    fnl_scene_destroy(&w.scene);
}

/* Two ends of a planet: floats are exact near both. */
static void test_both_ends_of_a_planet(void **state) {
    UNUSED(state);
    fnl_scene *scene = load("{\"children\":[1,2]},{\"mesh\":0,\"translation\":[-6371000.3,0.1,0]},{\"mesh\":0,\"translation\":[6371000.7,0.1,0]}");
    expect_origin(scene, 0, 0, 0);
    const double ends[] = {-6371000, 6371000};
    for (int i = 0; i < 2; i++) {
        assert_int_equal(fnl_scene_set_origin(scene, (const double[]){ends[i], 0, 0}), FNL_OK);
        assert_true(fabsf(scene->nodes.data[1 + i].world.m[12] - (i ? 0.7f : -0.3f)) < 1e-7f);
    }
    fnl_scene_destroy(&scene);
}

/* A file loaded into a scene keeps its coordinates, independent of both origins. */
static void test_files_into_a_scene(void **state) {
    UNUSED(state);
    char json[4000];
    size_t size;
    snprintf(json, sizeof json, "{" ASSET "," PARTS ",\"scenes\":[{\"nodes\":[0],\"extensions\":{\"FNL_surroundings\":{\"probes\":[{\"centre\":[6371000.125,1,2],"
             "\"halfSize\":[1,1,1]}]}}}],\"scene\":0,\"nodes\":[{\"children\":[1,2],\"translation\":[6371000.25,0,0]},{\"mesh\":0}," LAMP "]}");
    unsigned char *glb = test_glb(json, triangle, sizeof triangle, &size);
    fnl_load_params params = fnl_load_params_default();
    params.data = glb;
    params.size = size;
    for (int far = 0; far < 2; far++) {
        fnl_scene *scene;
        fnl_loaded loaded;
        assert_int_equal(fnl_scene_create(NULL, &scene), FNL_OK);
        assert_int_equal(fnl_scene_set_origin(scene, (const double[]){far ? 6371008 : 0, 0, 0}), FNL_OK);
        assert_int_equal(fnl_scene_load_into(scene, (fnl_instance_id){0, 0}, "part.glb", &params, &loaded), FNL_OK);
        expect_origin(scene, far ? 6371008 : 0, 0, 0);
        expect_place(scene, loaded.root.index, 0, 0, 0, 0);
        expect_place(scene, loaded.root.index + 2, 6371000.25, 0, 0, 0);
        if (far) assert_true(scene->nodes.data[loaded.root.index + 2].world.m[12] == -7.75f && scene->lights.data[0].params.position.x == -7.625f);
        assert_int_equal(scene->probes.count, 1);
        assert_true(scene->probes.data[0].params.centre.x == (far ? -7.875f : 6371000.125f));
        assert_int_equal(fnl_scene_set_origin(scene, (const double[]){6371000, 0, 0}), FNL_OK);
        assert_true(scene->lights.data[0].params.position.x == 0.375f && scene->probes.data[0].params.centre.x == 0.125f);
        fnl_scene_destroy(&scene);
    }
    free(glb);
}

/* An animation that rotates a distant root keeps the translation in doubles. */
static void test_animated_far_away(void **state) {
    UNUSED(state);
    struct {
        float positions[9], times[2], turns[8];
    } binary = {{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1}, {0, 0, 0, 1, 0, 0, 1, 0}};
    char json[4000];
    fnl_scene *scene;
    snprintf(json, sizeof json,
             "{" ASSET ",\"buffers\":[{\"byteLength\":%zu}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},{\"buffer\":0,\"byteOffset\":36,\"byteLength\":40}],"
             "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3,\"min\":[0,0,0],\"max\":[1,1,0]},"
             "{\"bufferView\":1,\"componentType\":5126,\"type\":\"SCALAR\",\"count\":2,\"min\":[0],\"max\":[1]},"
             "{\"bufferView\":1,\"byteOffset\":8,\"componentType\":5126,\"type\":\"VEC4\",\"count\":2}],"
             "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0,\"translation\":"
             "[6371000.3,0,0]}],\"animations\":[{\"samplers\":[{\"input\":1,\"output\":2}],\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,"
             "\"path\":\"rotation\"}}]}]}",
             sizeof binary);
    if (test_load(&file_log, json, &binary, sizeof binary, &scene) != FNL_OK || file_log.count) fail_msg("%s", file_log.text);
    const float x = scene->nodes.data[0].world.m[12];
    assert_int_equal(fnl_scene_set_time(scene, 0, 0.5), FNL_OK);
    expect_place(scene, 0, 6371000.3, 0, 0, 1e-9);
    assert_true(scene->nodes.data[0].world.m[12] == x && fabsf(scene->nodes.data[0].world.m[0]) < 1e-6f);
    fnl_scene_destroy(&scene);
}

/* A skin is where its joints are, those that were removed too; and so are the bounds that give a file its origin. */
static void test_skins(void **state) {
    UNUSED(state);
    struct {
        float positions[9], weights[12], inverse_bind[32];
        uint8_t joints[12];
    } binary = {.positions = {0, 0, 0, 1, 0, 0, 0, 1, 0}, .weights = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, .joints = {0, 0, 0, 0, 1}};
    for (int i = 0; i < 32; i++) binary.inverse_bind[i] = i % 16 % 5 == 0;
    char json[4000];
    fnl_scene *scene;
    snprintf(json, sizeof json,
             "{" ASSET ",\"buffers\":[{\"byteLength\":%zu}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},{\"buffer\":0,\"byteOffset\":36,\"byteLength\":48},"
             "{\"buffer\":0,\"byteOffset\":84,\"byteLength\":128},{\"buffer\":0,\"byteOffset\":212,\"byteLength\":12}],"
             "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3,\"min\":[0,0,0],\"max\":[1,1,0]},"
             "{\"bufferView\":1,\"componentType\":5126,\"type\":\"VEC4\",\"count\":3},{\"bufferView\":2,\"componentType\":5126,\"type\":\"MAT4\",\"count\":2},"
             "{\"bufferView\":3,\"componentType\":5121,\"type\":\"VEC4\",\"count\":3}],"
             "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"WEIGHTS_0\":1,\"JOINTS_0\":3}}]}],"
             "\"skins\":[{\"joints\":[1,2],\"inverseBindMatrices\":2}],\"scenes\":[{\"nodes\":[0,1,2]}],\"nodes\":[{\"mesh\":0,\"skin\":0},"
             "{\"translation\":[6371000.25,0,0]},{\"translation\":[6371000.5,0,0]}]}",
             sizeof binary);
    if (test_load(&file_log, json, &binary, sizeof binary, &scene) != FNL_OK || file_log.count) fail_msg("%s", file_log.text);
    expect_origin(scene, 6371008, 0, 0);
    assert_int_equal(fnl_scene_remove_instance(scene, (fnl_instance_id){2, scene->nodes.data[2].generation}), FNL_OK);
    for (int i = 0; i < 2; i++) {
        mat4 joints[2];
        skin_matrices(scene, 0, joints);
        const float at = i ? 0 : -8;
        assert_true(joints[0].m[12] == at + 0.25f && joints[1].m[12] == at + 0.5f);
        assert_int_equal(fnl_scene_set_origin(scene, (const double[]){6371000, 0, 0}), FNL_OK);
    }
    fnl_scene_destroy(&scene);
}

/* A camera stays when its node goes, and what the stage knows of the scene moves along. */
static void test_what_stays_when_nodes_go(void **state) {
    UNUSED(state);
    struct world w = make_world();
    fnl_camera camera;
    fnl_entity_info info;
    assert_int_equal(fnl_scene_query_entity(w.scene, FNL_ENTITY_INSTANCE, 2, &info), FNL_OK);
    assert_int_equal(fnl_scene_remove_instance(w.scene, info.id.instance), FNL_OK);
    assert_int_equal(scene_set_stage(w.scene, true, FNL_GROUND_OFF), FNL_OK);
    assert_int_equal(w.scene->stage.light, STAGE_FILL);
    const struct box before = w.scene->stage.bounds;
    move(&w, 64, -32, 16);
    assert_int_equal(fnl_scene_query_camera(w.scene, 0, &camera), FNL_OK);
    assert_true(vec3_distance(camera.position, vec3_make(0.3f - 64, 32, 2.3f - 16)) < 4e-6f);
    assert_true(vec3_distance(w.scene->stage.bounds.low, vec3_add(before.low, vec3_make(-64, 32, -16))) < 1e-5f &&
                vec3_distance(w.scene->stage.bounds.high, vec3_add(before.high, vec3_make(-64, 32, -16))) < 1e-5f);
    fnl_scene_destroy(&w.scene);
}

static void test_misuse(void **state) {
    UNUSED(state);
    fnl_host host = test_host(&file_log);
    fnl_scene *scene;
    double out[3];
    assert_int_equal(fnl_scene_create(&host, &scene), FNL_OK);
    assert_int_equal(fnl_scene_set_origin(scene, (const double[]){0, (double)NAN, 0}), FNL_ERROR_INVALID);
    assert_int_equal(fnl_scene_set_origin(scene, (const double[]){0, 0, 1.1e12}), FNL_ERROR_INVALID);
    assert_non_null(strstr(file_log.text, "origin[2] is 1.1e+12"));
    assert_int_equal(fnl_scene_set_origin(scene, NULL), FNL_ERROR_INVALID);
    assert_int_equal(fnl_scene_query_origin(scene, NULL), FNL_ERROR_INVALID);
    assert_int_equal(fnl_scene_set_origin(scene, (const double[]){1e12, -1e12, 0}), FNL_OK);
    assert_int_equal(fnl_scene_query_origin(scene, out), FNL_OK);
    assert_true(out[0] == 1e12 && out[1] == -1e12 && out[2] == 0);
    fnl_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_nodes_are_composed_in_doubles), cmocka_unit_test(test_who_gets_an_origin),
        cmocka_unit_test(test_origin_moves_and_comes_back),   cmocka_unit_test(test_floats_mean_the_origin_of_their_time),
        cmocka_unit_test(test_both_ends_of_a_planet),         cmocka_unit_test(test_files_into_a_scene),
        cmocka_unit_test(test_animated_far_away),             cmocka_unit_test(test_skins),
        cmocka_unit_test(test_what_stays_when_nodes_go),      cmocka_unit_test(test_misuse),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
