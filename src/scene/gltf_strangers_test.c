/* SPDX-License-Identifier: MIT */
/* Files from strangers: what they may require, which other files they may read, how much memory they may take; and resolvers. */
#include "tests/gltf_test_file.h"
#include "tests/test_meter.h"

#include <meshoptimizer.h>
#include <setjmp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#define ASSET "\"asset\":{\"version\":\"2.0\"}"

/* From memory, with the other params. */
static fnl_result load_memory(const fnl_host *host, const void *data, size_t size, const char *name, const fnl_load_params *params,
                              fnl_scene **out) {
    fnl_load_params all = params ? *params : fnl_load_params_default();
    all.data = data;
    all.size = size;
    return fnl_scene_load(host, name, &all, out);
}

static struct test_log file_log;

static void expect_text(const char *expected) {
    if (!strstr(file_log.text, expected)) fail_msg("no '%s' in:\n%s", expected, file_log.text);
}

/* ---- what files require ---- */

static void test_required_extensions_must_be_shown(void **state) {
    UNUSED(state);
    static const struct {
        const char *name;
        bool shown, lenient; /* in full; by its core properties */
    } cases[] = {
        {"KHR_lights_punctual", true, true},
        {"KHR_texture_transform", true, true},
        {"KHR_materials_pbrSpecularGlossiness", false, true},
        {"KHR_materials_variants", true, true},
        {"KHR_animation_pointer", true, true},
        {"KHR_not_there_at_all", false, false},
        {"VENDOR_unheard_of", false, false},
    };
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        char json[512];
        fnl_scene *scene = NULL;
        fnl_load_params params = fnl_load_params_default();
        snprintf(json, sizeof json, "{" ASSET ",\"extensionsUsed\":[\"%s\"],\"extensionsRequired\":[\"%s\"]}", cases[i].name,
                 cases[i].name);
        fnl_result result = test_load_with(&file_log, &params, json, NULL, 0, &scene);
        assert_int_equal(result, cases[i].shown ? FNL_OK : FNL_ERROR_UNSUPPORTED);
        if (!cases[i].shown) expect_text("test.glb: /extensionsRequired/0: the file requires the extension");
        fnl_scene_destroy(&scene);
        params.lenient = true;
        result = test_load_with(&file_log, &params, json, NULL, 0, &scene);
        assert_int_equal(result, cases[i].lenient ? FNL_OK : FNL_ERROR_UNSUPPORTED);
        if (cases[i].lenient && !cases[i].shown) expect_text("test.glb: /extensionsUsed/0: ");
        fnl_scene_destroy(&scene);
        /* What is only used is a warning as ever. */
        snprintf(json, sizeof json, "{" ASSET ",\"extensionsUsed\":[\"%s\"]}", cases[i].name);
        assert_int_equal(test_load(&file_log, json, NULL, 0, &scene), FNL_OK);
        assert_int_equal(file_log.count, cases[i].shown ? 0 : 1);
        fnl_scene_destroy(&scene);
    }
    /* One that stands behind many others is not overlooked. */
    char *json = malloc(1 << 16), *end = json;
    end += sprintf(end, "{" ASSET ",\"extensionsRequired\":[");
    for (int i = 0; i < 300; i++) end += sprintf(end, "\"KHR_texture_transform\",");
    sprintf(end, "\"VENDOR_unheard_of\"]}");
    fnl_scene *scene = NULL;
    assert_int_equal(test_load(&file_log, json, NULL, 0, &scene), FNL_ERROR_UNSUPPORTED);
    free(json);
}

/* ---- folders ---- */

/** A folder "scene" with what files may read, and around it what they may not. */
struct place {
    char root[64], scene[96];
};

static void save(const struct place *place, const char *name, const void *data, size_t size) {
    char path[256];
    fnl_host host = test_host(&file_log);
    snprintf(path, sizeof path, "%s/%s", place->root, name);
    assert_int_equal(file_save(&host, path, data, size), FNL_OK);
}

static void make_place(struct place *place) {
    strcpy(place->root, "/tmp/fanal-strangers-XXXXXX");
    assert_non_null(mkdtemp(place->root));
    static const char *const folders[] = {"scene", "scene/textures", "scene-2"};
    char path[256];
    for (uint32_t i = 0; i < COUNT_OF(folders); i++) {
        snprintf(path, sizeof path, "%s/%s", place->root, folders[i]);
        assert_int_equal(mkdir(path, 0700), 0);
    }
    static const char *const files[] = {"secret.png", "scene-2/secret.png", "scene/in.png", "scene/textures/in.png",
                                        "scene/a b.png"};
    for (uint32_t i = 0; i < COUNT_OF(files); i++) save(place, files[i], test_png, sizeof test_png);
    snprintf(place->scene, sizeof place->scene, "%s/scene", place->root);
    assert_int_equal(chdir(place->scene), 0);
    assert_int_equal(symlink("../secret.png", "link.png") | symlink("..", "up") | symlink("in.png", "alias.png") |
                         symlink("textures", "alias"),
                     0);
    assert_int_equal(mkfifo("pipe.png", 0600), 0);
}

