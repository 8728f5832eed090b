/* SPDX-License-Identifier: MIT */
/* Broken files: a clear message each, no crash, no leak, no memory out of proportion. */
#include "scene/gltf_test_file.h"

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
         ",\"extensionsUsed\":[\"KHR_draco_mesh_compression\"],\"extensionsRequired\":[\"KHR_draco_mesh_compression\"]}",
         FNL_ERROR_UNSUPPORTED, "/extensionsRequired/0: the file requires the extension KHR_draco_mesh_compression"},
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
    static const char *const paths[] = {"../shared/scenes/CesiumMan.glb", "../shared/scenes/Fox.glb"};
    for (uint32_t i = 0; i < COUNT_OF(paths); i++) {
        fnl_host host = test_host(&file_log);
        struct file_view file;
        if (access(paths[i], R_OK) != 0) {
            print_message("skipped: there is no %s\n", paths[i]);
            skip();
        }
        assert_int_equal(file_load(&host, paths[i], &file), FNL_OK);
        unsigned char *copy = malloc(file.size);
        memcpy(copy, file.data, file.size);
        fnl_scene *scene;
        for (size_t size = 0; size < file.size; size += 64) { /* as a download that broke off */
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
        for (size_t size = 28 + json_size; size < file.size; size += 64 * 101) {
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
        file_free(&host, &file);
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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_broken_files_are_refused),
        cmocka_unit_test(test_truncated_samples),
        cmocka_unit_test(test_broken_vertices),
        cmocka_unit_test(test_sharing_does_not_multiply),
        cmocka_unit_test(test_node_graphs),
        cmocka_unit_test(test_deep_chain),
        cmocka_unit_test(test_broken_images),
        cmocka_unit_test(test_files_beside_the_scene),
        cmocka_unit_test(test_broken_animation_times),
        cmocka_unit_test(test_memory_runs_out_anywhere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
