/* SPDX-License-Identifier: MIT */
/* Broken files: a clear message each, no crash, no leak, no memory out of proportion. */
#include "tests/gltf_test_file.h"
#include "tests/stand_in.h"

#include <setjmp.h>
#include <unistd.h>

#include <cmocka.h>

#define ASSET "\"asset\":{\"version\":\"2.0\"}"

static struct test_log file_log;

/** Loads what must load, with a message that contains `expected`. */
static fnl_scene *load_with_message(const char *json, const void *binary, size_t size, const char *expected) {
    fnl_scene *scene = NULL;
    if (test_load(&file_log, json, binary, size, &scene) != FNL_OK) fail_msg("not loaded: %s", file_log.text);
    if (!strstr(file_log.text, expected)) fail_msg("no '%s' in:\n%s", expected, file_log.text);
    return scene;
}

/* ---- whole files ---- */

static void test_broken_files_are_refused(void **state) {
    UNUSED(state);
    static const struct {
        const char *text;
        fnl_result result;
        const char *message;
    } cases[] = {
        {"", FNL_ERROR_FORMAT, "file.gltf: /: is not JSON"},
        {"{\n  \"asset\": }", FNL_ERROR_FORMAT, "file.gltf: /: is not JSON: line 2, column 12"},
        {"[]", FNL_ERROR_FORMAT, "file.gltf: /: is not a JSON object"},
        {"{}", FNL_ERROR_FORMAT, "file.gltf: /: has no 'asset'"},
        {"{\"asset\":{\"version\":\"1.0\"}}", FNL_ERROR_UNSUPPORTED, "file.gltf: /asset/version: is 1.0"},
        {"{\"asset\":{\"version\":\"2\"}}", FNL_ERROR_FORMAT, "file.gltf: /asset/version"},
        {"{" ASSET
         ",\"extensionsUsed\":[\"KHR_not_there_at_all\"],\"extensionsRequired\":[\"KHR_not_there_at_all\"]}",
         FNL_ERROR_UNSUPPORTED, "/extensionsRequired/0: the file requires the extension KHR_not_there_at_all"},
#ifndef FANAL_DRACO
        {"{" ASSET ",\"extensionsUsed\":[\"KHR_draco_mesh_compression\"],\"extensionsRequired\":[\"KHR_draco_mesh_compression\"]}",
         FNL_ERROR_UNSUPPORTED, "which is not read: Fanal was built without libdraco (Debian and Ubuntu: libdraco-dev)"},
#endif
        {"{" ASSET ",\"buffers\":[{\"byteLength\":10,\"uri\":\"data:;base64,AAAA\"}]}", FNL_ERROR_FORMAT,
         "/buffers/0: says byteLength 10"},
        {"glTF", FNL_ERROR_FORMAT, "is truncated"},
    };
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        fnl_scene *scene = (fnl_scene *)&file_log;
        fnl_host host = test_host(&file_log);
        assert_int_equal(gltf_load_memory(&host, cases[i].text, strlen(cases[i].text), "file.gltf", NULL, &scene),
                         cases[i].result);
        assert_null(scene);
        if (!strstr(file_log.text, cases[i].message)) fail_msg("no '%s' in:\n%s", cases[i].message, file_log.text);
    }
    fnl_scene *scene;
    fnl_host host = test_host(&file_log);
    assert_int_equal(fnl_scene_load(&host, "/nonexistent/file.glb", NULL, &scene), FNL_ERROR_FILE);
    assert_non_null(strstr(file_log.text, "/nonexistent/file.glb: cannot be opened"));
    assert_null(scene);
}

static void test_truncated_samples(void **state) {
    UNUSED(state);
    static const char *const names[] = {"Fox.glb", "CesiumMan.glb"};
    for (uint32_t i = 0; i < COUNT_OF(names); i++) {
        fnl_host host;
        size_t file_size;
        unsigned char *copy = stand_in_figure(names[i], &file_size);
        fnl_scene *scene;
        for (size_t size = 0; size < file_size; size += 64) { /* as a download that broke off */
            host = test_host(&file_log);
            unsigned char *cut = malloc(size + 1); /* its own block, so that reading on is seen */
            memcpy(cut, copy, size);
            assert_int_equal(gltf_load_memory(&host, cut, size, "cut.glb", NULL, &scene), FNL_ERROR_FORMAT);
            assert_int_equal(file_log.count, 1);
            free(cut);
        }
        /* And with headers that agree with the cut: the BIN chunk is then shorter than its buffer. */
        uint32_t json_size;
        memcpy(&json_size, copy + 12, 4);
        for (size_t size = 28 + json_size; size < file_size; size += 64 * 101) {
            uint32_t total = (uint32_t)size, chunk = (uint32_t)(size - 28 - json_size);
            memcpy(copy + 8, &total, 4);
            host = test_host(&file_log);
            assert_int_equal(gltf_load_memory(&host, copy, size, "cut.glb", NULL, &scene), FNL_ERROR_FORMAT);
            assert_non_null(strstr(file_log.text, "cut.glb: /: GLB chunk 1: has"));
            memcpy(copy + 20 + json_size, &chunk, 4);
            host = test_host(&file_log);
            assert_int_equal(gltf_load_memory(&host, copy, size, "cut.glb", NULL, &scene), FNL_ERROR_FORMAT);
            assert_non_null(strstr(file_log.text, "cut.glb: /buffers/0: says byteLength"));
            chunk = UINT32_MAX;
            memcpy(copy + 20 + json_size, &chunk, 4);
        }
        free(copy);
    }
}