static void remove_place(const struct place *place) {
    char command[128];
    assert_int_equal(chdir("/"), 0);
    snprintf(command, sizeof command, "rm -r '%s'", place->root);
    assert_int_equal(system(command), 0);
}

/** Loads scene/test.gltf with one image, or one buffer, of a URI; by its absolute path or as "test.gltf". */
static fnl_result load_uri(const struct place *place, const char *uri, bool buffer, bool absolute,
                           const fnl_load_params *params, fnl_scene **out) {
    char json[1024], path[128];
    snprintf(json, sizeof json,
             buffer ? "{" ASSET ",\"buffers\":[{\"byteLength\":1,\"uri\":\"%s\"}]}"
                    : "{" ASSET ",\"images\":[{\"uri\":\"%s\"}]}",
             uri);
    save(place, "scene/test.gltf", json, strlen(json));
    fnl_host host = test_host(&file_log);
    snprintf(path, sizeof path, "%s/test.gltf", place->scene);
    fnl_result result = fnl_scene_load(&host, absolute ? path : "test.gltf", params, out);
    return result;
}

/** Whether the picture was read. */
static bool has_picture(const fnl_scene *scene) { return scene->images.data[0].width == 1; }

/** However it is written, an absolute path is refused, in a file that is itself named by a relative path too. */
static void test_absolute_paths_are_refused(void **state) {
    UNUSED(state);
    struct place place;
    make_place(&place);
    static const char *const formats[] = {"%s/secret.png",           "/%s/scene/in.png",        "%%2f%s/secret.png",
                                          "file://%s/secret.png",    "FILE:%s/secret.png",      "file:in.png",
                                          "%%66ile://%s/secret.png", "file%%3A//%s/secret.png", "%%2Fetc/passwd"};
    for (uint32_t i = 0; i < COUNT_OF(formats); i++)
        for (int buffer = 0; buffer < 2; buffer++)
            for (int absolute = 0; absolute < 2; absolute++) {
                char uri[256];
                fnl_scene *scene = NULL;
                snprintf(uri, sizeof uri, formats[i], place.root);
                assert_int_equal(load_uri(&place, uri, buffer, absolute, NULL, &scene), FNL_ERROR_FILE);
                assert_null(scene);
                assert_int_equal(file_log.count, 1);
                expect_text(buffer ? "test.gltf: /buffers/0/uri: '" : "test.gltf: /images/0/uri: '");
                expect_text("is an absolute path");
                /* Lenient loading goes on, without reading it. */
                fnl_load_params params = fnl_load_params_default();
                params.lenient = true;
                assert_int_equal(load_uri(&place, uri, buffer, absolute, &params, &scene), FNL_OK);
                expect_text("is an absolute path");
                assert_true(buffer ? scene->files.count == 1 : !has_picture(scene));
                fnl_scene_destroy(&scene);
            }
    remove_place(&place);
}

