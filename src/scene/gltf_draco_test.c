/* SPDX-License-Identifier: MIT */
/* KHR_draco_mesh_compression: what libdraco's encoder packed comes out again, and what is broken is named. */
#include "tests/draco_encode.h"
#include "tests/gltf_test_file.h"

#include <setjmp.h>
#include <unistd.h>

#include <cmocka.h>

enum { WIDE = 6, HIGH = 5, POINTS = WIDE * HIGH, FACES = (WIDE - 1) * (HIGH - 1) * 2, ROOM = 1 << 16 };

static struct test_log file_log;

/* A bumpy sheet with every attribute that there is; two sets of joints. */
static struct sheet {
    vec3 positions[POINTS], normals[POINTS];
    vec4 tangents[POINTS], weights[POINTS];
    vec2 uv[POINTS];
    uint16_t uv_more[POINTS][2];
    uint8_t colors[POINTS][4], joints[POINTS][4];
    int8_t extra[POINTS][3];
    uint32_t indices[FACES * 3];
} sheet;

static void make_sheet(void) {
    struct random_state random = {7};
    uint32_t *index = sheet.indices;
    for (uint32_t i = 0; i < POINTS; i++) {
        sheet.positions[i] = vec3_make((float)(i % WIDE), random_range(&random, -0.3f, 0.3f), (float)(i / WIDE));
        sheet.normals[i] = vec3_normalize(vec3_make(random_range(&random, -1, 1), 1, random_range(&random, -1, 1)));
        vec3 along = vec3_normalize(vec3_cross(sheet.normals[i], vec3_make(0, 0, 1)));
        sheet.tangents[i] = (vec4){along.x, along.y, along.z, i % 2 ? 1.0f : -1.0f};
        sheet.uv[i] = (vec2){random_range(&random, -2, 2), random_range(&random, -2, 2)};
        sheet.weights[i] = (vec4){0.5f, 0.25f, 0.25f, 0};
        for (uint32_t k = 0; k < 4; k++) {
            sheet.colors[i][k] = (uint8_t)(i * 8 + k);
            sheet.joints[i][k] = (uint8_t)(k == 3 ? 0 : k);
            sheet.extra[i][k % 3] = (int8_t)(i - 10);
        }
        sheet.uv_more[i][0] = (uint16_t)(i * 2000);
        sheet.uv_more[i][1] = (uint16_t)(65535 - i);
    }
    for (uint32_t y = 0; y + 1 < HIGH; y++)
        for (uint32_t x = 0; x + 1 < WIDE; x++) {
            const uint32_t a = y * WIDE + x, corners[6] = {a, a + WIDE, a + 1, a + 1, a + WIDE, a + WIDE + 1};
            memcpy(index, corners, sizeof corners);
            index += 6;
        }
}

/* Ids in no order: they are names, not places. */
static const struct draco_encode_attribute all[] = {
    {'p', 7, 5126, 3, sheet.positions}, {'n', 3, 5126, 3, sheet.normals},  {'g', 1, 5126, 4, sheet.tangents},
    {'t', 9, 5126, 2, sheet.uv},        {'t', 4, 5123, 2, sheet.uv_more},  {'c', 6, 5121, 4, sheet.colors},
    {'g', 12, 5121, 4, sheet.joints},   {'g', 5, 5126, 4, sheet.weights},  {'g', 40, 5120, 3, sheet.extra},
};

static unsigned char packed[ROOM];

static size_t encode(struct draco_encode_mesh mesh) {
    if (!mesh.attributes) {
        mesh.attributes = all;
        mesh.attribute_count = COUNT_OF(all);
    }
    mesh.indices = sheet.indices;
    mesh.point_count = POINTS;
    size_t size = draco_encode(&mesh, packed, sizeof packed);
    assert_true(size > 0);
    return size;
}