/* ---- vertices ---- */

#define TRIANGLE_VIEWS                                                                                                      \
    "\"buffers\":[{\"byteLength\":72}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":72,\"byteStride\":12}],\"accessors\":" \
    "["                                                                                                                     \
    "{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3},{\"bufferView\":0,\"byteOffset\":36,"          \
    "\"componentType\":5126,\"type\":\"VEC3\",\"count\":3}]"

static void test_broken_vertices(void **state) {
    UNUSED(state);
    float vertices[18] = {0, 0, 0, 1, NAN, 0, 0, 1, 0, 0, 0, 1, 0, INFINITY, 1, 0, 0, 0};
    fnl_scene *scene = load_with_message(
        "{" ASSET "," TRIANGLE_VIEWS ",\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1}}]}]}",
        vertices, sizeof vertices,
        "/meshes/0/primitives/0/attributes/POSITION: 1 element is NaN or infinite, the first at index 1");
    assert_non_null(strstr(file_log.text, "/meshes/0/primitives/0/attributes/NORMAL: 1 element is NaN"));
    const struct scene_primitive *primitive = &scene->primitives.data[0];
    for (uint32_t i = 0; i < 3; i++) {
        assert_true(vec3_finite(primitive->positions[i]));
        assert_true(fabsf(vec3_length(primitive->normals[i]) - 1) < 1e-5f);
    }
    fnl_scene_destroy(&scene);
}

/* A tangent without a length counts as absent: all of the primitive are made by its coordinates. */
static void test_tangents_of_length_0(void **state) {
    UNUSED(state);
    static struct {
        float positions[9], normals[9], tangents[12], uv[6];
    } v = {{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 0, 1, 0, 0, 1, 0, 0, 1}, {0}, {0, 0, 0, -1, 1, 0}};
    static const char json[] =
        "{" ASSET ",\"buffers\":[{\"byteLength\":144}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},{\"buffer\":0,\"byteOffset\":36,\"byteLength\":36},"
        "{\"buffer\":0,\"byteOffset\":72,\"byteLength\":48},{\"buffer\":0,\"byteOffset\":120,\"byteLength\":24}],\"accessors\":["
        "{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3,\"min\":[0,0,0],\"max\":[1,1,0]},{\"bufferView\":1,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3},"
        "{\"bufferView\":2,\"componentType\":5126,\"type\":\"VEC4\",\"count\":3},{\"bufferView\":3,\"componentType\":5126,\"type\":\"VEC2\",\"count\":3}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1,\"TANGENT\":2,\"TEXCOORD_0\":3}}]}]}";
    for (uint32_t i = 0; i < 3; i++) v.tangents[4 * i] = v.tangents[4 * i + 3] = 1;
    fnl_scene *scene = load_with_message(json, &v, sizeof v, "");
    assert_int_equal(file_log.count, 0);
    assert_true(scene->primitives.data[0].tangents[0].x == 1); /* as they are given */
    fnl_scene_destroy(&scene);
    v.tangents[4] = 0;
    scene = load_with_message(json, &v, sizeof v, "/meshes/0/primitives/0/attributes/TANGENT: 1 tangents are of length 0; tangents are made anew");
    assert_int_equal(file_log.count, 1);
    for (uint32_t i = 0; i < 3; i++) assert_true(scene->primitives.data[0].tangents[i].y > 0.999f); /* u grows along y */
    fnl_scene_destroy(&scene);
}

/** Ten thousand primitives of a small file that share one accessor must not become gigabytes. */
static void test_sharing_does_not_multiply(void **state) {
    UNUSED(state);
    const uint32_t vertices = 1 << 16, primitives = 10000;
    char *json = malloc(1024 + primitives * 40), *end = json;
    end += sprintf(end,
                   "{" ASSET
                   ",\"accessors\":[{\"componentType\":5126,\"type\":\"VEC3\",\"count\":%u}],\"meshes\":[{\"primitives\":[",
                   vertices);
    for (uint32_t i = 0; i < primitives; i++) end += sprintf(end, "%s{\"attributes\":{\"POSITION\":0}}", i ? "," : "");
    sprintf(end, "]}]}");
    fnl_scene *scene = load_with_message(json, NULL, 0, "out of all proportion");
    uint64_t total = 0;
    for (uint32_t i = 0; i < scene->primitives.count; i++) total += scene->primitives.data[i].vertex_count;
    assert_true(total > 0 && total < 8 << 20);
    assert_true(scene->messages.count <= 1001);
    fnl_scene_destroy(&scene);
    free(json);
}

/* ---- nodes ---- */

static void test_node_graphs(void **state) {
    UNUSED(state);
    fnl_scene *scene = load_with_message(
        "{" ASSET ",\"nodes\":[{\"children\":[1]},{\"children\":[2]},{\"children\":[0]},{\"children\":[3]}]}", NULL, 0,
        "/nodes/1: is part of a loop of nodes");
    assert_non_null(strstr(file_log.text, "/nodes/3: is part of a loop"));
    fnl_scene_destroy(&scene);
    scene = load_with_message("{" ASSET ",\"nodes\":[{\"children\":[2]},{\"children\":[2]},{}]}", NULL, 0,
                              "/nodes/1/children/0: node 2 is already a child of node 0");
    assert_int_equal(scene->nodes.data[2].parent, 0);
    fnl_scene_destroy(&scene);
}