static void test_the_folder_is_what_links_lead_to(void **state) {
    UNUSED(state);
    struct place place;
    make_place(&place);
    static const struct {
        const char *uri;
        bool outside;
    } cases[] = {
        {"in.png", false},
        {"./in.png", false},
        {"textures/in.png", false},
        {"textures/../in.png", false},
        {"nowhere/../in.png", false}, /* RFC 3986, 5.2.4: dot segments are removed before anything is opened */
        {"nowhere/else/../../in.png", false},
        {"nowhere%2F%2e%2E/./textures/in.png", false},
        {"nowhere/..//in.png", false},
        {"nowhere/../../secret.png", true},
        {"../nowhere/../secret.png", true},
        {"../scene/in.png", false},
        {"a%20b.png", false},
        {"alias.png", false},
        {"alias/in.png", false},
        {"up/scene/in.png", false},
        {"../secret.png", true},
        {"textures/../../secret.png", true},
        {"%2e%2e/secret.png", true},
        {"..%2Fsecret.png", true},
        {"%2E%2E%2fsecret.png", true},
        {"../scene-2/secret.png", true}, /* its name begins like the folder's */
        {"link.png", true},
        {"up/secret.png", true},
        {"alias/../../secret.png", true},
    };
    for (uint32_t i = 0; i < COUNT_OF(cases); i++)
        for (int way = 0; way < 4; way++) {
            bool absolute = way & 1;
            fnl_load_params params = fnl_load_params_default();
            params.confine = way & 2;
            fnl_scene *scene = NULL;
            fnl_result result = load_uri(&place, cases[i].uri, false, absolute, &params, &scene);
            if (cases[i].outside && params.confine) {
                assert_int_equal(result, FNL_ERROR_FILE);
                assert_null(scene);
                expect_text("test.gltf: /images/0/uri: '");
                expect_text("is outside of the file's folder, to which");
                params.lenient = true;
                assert_int_equal(load_uri(&place, cases[i].uri, false, absolute, &params, &scene), FNL_OK);
                assert_false(has_picture(scene));
            } else {
                assert_int_equal(result, FNL_OK);
                if (!has_picture(scene)) fail_msg("%s was not read: %s", cases[i].uri, file_log.text);
                if (file_log.count != cases[i].outside) fail_msg("%s: %s", cases[i].uri, file_log.text);
                if (cases[i].outside) expect_text("is outside of the file's folder; it is read all the same");
            }
            fnl_scene_destroy(&scene);
        }
    fnl_scene *scene = NULL;
    assert_int_equal(load_uri(&place, "pipe.png", false, true, NULL, &scene), FNL_OK);
    expect_text("/images/0/uri: ");
    expect_text("is a pipe, not a regular file");
    fnl_scene_destroy(&scene);
    remove_place(&place);
}

/** What would be an empty picture is an error: a buffer whose bytes nobody has. A picture that is missing is a warning. */
static void test_missing_data_is_an_error(void **state) {
    UNUSED(state);
    struct place place;
    make_place(&place);
    static const char *const uris[] = {
        "missing.bin", "http://example.com/a.bin", "a%00b", "data:AAAA", "data:,%%4", "data:;base64,AA%%3", "data:application/octet-stream;base64,A!",
        "textures"};
    for (uint32_t i = 0; i < COUNT_OF(uris); i++) {
        fnl_scene *scene = NULL;
        fnl_load_params params = fnl_load_params_default();
        fnl_result result = load_uri(&place, uris[i], true, true, NULL, &scene);
        assert_int_equal(result, strncmp(uris[i], "data:", 5) == 0 ? FNL_ERROR_FORMAT : FNL_ERROR_FILE);
        expect_text("test.gltf: /buffers/0/uri: ");
        expect_text("the file is not loaded");
        params.lenient = true;
        assert_int_equal(load_uri(&place, uris[i], true, true, &params, &scene), FNL_OK);
        expect_text("test.gltf: /buffers/0/uri: ");
        fnl_scene_destroy(&scene);
        assert_int_equal(load_uri(&place, uris[i], false, true, NULL, &scene), FNL_OK);
        assert_false(has_picture(scene));
        expect_text("test.gltf: /images/0");
        fnl_scene_destroy(&scene);
    }
    remove_place(&place);
    fnl_scene *scene = NULL;
    assert_int_equal(test_load(&file_log, "{" ASSET ",\"buffers\":[{\"byteLength\":4}]}", NULL, 0, &scene),
                     FNL_ERROR_FORMAT);
    expect_text("test.glb: /buffers/0: has no 'uri', and the GLB has no BIN chunk");
    /* A placeholder may stand there, but nothing can be drawn from it. */
#define PLACEHOLDER                                                                                                         \
    ",\"buffers\":[{\"byteLength\":4},{\"byteLength\":36}],\"bufferViews\":[{\"buffer\":1,\"byteLength\":36}],"             \
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3}]"
    assert_int_equal(test_load(&file_log, "{" ASSET PLACEHOLDER "}", "abc", 4, &scene), FNL_OK);
    fnl_scene_destroy(&scene);
    assert_int_equal(test_load(&file_log,
                               "{" ASSET PLACEHOLDER ",\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]}",
                               "abc", 4, &scene),
                     FNL_ERROR_FILE);
    expect_text("/meshes/0/primitives/0/attributes/POSITION: the data of accessor 0 is missing");
    /* The fallback of a compressed buffer is for others: it may be missing. */
    assert_int_equal(test_load(&file_log,
                               "{" ASSET
                               ",\"extensionsUsed\":[\"EXT_meshopt_compression\"],\"buffers\":[{\"byteLength\":4,\"uri\":"
                               "\"missing.bin\",\"extensions\":{\"EXT_meshopt_compression\":{\"fallback\":true}}}]}",
                               NULL, 0, &scene),
                     FNL_OK);
    assert_int_equal(file_log.count, 0);
    fnl_scene_destroy(&scene);
}