#define HEAD                                                                                                                          \
    "{\"asset\":{\"version\":\"2.0\"},\"extensionsUsed\":[\"KHR_draco_mesh_compression\"],"                                           \
    "\"extensionsRequired\":[\"KHR_draco_mesh_compression\"],\"buffers\":[{\"byteLength\":%zu}],"                                     \
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":%zu}],"
#define COUNTED(count, component, type) "{\"componentType\":" #component ",\"type\":\"" type "\",\"count\":" #count "}"
/* Bounds that the quantised values miss by a little, as files have them. */
#define PLACES "{\"componentType\":5126,\"type\":\"VEC3\",\"count\":30,\"min\":[0,-0.31,0],\"max\":[5,0.31,4]}"
#define NORMALIZED(component, type) "{\"componentType\":" #component ",\"type\":\"" type "\",\"count\":30,\"normalized\":true}"
#define ACCESSORS                                                                                                                     \
    "\"accessors\":[" PLACES "," COUNTED(30, 5126, "VEC3") "," COUNTED(30, 5126, "VEC4") "," COUNTED(30, 5126, "VEC2") ","             \
    NORMALIZED(5123, "VEC2") "," NORMALIZED(5121, "VEC4") "," COUNTED(30, 5121, "VEC4") "," COUNTED(120, 5123, "SCALAR") ","           \
    COUNTED(30, 5120, "VEC3") "," COUNTED(66, 5123, "SCALAR") "]"
#define ATTRIBUTES                                                                                                                    \
    "\"attributes\":{\"POSITION\":0,\"NORMAL\":1,\"TANGENT\":2,\"TEXCOORD_0\":3,\"TEXCOORD_1\":4,\"COLOR_0\":5,\"JOINTS_0\":6,"        \
    "\"WEIGHTS_0\":2,\"_EXTRA\":8}"
#define IDS                                                                                                                           \
    "\"attributes\":{\"POSITION\":7,\"NORMAL\":3,\"TANGENT\":1,\"TEXCOORD_0\":9,\"TEXCOORD_1\":4,\"COLOR_0\":6,\"JOINTS_0\":12,"       \
    "\"WEIGHTS_0\":5,\"_EXTRA\":40}"
#define PACKED(ids) "\"extensions\":{\"KHR_draco_mesh_compression\":{\"bufferView\":0," ids "}}"
#define MESH(primitives) ",\"meshes\":[{\"primitives\":[" primitives "]}]"
#define WHOLE "{\"indices\":7," ATTRIBUTES "," PACKED(IDS) "}"

static fnl_scene *load(const char *json, size_t size) {
    fnl_scene *scene = NULL;
    char text[8192];
    snprintf(text, sizeof text, json, size, size);
    if (test_load(&file_log, text, packed, size, &scene) != FNL_OK) fail_msg("not loaded: %s", file_log.text);
    return scene;
}

static void expect_no_words(void) {
    if (file_log.count) fail_msg("%s", file_log.text);
}

static void expect_words(const char *words) {
    if (!strstr(file_log.text, words)) fail_msg("no '%s' in:\n%s", words, file_log.text);
}

static uint32_t nearest_point(vec3 position) {
    uint32_t best = 0;
    for (uint32_t i = 1; i < POINTS; i++)
        if (vec3_length(vec3_sub(sheet.positions[i], position)) < vec3_length(vec3_sub(sheet.positions[best], position))) best = i;
    return best;
}

/* Every attribute of every point, found by its position; every triangle once, turned as it was. */
static void expect_sheet(const struct scene_primitive *p, float tolerance) {
    bool seen[FACES] = {false};
    assert_int_equal(p->topology, SCENE_TOPOLOGY_TRIANGLES);
    assert_int_equal(p->vertex_count, POINTS);
    assert_int_equal(p->index_count, FACES * 3);
    assert_int_equal(p->joint_count, 4);
    for (uint32_t i = 0; i < POINTS; i++) {
        const uint32_t k = nearest_point(p->positions[i]);
        assert_true(vec3_length(vec3_sub(p->positions[i], sheet.positions[k])) <= tolerance);
        assert_true(vec3_length(vec3_sub(p->normals[i], sheet.normals[k])) < 1e-6f);
        assert_true(fabsf(p->tangents[i].x - sheet.tangents[k].x) < 1e-6f && p->tangents[i].w == sheet.tangents[k].w);
        assert_memory_equal(&p->uv[0][i], &sheet.uv[k], sizeof(vec2));
        assert_float_equal(p->uv[1][i].x, (float)sheet.uv_more[k][0] / 65535, 1e-7f);
        assert_float_equal(p->colors[i].z, (float)sheet.colors[k][2] / 255, 1e-7f);
    }
    for (uint32_t f = 0; f < FACES; f++) {
        uint32_t corners[3], found = FACES;
        for (uint32_t k = 0; k < 3; k++) corners[k] = nearest_point(p->positions[p->indices[f * 3 + k]]);
        for (uint32_t i = 0; i < FACES; i++)
            for (uint32_t turn = 0; turn < 3; turn++) {
                const uint32_t *face = &sheet.indices[i * 3];
                if (face[turn] == corners[0] && face[(turn + 1) % 3] == corners[1] && face[(turn + 2) % 3] == corners[2]) found = i;
            }
        assert_true(found < FACES && !seen[found]);
        seen[found] = true;
    }
}