/** A chain as deep as the number of nodes, children before and after their parents: no recursion on depth. */
static void test_deep_chain(void **state) {
    UNUSED(state);
    const uint32_t count = 300000;
    char *json = malloc(256 + (size_t)count * 64), *end = json;
    end += sprintf(end, "{" ASSET ",\"scenes\":[{\"nodes\":[%u]}],\"nodes\":[{\"translation\":[1,0,0]}", count - 1);
    for (uint32_t i = 1; i < count; i++) end += sprintf(end, ",{\"translation\":[1,0,0],\"children\":[%u]}", i - 1);
    sprintf(end, "]}");
    fnl_scene *scene = NULL;
    assert_int_equal(test_load(&file_log, json, NULL, 0, &scene), FNL_OK);
    assert_int_equal(file_log.count, 0);
    assert_true(scene->nodes.data[0].active && scene->nodes.data[0].world.m[12] == (float)count);
    fnl_scene_destroy(&scene);
    free(json);
    char *deep = malloc(4000001); /* JSON itself may not nest without end either */
    memset(deep, '[', 4000000);
    deep[4000000] = 0;
    assert_int_equal(test_load(&file_log, deep, NULL, 0, &scene), FNL_ERROR_FORMAT);
    free(deep);
}

/* ---- images ---- */

static void test_broken_images(void **state) {
    UNUSED(state);
    /* A PNG header that says 0x0. */
    static const unsigned char png[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n', 0, 0, 0, 13, 'I',
                                        'H',  'D', 'R', 0,   0,    0,    0,    0,    0, 0, 0, 8,  6,
                                        0,    0,   0,   0,   0,    0,    0,    0,    0, 0, 0};
    fnl_scene *scene =
        load_with_message("{" ASSET ",\"buffers\":[{\"byteLength\":37}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":37}],"
                          "\"images\":[{\"bufferView\":0,\"mimeType\":\"image/png\"},{\"uri\":\"http://nowhere/a.png\"}],"
                          "\"textures\":[{\"source\":0},{\"source\":1}],"
                          "\"materials\":[{\"normalTexture\":{\"index\":0}}]}",
                          png, sizeof png, "test.glb: /images/0: ");
    assert_non_null(strstr(file_log.text, "test.glb: /images/1/uri: "));
    assert_int_equal(scene->images.count, 2);
    assert_true(scene->images.data[0].width == 0 && !scene->images.data[0].encoded &&
                scene->materials.data[0].textures[SCENE_TEXTURE_NORMAL].image == 0);
    fnl_scene_destroy(&scene);
}

static void test_files_beside_the_scene(void **state) {
    UNUSED(state);
    char folder[64], path[128], message[256];
    snprintf(folder, sizeof folder, "/tmp/fanal-gltf-test-%d", (int)getpid());
    snprintf(path, sizeof path, "%s a b.bin", folder); /* reached by a percent-encoded name */
    fnl_host host = test_host(&file_log);
    float vertices[18] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 1};
    assert_int_equal(file_save(&host, path, vertices, sizeof vertices), FNL_OK);
    char gltf[128], json[1024];
    snprintf(gltf, sizeof gltf, "%s.gltf", folder);
    snprintf(json, sizeof json,
             "{" ASSET ",\"buffers\":[{\"byteLength\":72,\"uri\":\"fanal-gltf-test-%d%%20a%%20b.bin\"},"
             "{\"byteLength\":4,\"uri\":\"../tmp/fanal-gltf-test-%d a b.bin\"}],"
             "\"bufferViews\":[{\"buffer\":0,\"byteLength\":72,\"byteStride\":12}],\"accessors\":[{\"bufferView\":0,"
             "\"componentType\":5126,\"type\":\"VEC3\",\"count\":3}],"
             "\"images\":[{\"uri\":\"missing.png\"}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],"
             "\"nodes\":[{\"mesh\":0}]}",
             (int)getpid(), (int)getpid());
    assert_int_equal(file_save(&host, gltf, json, strlen(json)), FNL_OK);
    fnl_scene *scene;
    assert_int_equal(fnl_scene_load(&host, gltf, NULL, &scene), FNL_OK);
    assert_int_equal(scene->primitives.count, 1);
    assert_int_equal(scene->files.count, 2); /* the same file by another name is not read again */
    assert_int_equal(file_log.count, 1);
    snprintf(message, sizeof message, "%s: /images/0/uri: /tmp/missing.png: cannot be opened", gltf);
    assert_string_equal(fnl_scene_message(scene, 0)
                            ? strstr(file_log.text, message) == file_log.text ? "as expected" : file_log.text
                            : "none",
                        "as expected");
    fnl_scene_destroy(&scene);
    unlink(path);
    unlink(gltf);
}

/* ---- animations ---- */