/* ---- memory ---- */

/** A small document that names a file of 4 GiB, which the disk holds as a hole: refused before it is read. */
static void test_files_count_against_the_limit(void **state) {
    UNUSED(state);
    struct place place;
    make_place(&place);
    save(&place, "scene/hole.bin", "", 0);
    assert_int_equal(truncate("hole.bin", (off_t)4 << 30), 0);
    fnl_load_params params = fnl_load_params_default();
    params.max_memory = 1 << 20;
    for (int lenient = 0; lenient < 2; lenient++) {
        fnl_scene *scene = NULL;
        params.lenient = lenient;
        assert_int_equal(load_uri(&place, "hole.bin", true, false, &params, &scene), FNL_ERROR_MEMORY);
        assert_null(scene);
    }
    fnl_scene *scene;
    params.lenient = false;
    assert_int_equal(load_uri(&place, "in.png", false, false, &params, &scene), FNL_OK);
    fnl_scene_destroy(&scene);
    remove_place(&place);
}

static void collect(void *user, fnl_log_level level, const char *line) {
    UNUSED(user);
    test_log_line(&file_log, level, line);
}

/** Loads a GLB with a limit; `peak` gets the most memory that was held at once. */
static fnl_result load_limited(const char *json, const void *binary, size_t size, uint64_t limit, uint64_t *peak) {
    struct test_meter meter = {0};
    size_t glb_size;
    unsigned char *glb = test_glb(json, binary, size, &glb_size);
    test_host(&file_log);
    fnl_host host = {.user = &meter, .reallocate = test_meter_reallocate, .log = collect};
    fnl_load_params params = fnl_load_params_default();
    params.max_memory = limit;
    fnl_scene *scene = NULL;
    fnl_result result = load_memory(&host, glb, glb_size, "test.glb", &params, &scene);
    *peak = meter.peak;
    assert_true((result == FNL_OK) == (scene != NULL));
    fnl_scene_destroy(&scene);
    assert_int_equal(meter.held, 0);
    free(glb);
    return result;
}

#define POSITIONS(count) "{\"componentType\":5126,\"type\":\"VEC3\",\"count\":" #count "}"
#define SPARSE(count)                                                                                                       \
    "{\"componentType\":5126,\"type\":\"VEC3\",\"count\":" #count                                                           \
    ",\"sparse\":{\"count\":1,\"indices\":{\"bufferView\":0,\"componentType\":5125},\"values\":{\"bufferView\":0}}}"
#define BUFFER ",\"buffers\":[{\"byteLength\":64}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":64}]"
#define MESH(attributes) ",\"meshes\":[{\"primitives\":[{\"attributes\":{" attributes "}}]}]"