static void test_draco_every_attribute_MA_9(void **state) {
    UNUSED(state);
    for (uint32_t i = 0; i < 4; i++) {
        const bool sequential = i % 2, metadata = i > 1;
        size_t size = encode((struct draco_encode_mesh){.face_count = FACES, .sequential = sequential, .metadata = metadata});
        fnl_scene *scene = load(HEAD ACCESSORS MESH(WHOLE) "}", size);
        expect_no_words();
        expect_sheet(&scene->primitives.data[0], 0);
        assert_string_equal(scene->extensions.data[0].treatment, "full");
        fnl_scene_destroy(&scene);
    }
    size_t size = encode((struct draco_encode_mesh){.face_count = FACES, .quantization = 12}), exact;
    fnl_scene *scene = load(HEAD ACCESSORS MESH(WHOLE) "}", size);
    expect_no_words();
    expect_sheet(&scene->primitives.data[0], 5.0f / 4095);
    fnl_scene_destroy(&scene);
    exact = encode((struct draco_encode_mesh){.face_count = FACES});
    assert_true(size < exact);
}

/* A skin, so that joints and weights reach the scene by their ids. */
static void test_draco_joints_and_targets_MA_9(void **state) {
    UNUSED(state);
    size_t size = encode((struct draco_encode_mesh){.face_count = FACES, .sequential = true});
    fnl_scene *scene = load(HEAD ACCESSORS ",\"meshes\":[{\"primitives\":[{\"indices\":7," ATTRIBUTES "," PACKED(IDS)
                                 ",\"targets\":[{\"POSITION\":1}]}]}],\"nodes\":[{\"mesh\":0,\"skin\":0},{},{},{}],\"skins\":[{\"joints\":[1,2,3]}]}",
                            size);
    const struct scene_primitive *p = &scene->primitives.data[0];
    for (uint32_t i = 0; i < POINTS; i++) {
        assert_int_equal(p->joints[i * 4 + 1], 1);
        assert_float_equal(p->weights[i * 4], 0.5f, 1e-6f);
    }
    assert_int_equal(p->morph_target_count, 1); /* whose accessor is a compressed one: no plain data */
    expect_words("/meshes/0/primitives/0/targets/0/POSITION: accessor 1 is broken");
    fnl_scene_destroy(&scene);
}

static void test_draco_strip_no_indices_shared_MA_9(void **state) {
    UNUSED(state);
    size_t size = encode((struct draco_encode_mesh){.face_count = FACES});
    static const char *const files[] = {
        HEAD ACCESSORS MESH("{\"mode\":5,\"indices\":9," ATTRIBUTES "," PACKED(IDS) "}") "}",
        HEAD ACCESSORS MESH("{" ATTRIBUTES "," PACKED(IDS) "}") "}",
        HEAD ACCESSORS MESH(WHOLE "," WHOLE) "}",
    };
    for (uint32_t i = 0; i < COUNT_OF(files); i++) {
        fnl_scene *scene = load(files[i], size);
        expect_no_words();
        for (uint32_t k = 0; k < scene->primitives.count; k++) expect_sheet(&scene->primitives.data[k], 0);
        if (i == 2) assert_ptr_equal(scene->primitives.data[0].positions, scene->primitives.data[1].positions); /* decoded once */
        fnl_scene_destroy(&scene);
    }
}