static void test_broken_animation_times(void **state) {
    UNUSED(state);
    static const struct {
        float times[3];
        const char *message;
    } cases[] = {
        {{0, 1, 1}, "time 2, 1, is not greater than the one before"},
        {{-1, 0, 1}, "time 0, -1, is negative"},
        {{0, NAN, 1}, "time 1, nan, is not finite"},
    };
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        float binary[12] = {cases[i].times[0], cases[i].times[1], cases[i].times[2]};
        fnl_scene *scene = load_with_message(
            "{" ASSET ",\"buffers\":[{\"byteLength\":48}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":48}],\"accessors\":["
            "{\"bufferView\":0,\"componentType\":5126,\"type\":\"SCALAR\",\"count\":3},"
            "{\"bufferView\":0,\"byteOffset\":12,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3}],\"nodes\":[{}],"
            "\"animations\":[{\"samplers\":[{\"input\":0,\"output\":1}],\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,"
            "\"path\":\"scale\"}}]}]}",
            binary, sizeof binary, cases[i].message);
        assert_non_null(strstr(file_log.text, "/animations/0/samplers/0/input: "));
        assert_int_equal(scene->animations.data[0].channel_count, 0);
        fnl_scene_destroy(&scene);
    }
}

/* Invalid channels are skipped; only the second channel remains. */
static void test_broken_animation_targets(void **state) {
    UNUSED(state);
    static const struct {
        const char *target, *message;
    } cases[] = {
        {"{\"node\":0,\"path\":\"scales\"}", "/animations/0/channels/0/target/path: is unknown; the channel is left out"},
        {"{\"node\":0,\"path\":\"weights\"}", "/animations/0/channels/0/target/path: node 0 has no morph targets; the channel is left out"},
        {"{\"node\":1,\"path\":\"scale\"}", "/animations/0/channels/0/target/path: node 1 has a matrix, which cannot be animated; the channel is left out"},
        {"{\"path\":\"scale\"}", NULL},
    };
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        const float binary[8] = {0, 1, 2, 3, 4, 5, 6, 7};
        char json[2048];
        snprintf(json, sizeof json,
                 "{" ASSET ",\"buffers\":[{\"byteLength\":32}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":32}],\"accessors\":["
                 "{\"bufferView\":0,\"componentType\":5126,\"type\":\"SCALAR\",\"count\":2},{\"bufferView\":0,\"byteOffset\":8,\"componentType\":5126,\"type\":\"VEC3\",\"count\":2}],"
                 "\"nodes\":[{},{\"matrix\":[2,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}],\"animations\":[{\"samplers\":[{\"input\":0,\"output\":1}],\"channels\":["
                 "{\"sampler\":0,\"target\":%s},{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"translation\"}}]}]}",
                 cases[i].target);
        fnl_scene *scene = NULL;
        assert_int_equal(test_load(&file_log, json, binary, sizeof binary, &scene), FNL_OK);
        assert_int_equal(file_log.count, cases[i].message ? 1 : 0);
        if (cases[i].message && !strstr(file_log.text, cases[i].message)) fail_msg("%s", file_log.text);
        assert_int_equal(scene->animations.data[0].channel_count, 1);
        assert_int_equal(fnl_scene_set_time(scene, 0, 1), FNL_OK);
        const struct scene_node *moved = &scene->nodes.data[0], *still = &scene->nodes.data[1];
        assert_true(moved->world.m[12] == 5 && moved->world.m[13] == 6 && moved->world.m[14] == 7 && moved->world.m[0] == 1);
        assert_true(still->world.m[0] == 2 && still->world.m[12] == 0);
        fnl_scene_destroy(&scene);
    }
}

/* ---- memory that runs out ---- */

struct failing {
    uint32_t left;
    uint64_t held;
};

static void *failing_reallocate(void *user, void *old, size_t old_size, size_t new_size) {
    struct failing *failing = user;
    if (new_size == 0) {
        failing->held -= old_size;
        free(old);
        return NULL;
    }
    if (failing->left == 0) return NULL;
    failing->left--;
    failing->held += new_size - old_size;
    return realloc(old, new_size);
}

static void silent(void *user, fnl_log_level level, const char *line) {
    UNUSED(user);
    UNUSED(level);
    UNUSED(line);
}

static void test_memory_runs_out_anywhere(void **state) {
    UNUSED(state);
    float vertices[18] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 1};
    size_t size;
    unsigned char *glb = test_glb(
        "{" ASSET ",\"extensionsUsed\":[\"KHR_lights_punctual\"],\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{"
        "\"type\":\"point\"}]}}," TRIANGLE_VIEWS
        ",\"images\":[{\"uri\":\"data:,\"}],\"textures\":[{\"source\":0}],\"samplers\":[{}],\"materials\":[{"
        "\"normalTexture\":{\"index\":0}}],"
        "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":1,\"znear\":1}}],"
        "\"meshes\":[{\"primitives\":[{\"material\":0,\"attributes\":{\"POSITION\":0}}]}],"
        "\"nodes\":[{\"mesh\":0,\"camera\":0,\"name\":\"n\",\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}}],"
        "\"skins\":[{\"joints\":[0]}],\"animations\":[{\"samplers\":[],\"channels\":[]}]}",
        vertices, sizeof vertices, &size);
    fnl_result result = FNL_ERROR_MEMORY;
    uint32_t limit = 0;
    for (; result != FNL_OK && limit < 10000; limit++) {
        struct failing failing = {.left = limit};
        fnl_host host = {.user = &failing, .reallocate = failing_reallocate, .log = silent};
        fnl_scene *scene;
        result = gltf_load_memory(&host, glb, size, "small.glb", NULL, &scene);
        assert_true(result == FNL_OK || (result == FNL_ERROR_MEMORY && !scene));
        fnl_scene_destroy(&scene);
        assert_int_equal(failing.held, 0);
    }
    print_message("%u allocations\n", limit - 1);
    assert_true(limit > 10 && result == FNL_OK);
    free(glb);
}