/** Small files that ask for much: refused at the place that asks, before the memory is taken. */
static void test_memory_is_counted_before_it_is_taken(void **state) {
    UNUSED(state);
    static const struct {
        const char *json, *place;
        uint64_t least; /* bytes that it needs without doubt */
    } cases[] = {
        {",\"accessors\":[" POSITIONS(1200000) "]" MESH("\"POSITION\":0"), "/meshes/0/primitives/0", 14400000},
        {BUFFER ",\"accessors\":[" SPARSE(1200000) "]" MESH("\"POSITION\":0"), "/meshes/0/primitives/0", 14400000},
        {",\"accessors\":[" POSITIONS(300000) "]" MESH("\"POSITION\":0"), "/meshes/0/primitives/0", 3600000 + 300000 * 28},
        {",\"accessors\":[" POSITIONS(3) ",{\"componentType\":5125,\"type\":\"SCALAR\",\"count\":1200000}],"
                                         "\"meshes\":[{\"primitives\":[{\"indices\":1,\"attributes\":{\"POSITION\":0}}]}]",
         "/meshes/0/primitives/0/indices", 4800000},
        {",\"accessors\":[" POSITIONS(
             1200000) ",{\"componentType\":5125,\"type\":\"SCALAR\",\"count\":3}],"
                      "\"meshes\":[{\"primitives\":[{\"indices\":1,\"attributes\":{\"POSITION\":0}}]}]",
         "/meshes/0/primitives/0", 9600000},
        {",\"accessors\":[{\"componentType\":5126,\"type\":\"SCALAR\",\"count\":1200000}],\"nodes\":[{}],"
         "\"animations\":[{\"samplers\":[{\"input\":0,\"output\":0}],\"channels\":[{\"sampler\":0,\"target\":{\"path\":"
         "\"scale\"}}]}]",
         "/animations/0/samplers/0/input", 4800000},
        {",\"extensionsUsed\":[\"EXT_mesh_gpu_instancing\"],\"accessors\":[" POSITIONS(3) "," POSITIONS(500000) "]" MESH(
             "\"POSITION\":0") ",\"nodes\":[{\"mesh\":0,\"extensions\":{\"EXT_mesh_gpu_instancing\":{\"attributes\":{"
                               "\"TRANSLATION\":1}}}}]",
         "/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes/TRANSLATION", 500000 * 76},
    };
    unsigned char binary[64] = {0};
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        char json[1024];
        uint64_t peak, limit = 2 << 20;
        snprintf(json, sizeof json, "{" ASSET "%s}", cases[i].json);
        const void *chunk = strstr(json, "\"buffers\"") ? binary : NULL;
        assert_int_equal(load_limited(json, chunk, sizeof binary, limit, &peak), FNL_ERROR_MEMORY);
        char place[128];
        snprintf(place, sizeof place, "test.glb: %s", cases[i].place);
        expect_text(place);
        expect_text("bytes of memory; of the limit of 2097152 there are");
        if (file_log.count != 1) fail_msg("case %u: %s", i, file_log.text);
        if (peak > limit + (1 << 20)) fail_msg("case %u held %llu bytes", i, (unsigned long long)peak);
        assert_int_equal(load_limited(json, chunk, sizeof binary, cases[i].least - 1, &peak), FNL_ERROR_MEMORY);
        assert_int_equal(load_limited(json, chunk, sizeof binary, UINT64_MAX, &peak), FNL_OK);
        assert_true(peak >= cases[i].least / 2); /* it was no empty threat */
        /* What the count allows is enough: nothing is held beyond it, but for small change. */
        uint64_t low = cases[i].least - 1, high = peak * 4;
        assert_int_equal(load_limited(json, chunk, sizeof binary, high, &peak), FNL_OK);
        while (high - low > low / 64) {
            uint64_t middle = low + (high - low) / 2;
            if (load_limited(json, chunk, sizeof binary, middle, &peak) == FNL_OK)
                high = middle;
            else
                low = middle;
        }
        assert_int_equal(load_limited(json, chunk, sizeof binary, high, &peak), FNL_OK);
        if (peak > high + (2 << 20))
            fail_msg("case %u: %llu bytes within %llu", i, (unsigned long long)peak, (unsigned long long)high);
    }
}

/** Memory that is needed for a while, to make normals and tangents, is given back: primitives do not add it up. */
static void test_passing_memory_is_given_back(void **state) {
    UNUSED(state);
    enum { PRIMITIVES = 20, VERTICES = 30000 };
    char json[4096], *end = json;
    end += sprintf(end,
                   "{" ASSET ",\"accessors\":[{\"componentType\":5126,\"type\":\"VEC3\",\"count\":%d},"
                   "{\"componentType\":5126,\"type\":\"VEC2\",\"count\":%d}],\"meshes\":[{\"primitives\":[",
                   VERTICES, VERTICES);
    for (int i = 0; i < PRIMITIVES; i++)
        end += sprintf(end, "%s{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1}}", i ? "," : "");
    sprintf(end, "]}]}");
    uint64_t peak, kept = PRIMITIVES * (uint64_t)VERTICES * 60, passing = (uint64_t)VERTICES * 300;
    if (load_limited(json, NULL, 0, kept + passing + (2 << 20), &peak) != FNL_OK) fail_msg("%s", file_log.text);
    assert_int_equal(file_log.count, 0);
    assert_true(peak > kept * 3 / 4 && peak < kept + passing + (2 << 20));
    assert_int_equal(load_limited(json, NULL, 0, kept / 2, &peak), FNL_ERROR_MEMORY);
}