/* What is saved stays compressed: its accessors are those of the file. */
static void test_draco_is_saved(void **state) {
    UNUSED(state);
    static const char *const files[] = {
        HEAD ACCESSORS MESH(WHOLE "," WHOLE) ",\"nodes\":[{\"mesh\":0}]}",
        HEAD ACCESSORS MESH("{\"mode\":5,\"indices\":9," ATTRIBUTES "," PACKED(IDS) "}") ",\"nodes\":[{\"mesh\":0}]}",
    };
    size_t size = encode((struct draco_encode_mesh){.face_count = FACES});
    char path[] = "/tmp/fanal-draco-XXXXXX.glb";
    const int file = mkstemps(path, 4);
    assert_true(file >= 0);
    close(file);
    for (uint32_t i = 0; i < COUNT_OF(files); i++) {
        fnl_scene *scene = load(files[i], size), *again = NULL;
        assert_int_equal(fnl_scene_set_ambient(scene, vec3_make(1, 1, 1), vec3_make(1, 1, 1)), FNL_OK);
        assert_int_equal(fnl_scene_save(scene, path, NULL), FNL_OK);
        fnl_host host = test_host(&file_log);
        assert_int_equal(fnl_scene_load(&host, path, NULL, &again), FNL_OK);
        expect_no_words();
        assert_int_equal(again->primitives.count, scene->primitives.count);
        for (uint32_t k = 0; k < again->primitives.count; k++) expect_sheet(&again->primitives.data[k], 0);
        fnl_scene_destroy(&scene);
        fnl_scene_destroy(&again);
    }
    unlink(path);
}

/* Where plain data stands beside the compressed, it is used if the other is broken. */
static void test_draco_fallback_MA_9(void **state) {
    UNUSED(state);
    size_t size = encode((struct draco_encode_mesh){.face_count = FACES});
    static const char json[] = HEAD
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":30}," COUNTED(120, 5123, "SCALAR") "]"
        MESH("{\"attributes\":{\"POSITION\":0}," PACKED("\"attributes\":{\"POSITION\":%u}") "}") "}";
    for (uint32_t id = 7; id < 9; id++) {
        char text[4096];
        fnl_scene *scene = NULL;
        snprintf(text, sizeof text, json, size, size, id);
        assert_int_equal(test_load(&file_log, text, packed, size, &scene), FNL_OK);
        if (id == 7) {
            expect_no_words();
            assert_int_equal(scene->primitives.data[0].index_count, FACES * 3);
        } else {
            expect_words("/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression: the primitive's plain data is used");
            assert_int_equal(scene->primitives.data[0].index_count, POINTS);
        }
        fnl_scene_destroy(&scene);
    }
}

static void test_draco_disagreement_MA_9(void **state) {
    UNUSED(state);
#define ONLY(accessors, primitive) HEAD "\"accessors\":[" accessors "]" MESH(primitive) "}"
#define POSITION(id) PACKED("\"attributes\":{\"POSITION\":" #id "}")
#define AT "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression"
    static const struct {
        const char *json, *words;
    } cases[] = {
        {ONLY(COUNTED(29, 5126, "VEC3"), "{\"attributes\":{\"POSITION\":0}," POSITION(7) "}"),
         AT "/attributes/POSITION: accessor 0 has 29 elements, but the compressed mesh has 30 points"},
        {ONLY(COUNTED(30, 5126, "VEC4"), "{\"attributes\":{\"POSITION\":0}," POSITION(7) "}"),
         AT "/attributes/POSITION: accessor 0 has 4 components, but the compressed attribute has 3"},
        {ONLY(COUNTED(30, 5123, "VEC3"), "{\"attributes\":{\"POSITION\":0}," POSITION(7) "}"),
         AT "/attributes/POSITION: the compressed values are not what accessor 0 has, VEC3 of UNSIGNED_SHORT"},
        {ONLY(COUNTED(30, 5121, "VEC3"), "{\"attributes\":{\"POSITION\":0}," POSITION(40) "}"),
         AT "/attributes/POSITION: the compressed values are not what accessor 0 has"}, /* -10 is no unsigned byte */
        {ONLY(COUNTED(30, 5126, "VEC3"), "{\"attributes\":{\"POSITION\":0}," POSITION(8) "}"),
         AT "/attributes/POSITION: the compressed mesh has no attribute of this id"},
        {ONLY(COUNTED(30, 5126, "VEC3") "," COUNTED(117, 5123, "SCALAR"), "{\"indices\":1,\"attributes\":{\"POSITION\":0}," POSITION(7) "}"),
         "/meshes/0/primitives/0/indices: accessor 1 has 117 indices, but the compressed mesh has 120"},
        {ONLY(COUNTED(30, 5126, "VEC3"), "{\"mode\":1,\"attributes\":{\"POSITION\":0}," POSITION(7) "}"),
         "/meshes/0/primitives/0/mode: only triangles and triangle strips can be compressed"},
        {ONLY(COUNTED(30, 5126, "VEC3"), "{\"attributes\":{}," POSITION(7) "}"),
         AT "/attributes/POSITION: the primitive itself has no such attribute; it is ignored"},
    };
    size_t size = encode((struct draco_encode_mesh){.face_count = FACES});
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        fnl_scene *scene = load(cases[i].json, size);
        expect_words(cases[i].words);
        assert_int_equal(scene->primitives.count, 0);
        fnl_scene_destroy(&scene);
    }
}