/* ---- faults that show in no picture, or only in another file's ---- */

/** Every pointer must be in the log, `count` lines in all. */
static void expect_lines(const char *json, const void *binary, size_t size, uint32_t count, const char *const *lines) {
    fnl_scene *scene = NULL;
    if (test_load(&file_log, json, binary, size, &scene) != FNL_OK) fail_msg("not loaded: %s", file_log.text);
    for (uint32_t i = 0; lines[i]; i++)
        if (!strstr(file_log.text, lines[i])) fail_msg("no '%s' in:\n%s", lines[i], file_log.text);
    if (file_log.count != count) fail_msg("%u lines, not %u:\n%s", file_log.count, count, file_log.text);
    fnl_scene_destroy(&scene);
}

/** Elements beyond 'min' and 'max': every component type, normalised, strided, sparse over bytes and over zeros. */
static void test_declared_bounds_are_compared(void **state) {
    UNUSED(state);
    struct {
        int8_t i8[4];
        uint8_t u8[4];
        int16_t i16[4];
        uint16_t u16[4];
        uint32_t u32[4];
        float f32[4];
        uint8_t sparse_index[4];
        int16_t sparse_value[2];
    } binary = {{-3, 7, 0, 0}, {3, 250, 0, 0}, {-300, 7, 0, 0}, {3, 60000, 0, 0}, {3, 4000000000u, 0, 0}, {-0.3f, 2, 0, 0},
                {1, 3, 0, 0},  {-9, 11}};
    static const struct {
        const char *accessor; /* in view 0, 2 elements; what follows "count" */
        const char *good, *bad;
        uint32_t count; /* of warnings of the bad one */
        const char *lines[3];
    } cases[] = {
        {"\"componentType\":5120,\"byteOffset\":0", "\"min\":[-3],\"max\":[7]", "\"min\":[0],\"max\":[6]", 2,
         {"test.glb: /accessors/0/min/0: is 0, but the elements' is -3", "test.glb: /accessors/0/max/0: is 6, but"}},
        {"\"componentType\":5120,\"byteOffset\":0,\"normalized\":true", "\"min\":[-3],\"max\":[7]", "\"min\":[-3],\"max\":[1]",
         1, {"test.glb: /accessors/0/max/0: is 1, but the elements' is 7"}},
        {"\"componentType\":5121,\"byteOffset\":4", "\"min\":[3],\"max\":[250]", "\"min\":[4],\"max\":[250]", 1,
         {"test.glb: /accessors/0/min/0: is 4, but the elements' is 3"}},
        {"\"componentType\":5122,\"byteOffset\":8", "\"min\":[-300],\"max\":[7]", "\"min\":[-299],\"max\":[7.5]", 2,
         {"test.glb: /accessors/0/min/0", "test.glb: /accessors/0/max/0"}},
        {"\"componentType\":5123,\"byteOffset\":16,\"normalized\":true", "\"min\":[3],\"max\":[60000]",
         "\"min\":[3],\"max\":[0.9]", 1, {"test.glb: /accessors/0/max/0"}},
        {"\"componentType\":5125,\"byteOffset\":24", "\"min\":[3],\"max\":[4000000000]", "\"min\":[3],\"max\":[3999999999]", 1,
         {"test.glb: /accessors/0/max/0: is 3999999999, but the elements' is 4000000000"}},
        {"\"componentType\":5126,\"byteOffset\":40", "\"min\":[-0.3],\"max\":[2.000001]", "\"min\":[-0.2],\"max\":[2.001]", 2,
         {"test.glb: /accessors/0/min/0", "test.glb: /accessors/0/max/0"}},
        {"\"componentType\":5126,\"byteOffset\":40", "\"min\":[-0.3],\"max\":[2]", "\"min\":[-0.3,1],\"max\":[\"2\"]", 2,
         {"test.glb: /accessors/0/min: has 2 numbers for 1 components", "test.glb: /accessors/0/max/0: is not a finite"}},
    };
    for (uint32_t i = 0; i < COUNT_OF(cases); i++)
        for (int bad = 0; bad < 2; bad++) {
            char json[1024];
            snprintf(json, sizeof json,
                     "{" ASSET ",\"buffers\":[{\"byteLength\":64}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":64}],"
                     "\"accessors\":[{\"bufferView\":0,\"type\":\"SCALAR\",\"count\":2,%s,%s}]}",
                     cases[i].accessor, bad ? cases[i].bad : cases[i].good);
            expect_lines(json, &binary, sizeof binary, bad ? cases[i].count : 0,
                         bad ? cases[i].lines : (const char *const[]){NULL});
        }
    /* Elements 1 and 3 of 4 are -9 and 11; the others are those of the view, or 0. */
    static const struct {
        const char *base, *bounds;
        uint32_t count;
        const char *lines[3];
    } sparse[] = {
        {"", "\"min\":[-9],\"max\":[11]", 0, {NULL}},
        {"", "\"min\":[0],\"max\":[12]", 2, {"test.glb: /accessors/0/min/0: is 0, but the elements' is -9", "/accessors/0/max/0"}},
        {"\"bufferView\":0,\"byteOffset\":8,", "\"min\":[-300],\"max\":[11]", 0, {NULL}},
        {"\"bufferView\":0,\"byteOffset\":8,", "\"min\":[-9],\"max\":[11]", 1, {"is -9, but the elements' is -300"}},
        {"\"bufferView\":0,\"byteOffset\":10,\"normalized\":true,", "\"min\":[-9],\"max\":[11]", 0, {NULL}},
        {"\"bufferView\":0,\"byteOffset\":10,\"normalized\":true,", "\"min\":[-8],\"max\":[11]", 1, {"is -8, but the elements' is -9"}},
    };
    for (uint32_t i = 0; i < COUNT_OF(sparse); i++) {
        char json[1024];
        snprintf(json, sizeof json,
                 "{" ASSET ",\"buffers\":[{\"byteLength\":64}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":64}],"
                 "\"accessors\":[{%s\"componentType\":5122,\"type\":\"SCALAR\",\"count\":4,%s,\"sparse\":{\"count\":2,"
                 "\"indices\":{\"bufferView\":0,\"byteOffset\":56,\"componentType\":5121},"
                 "\"values\":{\"bufferView\":0,\"byteOffset\":60}}}]}",
                 sparse[i].base, sparse[i].bounds);
        expect_lines(json, &binary, sizeof binary, sparse[i].count, sparse[i].lines);
    }
    for (int bad = 0; bad < 2; bad++) { /* 3 and 250 among zeros */
        char json[1024];
        snprintf(json, sizeof json,
                 "{" ASSET ",\"buffers\":[{\"byteLength\":64}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":64}],"
                 "\"accessors\":[{\"componentType\":5121,\"type\":\"SCALAR\",\"count\":4,\"min\":[%d],\"sparse\":{\"count\":2,"
                 "\"indices\":{\"bufferView\":0,\"byteOffset\":56,\"componentType\":5121},"
                 "\"values\":{\"bufferView\":0,\"byteOffset\":4}}}]}",
                 bad ? 3 : 0);
        expect_lines(json, &binary, sizeof binary, (uint32_t)bad,
                     (const char *const[]){bad ? "/accessors/0/min/0: is 3, but the elements' is 0" : NULL, NULL});
    }
}