/** The size of a compressed view stands in its header, and counts before it is decoded. */
static void test_compressed_views_are_counted(void **state) {
    UNUSED(state);
    enum { COUNT = 1 << 18 };
    static uint32_t values[COUNT];
    size_t bound = meshopt_encodeVertexBufferBound(COUNT, 4);
    unsigned char *packed = malloc(bound);
    size_t size = meshopt_encodeVertexBuffer(packed, bound, values, COUNT, 4);
    char json[1024];
    snprintf(json, sizeof json,
             "{" ASSET
             ",\"extensionsUsed\":[\"EXT_meshopt_compression\"],\"buffers\":[{\"byteLength\":%zu},{\"byteLength\":%d,"
             "\"extensions\":{\"EXT_meshopt_compression\":{\"fallback\":true}}}],\"bufferViews\":[{\"buffer\":1,"
             "\"byteLength\":%d,"
             "\"extensions\":{\"EXT_meshopt_compression\":{\"buffer\":0,\"byteLength\":%zu,\"byteStride\":4,\"count\":%d,"
             "\"mode\":"
             "\"ATTRIBUTES\"}}}]}",
             size, COUNT * 4, COUNT * 4, size, COUNT);
    uint64_t peak;
    assert_int_equal(load_limited(json, packed, size, COUNT * 4 - 1, &peak), FNL_ERROR_MEMORY);
    expect_text("test.glb: /bufferViews/0/extensions/EXT_meshopt_compression: needs 1048576 bytes");
    assert_true(peak < COUNT * 3);
    assert_int_equal(load_limited(json, packed, size, COUNT * 4, &peak), FNL_OK);
    assert_true(peak >= COUNT * 4);
    free(packed);
}

static uint32_t checksum(const unsigned char *bytes, size_t size) { /* PNG's CRC-32 (ISO 3309) */
    uint32_t sum = UINT32_MAX;
    for (size_t i = 0; i < size; i++) {
        sum ^= bytes[i];
        for (int k = 0; k < 8; k++) sum = sum & 1 ? sum >> 1 ^ 0xedb88320u : sum >> 1;
    }
    return ~sum;
}

/** The header of a PNG is all that is read of it at first. */
static void make_png(unsigned char out[69], uint32_t width, uint32_t height) {
    _Static_assert(sizeof test_png <= 69, "it fits");
    memcpy(out, test_png, sizeof test_png);
    for (int i = 0; i < 4; i++) {
        out[16 + i] = (unsigned char)(width >> (24 - 8 * i));
        out[20 + i] = (unsigned char)(height >> (24 - 8 * i));
    }
    uint32_t sum = checksum(out + 12, 17);
    for (int i = 0; i < 4; i++) out[29 + i] = (unsigned char)(sum >> (24 - 8 * i));
}

/** Pictures count as they will be decoded: all of them together, and twice when one is used for colours and for data. */
static void test_pictures_are_counted_by_their_headers(void **state) {
    UNUSED(state);
    unsigned char binary[2][72] = {{0}};
    make_png(binary[0], 2000, 1000);
    make_png(binary[1], 16384, 16384);
#define PICTURE(view) "{\"bufferView\":" #view ",\"mimeType\":\"image/png\"}"
    static const struct {
        const char *json, *place;
        uint64_t needed;
    } cases[] = {
        {"\"images\":[" PICTURE(0) "]", "/images/0: needs 8000000", 8000000},
        {"\"images\":[" PICTURE(1) "]", "/images/0: needs 1073741824", 1073741824},
        {"\"images\":[" PICTURE(0) "," PICTURE(0) "," PICTURE(1) "]", "/images/2: needs 1073741824", 1089741824},
        {"\"images\":[" PICTURE(0) "],\"textures\":[{\"source\":0}],\"materials\":[{\"normalTexture\":{\"index\":0},"
                                   "\"emissiveTexture\":{\"index\":0}}]",
         "/materials/0/emissiveTexture: needs 8000000", 16000000},
    };
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        char json[1024];
        uint64_t peak;
        snprintf(json, sizeof json,
                 "{" ASSET ",\"buffers\":[{\"byteLength\":144}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":69},"
                 "{\"buffer\":0,\"byteOffset\":72,\"byteLength\":69}],%s}",
                 cases[i].json);
        assert_int_equal(load_limited(json, binary, sizeof binary, cases[i].needed - 1, &peak), FNL_ERROR_MEMORY);
        expect_text(cases[i].place);
        assert_int_equal(load_limited(json, binary, sizeof binary, cases[i].needed, &peak), FNL_OK);
        assert_true(peak < 1 << 20);
    }
    fnl_load_params params = fnl_load_params_default();
    uint64_t machine = (uint64_t)sysconf(_SC_PHYS_PAGES) * (uint64_t)sysconf(_SC_PAGESIZE);
    assert_true(params.max_memory == machine / 2 && !params.lenient && !params.confine && !params.resolve);
    uint64_t peak;
    assert_int_equal(
        load_limited("{" ASSET ",\"images\":[{\"uri\":\"data:image/png;base64," TEST_PNG_BASE64 "\"}]}", NULL, 0, 60, &peak),
        FNL_ERROR_MEMORY); /* base64 decodes to more */
    expect_text("/images/0/uri: needs 69 bytes");
}

/* ---- loading from memory, and resolvers ---- */