static void expect_broken(size_t size, const char *words) {
    fnl_scene *scene = load(HEAD ACCESSORS MESH(WHOLE) "}", size);
    expect_words(AT);
    expect_words(words);
    expect_words("the primitive has no other data");
    assert_int_equal(scene->primitives.count, 0);
    fnl_scene_destroy(&scene);
}

static void test_draco_broken_MA_9(void **state) {
    UNUSED(state);
    size_t size = encode((struct draco_encode_mesh){.face_count = FACES, .metadata = true});
    for (size_t cut = 1; cut < size; cut += 41) expect_broken(cut, cut < 11 ? "does not begin with DRACO" : "");
    packed[6] = 1;
    expect_broken(size, "is not of version 2.2");
    packed[6] = 2;
    packed[8] = 9;
    expect_broken(size, "has an unknown encoding");
    struct random_state random = {11};
    for (uint32_t i = 0; i < 200; i++) { /* whatever comes out, it is a scene */
        size = encode((struct draco_encode_mesh){.face_count = FACES, .sequential = i % 2});
        for (uint32_t k = 0; k < 3; k++) packed[11 + random_bits(&random) % (size - 11)] ^= (unsigned char)(1u << random_bits(&random) % 8);
        fnl_scene *scene = load(HEAD ACCESSORS MESH(WHOLE) "}", size);
        for (uint32_t k = 0; k < scene->primitives.count; k++)
            for (uint32_t c = 0; c < scene->primitives.data[k].index_count; c++)
                assert_true(scene->primitives.data[k].indices[c] < scene->primitives.data[k].vertex_count);
        fnl_scene_destroy(&scene);
    }
    const struct draco_encode_mesh points = {.attributes = all, .attribute_count = 1, .sequential = true};
    expect_broken(encode(points), "is a point cloud");
    /* 300 million triangles in no bytes: refused before anything is allocated for them. */
    static const unsigned char many[] = {'D', 'R', 'A', 'C', 'O', 2, 2, 1, 0, 0, 0, 0x80, 0xc6, 0x86, 0x8f, 0x01, 3, 0, 0, 0, 0, 0};
    memcpy(packed, many, sizeof many);
    expect_broken(sizeof many, "cannot hold 300000000 triangles");
    /* The same behind metadata: none of attributes, one entry "a" of one byte, one element below with none. */
    static const unsigned char behind[] = {'D', 'R', 'A', 'C', 'O', 2, 2, 1, 0, 0, 0x80, 0, 1, 1, 'a', 1, 5, 1, 1, 'b', 0, 0, 0x80, 0xc6, 0x86, 0x8f, 0x01, 3};
    memcpy(packed, behind, sizeof behind);
    expect_broken(sizeof behind, "cannot hold 300000000 triangles");
}

int main(void) {
    make_sheet();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_draco_every_attribute_MA_9),       cmocka_unit_test(test_draco_joints_and_targets_MA_9),
        cmocka_unit_test(test_draco_strip_no_indices_shared_MA_9), cmocka_unit_test(test_draco_fallback_MA_9),
        cmocka_unit_test(test_draco_is_saved),
        cmocka_unit_test(test_draco_disagreement_MA_9),          cmocka_unit_test(test_draco_broken_MA_9),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