/** Twenty thousand accessors over the same four megabytes are not all read: a count of bytes bounds it. */
static void test_comparing_bounds_takes_time_by_file(void **state) {
    UNUSED(state);
    enum { SIZE = 4 << 20, ACCESSORS = 20000 };
    unsigned char *binary = calloc(1, SIZE);
    char *json = malloc(1024 + ACCESSORS * 128), *end = json;
    end += sprintf(end, "{" ASSET ",\"buffers\":[{\"byteLength\":%d}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":%d}],"
                        "\"accessors\":[", SIZE, SIZE);
    for (uint32_t i = 0; i < ACCESSORS; i++)
        end += sprintf(end, "%s{\"bufferView\":0,\"componentType\":5121,\"type\":\"SCALAR\",\"count\":%d,\"max\":[1]}",
                       i ? "," : "", SIZE);
    sprintf(end, "]}");
    fnl_scene *scene = NULL;
    assert_int_equal(test_load(&file_log, json, binary, SIZE, &scene), FNL_OK);
    assert_int_equal(scene->messages.count, (64 + 4 * 4) / 4); /* each read one is wrong: 64 MiB and 4 times the file */
    fnl_scene_destroy(&scene);
    free(json);
    free(binary);
}

static void test_primitive_restart_is_reported(void **state) {
    UNUSED(state);
    static struct {
        float positions[256 * 3];
        uint8_t indices[4];
    } binary = {.indices = {0, 1, 255, 0}};
    for (int i = 0; i < 768; i++) binary.positions[i] = (float)(i * i % 7);
    for (int bad = 0; bad < 2; bad++) {
        binary.indices[2] = bad ? 255 : 254;
        expect_lines("{" ASSET ",\"buffers\":[{\"byteLength\":3076}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":3072},"
                     "{\"buffer\":0,\"byteOffset\":3072,\"byteLength\":3}],\"accessors\":["
                     "{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":256},"
                     "{\"bufferView\":1,\"componentType\":5121,\"type\":\"SCALAR\",\"count\":3}],"
                     "\"meshes\":[{\"primitives\":[{\"indices\":1,\"attributes\":{\"POSITION\":0}}]}]}",
                     &binary, sizeof binary, (uint32_t)bad,
                     (const char *const[]){
                         bad ? "/meshes/0/primitives/0/indices: 1 indices are 255, the primitive restart value" : NULL, NULL});
    }
}

static void test_inverse_bind_matrices_are_affine(void **state) {
    UNUSED(state);
    for (int bad = 0; bad < 2; bad++) {
        mat4 matrices[2] = {mat4_identity(), mat4_identity()};
        matrices[1].m[12] = 5;
        matrices[1].m[7] = bad ? 0.5f : 0;
        const char *json =
            "{" ASSET ",\"buffers\":[{\"byteLength\":128}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":128}],\"accessors\":["
            "{\"bufferView\":0,\"componentType\":5126,\"type\":\"MAT4\",\"count\":2}],\"nodes\":[{},{}],"
            "\"skins\":[{\"joints\":[0,1],\"inverseBindMatrices\":0}]}";
        fnl_scene *scene = NULL;
        assert_int_equal(test_load(&file_log, json, matrices, sizeof matrices, &scene), FNL_OK);
        assert_int_equal(file_log.count, bad);
        if (bad) assert_non_null(strstr(file_log.text, "/skins/0/inverseBindMatrices: 1 matrices have a fourth row"));
        assert_true(scene->skins.data[0].inverse_bind[1].m[12] == 5 && scene->skins.data[0].inverse_bind[1].m[7] == 0);
        fnl_scene_destroy(&scene);
    }
}