struct library {
    const char *uris[8];
    uint32_t asked, released;
    const void *data[2];
    size_t sizes[2];
    fnl_result results[2]; /* of pictures, of others */
};

static void release(void *user, const void *data, size_t size) {
    struct library *library = user;
    bool known = false;
    for (int i = 0; i < 2; i++) known |= data == library->data[i] && size == library->sizes[i];
    assert_true(known);
    library->released++;
}

static fnl_result resolve(void *user, const char *uri, fnl_resource *out) {
    struct library *library = user;
    assert_true(out->data == NULL && out->size == 0 && out->release == NULL && out->user == NULL);
    assert_true(library->asked < COUNT_OF(library->uris));
    library->uris[library->asked++] = strdup(uri);
    bool picture = strstr(uri, "png") != NULL;
    if (library->results[!picture] != FNL_OK) return library->results[!picture];
    *out = (fnl_resource){library->data[!picture], library->sizes[!picture], release, library};
    return FNL_OK;
}

static void forget(struct library *library) {
    for (uint32_t i = 0; i < library->asked; i++) free((void *)(uintptr_t)library->uris[i]);
    library->asked = library->released = 0;
    library->results[0] = library->results[1] = FNL_OK;
}

#define LIBRARY_JSON                                                                                                        \
    "{" ASSET                                                                                                               \
    ",\"buffers\":[{\"byteLength\":36,\"uri\":\"/vault/a%20b.bin\"},{\"byteLength\":1,\"uri\":\"data:;base64,AAAA\"}],"     \
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"accessors\":["                                                    \
    "{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3}],"                                             \
    "\"images\":[{\"uri\":\"file:///x.png\"},{\"uri\":\"../../y.png\"}],"                                                   \
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],\"nodes\":[{\"mesh\":0}]}"

static void test_resolvers_decide_about_every_uri(void **state) {
    UNUSED(state);
    static const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 2, 0};
    struct library library = {.data = {test_png, positions}, .sizes = {sizeof test_png, sizeof positions}};
    fnl_load_params params = fnl_load_params_default();
    params.resolve = resolve;
    params.user = &library;
    params.confine = true; /* has nothing to say here */
    fnl_host host = test_host(&file_log);
    fnl_scene *scene = NULL;
    char path[] = "/tmp/fanal-resolver-XXXXXX";
    int file = mkstemp(path);
    assert_true(file >= 0 && write(file, LIBRARY_JSON, strlen(LIBRARY_JSON)) == (ssize_t)strlen(LIBRARY_JSON));
    close(file);
    for (int from_file = 0; from_file < 2; from_file++) {
        char *text = strdup(LIBRARY_JSON);
        host = test_host(&file_log);
        if (from_file)
            assert_int_equal(fnl_scene_load(&host, path, &params, &scene), FNL_OK);
        else
            assert_int_equal(load_memory(&host, text, strlen(text), "a name", &params, &scene), FNL_OK);
        memset(text, 'x', strlen(text)); /* the bytes were copied */
        free(text);
        assert_int_equal(file_log.count, 1); /* the media type of buffer 1, by its name */
        expect_text(from_file ? path : "a name: /buffers/1/uri: ");
        assert_int_equal(library.asked, 3);
        assert_string_equal(library.uris[0], "/vault/a%20b.bin");
        assert_string_equal(library.uris[1], "file:///x.png");
        assert_string_equal(library.uris[2], "../../y.png");
        uint32_t opened = 0;
        for (uint32_t i = 0; i < scene->files.count; i++) opened += scene->files.data[i].identity.node != 0;
        assert_int_equal(opened, from_file); /* no other was opened */
        for (int i = 0; i < 2; i++) {
            assert_true(scene->images.data[i].encoded == test_png); /* read where it is, later */
            assert_int_equal(scene->images.data[i].width, 1);
        }
        assert_true(scene->primitives.data[0].positions[2].y == 2);
        assert_int_equal(library.released, 0);
        fnl_scene_destroy(&scene);
        assert_int_equal(library.released, 3);
        forget(&library);
    }
    unlink(path);
}

static void test_resolvers_may_refuse(void **state) {
    UNUSED(state);
    static const float positions[9] = {0};
    struct library library = {.data = {test_png, positions}, .sizes = {sizeof test_png, sizeof positions}};
    fnl_load_params params = fnl_load_params_default();
    params.resolve = resolve;
    params.user = &library;
    static const struct {
        fnl_result picture, buffer, expected;
        uint32_t released;
        const char *text;
    } cases[] = {
        {FNL_ERROR_FILE, FNL_OK, FNL_OK, 1, "a.gltf: /images/0/uri: the resolver does not give 'file:///x.png'"},
        {FNL_OK, FNL_ERROR_FILE, FNL_ERROR_FILE, 0, "a.gltf: /buffers/0/uri: the resolver does not give '/vault/a%20b.bin'"},
        {FNL_OK, FNL_ERROR_INVALID, FNL_ERROR_FILE, 0, "a.gltf: /buffers/0/uri: "},
        {FNL_ERROR_MEMORY, FNL_OK, FNL_ERROR_MEMORY, 1, "a.gltf: /images/0/uri: the resolver has no memory"},
    };
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        fnl_scene *scene = NULL;
        library.results[0] = cases[i].picture;
        library.results[1] = cases[i].buffer;
        fnl_host host = test_host(&file_log);
        fnl_result result = load_memory(&host, LIBRARY_JSON, strlen(LIBRARY_JSON), "a.gltf", &params, &scene);
        assert_int_equal(result, cases[i].expected);
        expect_text(cases[i].text);
        fnl_scene_destroy(&scene); /* a failed load has released all before it returned */
        assert_int_equal(library.released, cases[i].released);
        forget(&library);
    }
    /* Handed over, but too short: released by the call that fails. */
    library.sizes[1] = 35;
    fnl_scene *scene = NULL;
    fnl_host host = test_host(&file_log);
    assert_int_equal(load_memory(&host, LIBRARY_JSON, strlen(LIBRARY_JSON), "a.gltf", &params, &scene),
                     FNL_ERROR_FORMAT);
    assert_int_equal(library.released, 1);
    forget(&library);
}

static void test_loading_from_memory(void **state) {
    UNUSED(state);
    static const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 2, 0};
    size_t size;
    unsigned char *glb =
        test_glb("{" ASSET ",\"buffers\":[{\"byteLength\":36}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],"
                 "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3}],"
                 "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],\"nodes\":[{\"mesh\":0}]}",
                 positions, sizeof positions, &size);
    fnl_host host = test_host(&file_log);
    fnl_scene *scene = NULL;
    assert_int_equal(load_memory(&host, glb, size, "alone.glb", NULL, &scene), FNL_OK);
    free(glb);
    assert_int_equal(file_log.count, 0);
    fnl_scene_info info;
    assert_int_equal(fnl_scene_query_info(scene, &info), FNL_OK);
    assert_true(info.triangle_count == 1 && info.bounds_high.y == 2);
    fnl_scene_destroy(&scene);
    /* Other files cannot be found from here. */
    static const char *const texts[] = {"{" ASSET ",\"buffers\":[{\"byteLength\":36,\"uri\":\"a.bin\"}]}",
                                        "{" ASSET ",\"images\":[{\"uri\":\"a.bin\"}]}"};
    for (int i = 0; i < 2; i++) {
        host = test_host(&file_log);
        assert_int_equal(load_memory(&host, texts[i], strlen(texts[i]), "a.gltf", NULL, &scene), FNL_ERROR_FILE);
        expect_text("'a.bin' is another file, but this glTF is loaded from memory without a resolver");
        expect_text(i ? "a.gltf: /images/0/uri: " : "a.gltf: /buffers/0/uri: ");
        assert_null(scene);
    }
    host = test_host(&file_log);
    assert_int_equal(load_memory(&host, "", 0, "empty.gltf", NULL, &scene), FNL_ERROR_FORMAT);
    expect_text("empty.gltf: /: is not JSON");
    assert_int_equal(load_memory(&host, NULL, 1, "a.gltf", NULL, &scene), FNL_ERROR_INVALID);
    assert_int_equal(load_memory(&host, "{}", 2, NULL, NULL, &scene), FNL_ERROR_INVALID);
    assert_int_equal(load_memory(&host, "{}", 2, "a.gltf", NULL, NULL), FNL_ERROR_INVALID);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_required_extensions_must_be_shown),
        cmocka_unit_test(test_absolute_paths_are_refused),
        cmocka_unit_test(test_the_folder_is_what_links_lead_to),
        cmocka_unit_test(test_missing_data_is_an_error),
        cmocka_unit_test(test_files_count_against_the_limit),
        cmocka_unit_test(test_memory_is_counted_before_it_is_taken),
        cmocka_unit_test(test_passing_memory_is_given_back),
        cmocka_unit_test(test_compressed_views_are_counted),
        cmocka_unit_test(test_pictures_are_counted_by_their_headers),
        cmocka_unit_test(test_resolvers_decide_about_every_uri),
        cmocka_unit_test(test_resolvers_may_refuse),
        cmocka_unit_test(test_loading_from_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