static void test_duplicate_channel_targets(void **state) {
    UNUSED(state);
    /* One key at time 0; translations (1 0 0) and (2 0 0), rotations of length 1 and 2. */
    float binary[16] = {0, 1, 0, 0, 2, 0, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0};
    static const char format[] =
        "{" ASSET ",\"buffers\":[{\"byteLength\":64}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":64}],\"accessors\":["
        "{\"bufferView\":0,\"componentType\":5126,\"type\":\"SCALAR\",\"count\":1},"
        "{\"bufferView\":0,\"byteOffset\":4,\"componentType\":5126,\"type\":\"VEC3\",\"count\":1},"
        "{\"bufferView\":0,\"byteOffset\":16,\"componentType\":5126,\"type\":\"VEC3\",\"count\":1},"
        "{\"bufferView\":0,\"byteOffset\":28,\"componentType\":5126,\"type\":\"VEC4\",\"count\":1},"
        "{\"bufferView\":0,\"byteOffset\":44,\"componentType\":5126,\"type\":\"VEC4\",\"count\":1}],\"nodes\":[{},{}],"
        "\"animations\":[{\"samplers\":[{\"input\":0,\"output\":1},{\"input\":0,\"output\":2},{\"input\":0,\"output\":%d}],"
        "\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"translation\"}},"
        "{\"sampler\":2,\"target\":{\"node\":0,\"path\":\"rotation\"}},"
        "{\"sampler\":1,\"target\":{\"node\":%d,\"path\":\"translation\"}}]},{\"samplers\":[{\"input\":0,\"output\":1}],"
        "\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"translation\"}}]}]}";
    char json[2048];
    snprintf(json, sizeof json, format, 3, 1);
    expect_lines(json, binary, sizeof binary, 0, (const char *const[]){NULL});
    snprintf(json, sizeof json, format, 4, 0);
    expect_lines(json, binary, sizeof binary, 2,
                 (const char *const[]){"test.glb: /animations/0/channels/0/target: channel 2 has the same target",
                                       "test.glb: /animations/0/samplers/2/output: 1 rotations are not of unit length", NULL});
    fnl_scene *scene = NULL; /* what the message says: the later one is played */
    assert_int_equal(test_load(&file_log, json, binary, sizeof binary, &scene), FNL_OK);
    assert_int_equal(fnl_scene_set_time(scene, 0, 0), FNL_OK);
    assert_true(scene->nodes.data[0].translation[0] == 2);
    fnl_scene_destroy(&scene);
}

static void test_media_types_are_compared(void **state) {
    UNUSED(state);
    static const struct {
        const char *json;
        uint32_t count;
        const char *line;
    } cases[] = {
        {"\"images\":[{\"uri\":\"data:image/png;base64," TEST_PNG_BASE64 "\"}]", 0, NULL},
        {"\"images\":[{\"uri\":\"data:image/jpeg;base64," TEST_PNG_BASE64 "\"}]", 1,
         "test.glb: /images/0: its data URI says image/jpeg, but the bytes are image/png"},
        {"\"images\":[{\"mimeType\":\"image/jpeg\",\"uri\":\"data:image/png;base64," TEST_PNG_BASE64 "\"}]", 1,
         "test.glb: /images/0: its mimeType is 'image/jpeg', but the bytes are image/png"},
        {"\"buffers\":[{\"byteLength\":1,\"uri\":\"data:application/octet-stream;base64,AAAA\"}]", 0, NULL},
        {"\"buffers\":[{\"byteLength\":1,\"uri\":\"data:application/gltf-buffer;base64,AAAA\"}]", 0, NULL},
        {"\"buffers\":[{\"byteLength\":1,\"uri\":\"data:image/png;base64,AAAA\"}]", 1,
         "test.glb: /buffers/0/uri: has not the media type"},
    };
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        char json[1024];
        snprintf(json, sizeof json, "{" ASSET ",%s}", cases[i].json);
        expect_lines(json, NULL, 0, cases[i].count, (const char *const[]){cases[i].line, NULL});
    }
}

/* Whatever way RFC 2397 writes them, the same four bytes; what is no data URI is refused. */
static void test_data_uris(void **state) {
    UNUSED(state);
    static const struct {
        const char *uri;
        uint32_t lines;
    } same[] = {
        {"data:application/octet-stream;base64,AQL/%2Bg==", 0}, {"DATA:Application/Octet-Stream;BASE64,AQL%2f%2bg%3d%3D", 0},
        {"data:application/octet-stream;a=b;base64,AQL/%2Bg", 0}, {"data:application/octet-stream,%01%02%ff%FA", 0},
        {"dAtA:application/gltf-buffer;x=y,%01%02%ff%FA", 0},     {"data:,%01%02%ff%FA", 1}, /* its type is text */
        {"data:;base64,AQL/-g", 1},
    };
    for (uint32_t i = 0; i < COUNT_OF(same); i++) {
        char json[512];
        fnl_scene *scene = NULL;
        snprintf(json, sizeof json, "{" ASSET ",\"buffers\":[{\"byteLength\":4,\"uri\":\"%s\"}]}", same[i].uri);
        if (test_load(&file_log, json, NULL, 0, &scene) != FNL_OK) fail_msg("%s: %s", same[i].uri, file_log.text);
        assert_int_equal(file_log.count, same[i].lines);
        assert_memory_equal(scene->document.buffers[0].data, "\x01\x02\xff\xfa", 4);
        fnl_scene_destroy(&scene);
    }
    static const char *const pictures[] = {"data:image/png;base64,", "data:IMAGE/PNG;base64,"};
    for (uint32_t i = 0; i < COUNT_OF(pictures); i++) {
        char json[1024];
        snprintf(json, sizeof json, "{" ASSET ",\"images\":[{\"uri\":\"%s" TEST_PNG_BASE64 "\"}]}", pictures[i]);
        expect_lines(json, NULL, 0, 0, (const char *const[]){NULL, NULL});
    }
}

/* 4.4.3.2 asks for spaces; files of some programs have zeros. More than padding is no JSON. */
static void test_json_padded_with_zeros(void **state) {
    UNUSED(state);
    size_t size;
    unsigned char *glb = test_glb("{" ASSET ",\"nodes\":[{}]}   ", NULL, 0, &size); /* three characters of padding */
    fnl_host host = test_host(&file_log);
    for (size_t zeros = 1; zeros <= 4; zeros++) {
        fnl_scene *scene = NULL;
        glb[size - zeros] = zeros < 4 ? 0 : glb[size - zeros];
        if (zeros == 4) memset(glb + size - 8, 0, 8);
        host = test_host(&file_log);
        assert_int_equal(gltf_load_memory(&host, glb, size, "test.glb", NULL, &scene), zeros < 4 ? FNL_OK : FNL_ERROR_FORMAT);
        if (zeros < 4) assert_non_null(strstr(file_log.text, "test.glb: /: the JSON chunk of the GLB is padded with zeros"));
        if (zeros < 4) assert_int_equal(scene->nodes.count, 1);
        fnl_scene_destroy(&scene);
    }
    free(glb);
}

/* A buffer without 'uri' is a placeholder, and no fault. */
static void test_placeholders_are_silent(void **state) {
    UNUSED(state);
    expect_lines("{" ASSET ",\"buffers\":[{\"byteLength\":4},{\"byteLength\":4}]}", "abc", 4, 0, (const char *const[]){NULL, NULL});
    fnl_scene *scene = NULL;
    fnl_host host = test_host(&file_log);
    static const char text[] = "{" ASSET ",\"buffers\":[{\"byteLength\":4}]}";
    assert_int_equal(gltf_load_memory(&host, text, strlen(text), "test.gltf", NULL, &scene), FNL_OK);
    assert_int_equal(file_log.count, 0);
    fnl_scene_destroy(&scene);
}

/* Rotations of any length turn as that of length 1. */
static void test_rotations_are_normalized(void **state) {
    UNUSED(state);
    static const float lengths[] = {1, 2, 0.5f, 1e-25f, 1e25f};
    for (uint32_t i = 0; i < COUNT_OF(lengths); i++) {
        char json[512];
        snprintf(json, sizeof json, "{" ASSET ",\"nodes\":[{\"rotation\":[0,%.9g,0,%.9g]}]}", (double)(0.6f * lengths[i]), (double)(0.8f * lengths[i]));
        fnl_scene *scene = load_with_message(json, NULL, 0, i ? "/nodes/0/rotation: is not of unit length; it is normalized" : "");
        assert_int_equal(file_log.count, i > 0);
        assert_float_equal((float)scene->nodes.data[0].rotation[1], 0.6f, 1e-6f);
        assert_float_equal((float)scene->nodes.data[0].rotation[3], 0.8f, 1e-6f);
        fnl_scene_destroy(&scene);
    }
    fnl_scene *scene = load_with_message("{" ASSET ",\"nodes\":[{\"rotation\":[0,0,0,0]}]}", NULL, 0, "/nodes/0/rotation: is not of unit length; it is ignored");
    assert_true(scene->nodes.data[0].rotation[3] == 1);
    fnl_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_broken_files_are_refused),
        cmocka_unit_test(test_truncated_samples),
        cmocka_unit_test(test_broken_vertices),
        cmocka_unit_test(test_tangents_of_length_0),
        cmocka_unit_test(test_sharing_does_not_multiply),
        cmocka_unit_test(test_node_graphs),
        cmocka_unit_test(test_deep_chain),
        cmocka_unit_test(test_broken_images),
        cmocka_unit_test(test_files_beside_the_scene),
        cmocka_unit_test(test_broken_animation_times),
        cmocka_unit_test(test_broken_animation_targets),
        cmocka_unit_test(test_memory_runs_out_anywhere),
        cmocka_unit_test(test_declared_bounds_are_compared),
        cmocka_unit_test(test_comparing_bounds_takes_time_by_file),
        cmocka_unit_test(test_primitive_restart_is_reported),
        cmocka_unit_test(test_inverse_bind_matrices_are_affine),
        cmocka_unit_test(test_duplicate_channel_targets),
        cmocka_unit_test(test_media_types_are_compared),
        cmocka_unit_test(test_data_uris),
        cmocka_unit_test(test_json_padded_with_zeros),
        cmocka_unit_test(test_placeholders_are_silent),
        cmocka_unit_test(test_rotations_are_normalized),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
