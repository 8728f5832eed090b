/* SPDX-License-Identifier: MIT */
/* Loading as the host sees it: how far it is, an end before the end, and files that become part of a scene that is there. */
#include "tests/gltf_test_file.h"
#include "tests/test_memory.h"

#include <unistd.h>

/* A tree of two nodes with a textured triangle, a lamp, a camera and an animation. `where` tells it from another. */
static unsigned char *make_file(const char *where, size_t *size) {
    struct {
        float positions[9], times[2], keys[6];
    } binary = {{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 2}, {0, 0, 0, 4, 0, 0}};
    char json[3000];
    snprintf(json, sizeof json,
             "{\"asset\":{\"version\":\"2.0\"},\"extensionsUsed\":[\"KHR_lights_punctual\"],\"extensions\":{\"KHR_lights_punctual\":{"
             "\"lights\":[{\"name\":\"%s lamp\",\"type\":\"point\"}]}},\"buffers\":[{\"byteLength\":%zu}],"
             "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},{\"buffer\":0,\"byteOffset\":36,\"byteLength\":32}],"
             "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3,\"min\":[0,0,0],\"max\":[1,1,0]},"
             "{\"bufferView\":1,\"componentType\":5126,\"type\":\"SCALAR\",\"count\":2,\"min\":[0],\"max\":[2]},"
             "{\"bufferView\":1,\"byteOffset\":8,\"componentType\":5126,\"type\":\"VEC3\",\"count\":2}],"
             "\"images\":[{\"uri\":\"data:image/png;base64," TEST_PNG_BASE64 "\"}],\"samplers\":[{\"wrapS\":%d}],"
             "\"textures\":[{\"source\":0,\"sampler\":0}],"
             "\"materials\":[{\"name\":\"%s paint\",\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}}],"
             "\"cameras\":[{\"name\":\"%s eye\",\"type\":\"perspective\",\"perspective\":{\"yfov\":1,\"znear\":0.1}}],"
             "\"meshes\":[{\"name\":\"%s mesh\",\"primitives\":[{\"attributes\":{\"POSITION\":0},\"material\":0}]}],"
             "\"nodes\":[{\"name\":\"%s top\",\"children\":[1],\"translation\":[1,0,0]},{\"name\":\"%s leaf\",\"mesh\":0,\"camera\":0,"
             "\"translation\":[0,2,0],\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}}],\"scenes\":[{\"nodes\":[0]}],\"scene\":0,"
             "\"animations\":[{\"name\":\"%s walk\",\"samplers\":[{\"input\":1,\"output\":2}],\"channels\":[{\"sampler\":0,\"target\":"
             "{\"node\":1,\"path\":\"translation\"}}]}]}",
             where, sizeof binary, *where == 'a' ? 33071 : 33648, where, where, where, where, where, where);
    return test_glb(json, &binary, sizeof binary, size);
}

static struct test_log lines;

static fnl_load_params from_memory(const void *data, size_t size) {
    fnl_load_params params = fnl_load_params_default();
    params.data = data;
    params.size = size;
    return params;
}

static fnl_host counting_host(struct test_memory *memory) {
    fnl_host host = fnl_host_default();
    host.user = memory;
    host.reallocate = test_memory_reallocate;
    host.log = test_log_line;
    return host;
}

/* ---- progress ---- */

struct progress {
    uint32_t calls, total, last, end_at; /* end_at: the call that cancels, from 1 on */
};

static bool count_progress(void *user, uint32_t done, uint32_t total) {
    struct progress *p = user;
    assert_true(p->calls == 0 ? done == 0 : done == p->last + 1); /* none is left out */
    assert_true(p->calls == 0 || total == p->total);
    assert_true(done <= total);
    p->last = done;
    p->total = total;
    return ++p->calls != p->end_at;
}

static void quiet_log(void *user, fnl_log_level level, const char *line) {
    UNUSED(user);
    UNUSED(line);
    lines.count += level >= FNL_LOG_ERROR;
}

static void test_a_load_can_be_cancelled_at_every_step(void **state) {
    UNUSED(state);
    size_t size;
    unsigned char *file = make_file("a", &size);
    struct test_memory memory = {0};
    fnl_host host = counting_host(&memory);
    host.log = quiet_log;
    fnl_load_params params = from_memory(file, size);
    struct progress whole = {0};
    params.progress = count_progress;
    params.user = &whole;
    fnl_scene *scene;
    lines.count = 0;
    assert_int_equal(fnl_scene_load(&host, "a.glb", &params, &scene), FNL_OK);
    fnl_scene_destroy(&scene);
    assert_int_equal(whole.last, whole.total);
    assert_true(whole.total > 4 && whole.calls == whole.total + 1);
    for (uint32_t at = 1; at <= whole.calls; at++) {
        struct progress p = {.end_at = at};
        params.user = &p;
        scene = (fnl_scene *)&p;
        assert_int_equal(fnl_scene_load(&host, "a.glb", &params, &scene), FNL_ERROR_CANCELLED);
        assert_null(scene);
        assert_int_equal(p.calls, at); /* it is not asked again */
        assert_int_equal(memory.live_bytes, 0);
    }
    assert_int_equal(lines.count, 0);
    assert_int_equal(memory.wrong_sizes, 0);
    free(file);
}

/* ---- into a scene ---- */

static const char *name_of(const fnl_scene *scene, fnl_entity kind, uint32_t index) {
    fnl_entity_info info;
    assert_int_equal(fnl_scene_query_entity(scene, kind, index, &info), FNL_OK);
    return info.name;
}

static fnl_instance_id instance_of(const fnl_scene *scene, const char *name) {
    uint32_t index;
    fnl_entity_info info;
    assert_int_equal(fnl_scene_find(scene, FNL_ENTITY_INSTANCE, name, &index), FNL_OK);
    assert_int_equal(fnl_scene_query_entity(scene, FNL_ENTITY_INSTANCE, index, &info), FNL_OK);
    return info.id.instance;
}

static void expect_position(vec3 position, float x, float y, float z) {
    assert_true(fabsf(position.x - x) + fabsf(position.y - y) + fabsf(position.z - z) < 1e-5f);
}

static fnl_light_params light_at(const fnl_scene *scene, uint32_t index) {
    fnl_light_params light;
    assert_int_equal(fnl_scene_query_light(scene, index, &light), FNL_OK);
    return light;
}

/* A scene loaded from one file, and another file to load into it. Both are freed by the test. */
static fnl_scene *open_first(const fnl_host *host, unsigned char **a, size_t *size_a, unsigned char **b, size_t *size_b) {
    *a = make_file("a", size_a);
    *b = make_file("b", size_b);
    fnl_load_params params = from_memory(*a, *size_a);
    fnl_scene *scene;
    assert_int_equal(fnl_scene_load(host, "a.glb", &params, &scene), FNL_OK);
    return scene;
}

static void test_a_file_becomes_part_of_a_scene(void **state) {
    UNUSED(state);
    size_t size_a, size_b;
    unsigned char *a, *b;
    struct test_memory memory = {0};
    fnl_host host = counting_host(&memory);
    host.log = quiet_log;
    fnl_scene *scene = open_first(&host, &a, &size_a, &b, &size_b);
    fnl_light_params sun = fnl_light_params_default();
    fnl_light_id holes[2];
    for (int i = 0; i < 2; i++) assert_int_equal(fnl_scene_add_light(scene, &sun, &holes[i]), FNL_OK);
    assert_int_equal(fnl_scene_remove_light(scene, holes[0]), FNL_OK); /* indices go on from the last all the same */
    fnl_instance_id parent = instance_of(scene, "a leaf");
    uint32_t counts[FNL_ENTITY_COUNT];
    for (int kind = 0; kind < FNL_ENTITY_COUNT; kind++) counts[kind] = fnl_scene_count(scene, (fnl_entity)kind);

    char path[64];
    snprintf(path, sizeof path, "/tmp/fanal-load-test-%d.glb", (int)getpid());
    assert_int_equal(file_save(&host, path, b, size_b), FNL_OK);
    fnl_loaded loaded;
    assert_int_equal(fnl_scene_set_instance_visible(scene, parent, false), FNL_OK); /* what is loaded below is not shown either */
    assert_int_equal(fnl_scene_load_into(scene, parent, path, NULL, &loaded), FNL_OK);
    unlink(path);
    assert_false(scene->nodes.data[instance_of(scene, "b leaf").index].active);
    assert_int_equal(fnl_scene_set_instance_visible(scene, parent, true), FNL_OK);
    memset(a, 0, size_a); /* the bytes were copied */
    free(a);
    free(b);
    const uint32_t expected[FNL_ENTITY_COUNT] = {
        [FNL_ENTITY_INSTANCE] = 3, [FNL_ENTITY_LIGHT] = 1,  [FNL_ENTITY_MESH] = 1,     [FNL_ENTITY_MATERIAL] = 1,
        [FNL_ENTITY_IMAGE] = 1,    [FNL_ENTITY_CAMERA] = 1, [FNL_ENTITY_ANIMATION] = 1};
    for (int kind = 0; kind < FNL_ENTITY_COUNT; kind++) {
        assert_int_equal(loaded.first[kind], counts[kind]);
        assert_int_equal(loaded.count[kind], expected[kind]);
    }
    assert_string_equal(name_of(scene, FNL_ENTITY_INSTANCE, loaded.first[FNL_ENTITY_INSTANCE]), path);
    assert_string_equal(name_of(scene, FNL_ENTITY_INSTANCE, loaded.first[FNL_ENTITY_INSTANCE] + 2), "b leaf");
    assert_string_equal(name_of(scene, FNL_ENTITY_LIGHT, loaded.first[FNL_ENTITY_LIGHT]), "b lamp");
    assert_string_equal(name_of(scene, FNL_ENTITY_CAMERA, loaded.first[FNL_ENTITY_CAMERA]), "b eye");
    assert_string_equal(name_of(scene, FNL_ENTITY_MATERIAL, loaded.first[FNL_ENTITY_MATERIAL]), "b paint");

    /* Each refers to its own, and hangs where it should. */
    uint32_t mesh = scene->nodes.data[instance_of(scene, "b leaf").index].mesh;
    assert_string_equal(scene->meshes.data[mesh].name, "b mesh");
    uint32_t material = scene->primitives.data[scene->meshes.data[mesh].first_primitive].material;
    assert_string_equal(scene->materials.data[material].name, "b paint");
    const struct scene_texture *texture = &scene->materials.data[material].textures[SCENE_TEXTURE_BASE_COLOR];
    assert_int_equal(texture->image, loaded.first[FNL_ENTITY_IMAGE]);
    assert_int_equal(scene->samplers.data[texture->sampler].wrap_u, SCENE_WRAP_MIRROR);
    assert_string_equal(scene->materials.data[0].name, "a paint");
    expect_position(light_at(scene, 0).position, 1, 2, 0);
    expect_position(light_at(scene, loaded.first[FNL_ENTITY_LIGHT]).position, 2, 4, 0);
    fnl_camera camera;
    assert_int_equal(fnl_scene_query_camera(scene, loaded.first[FNL_ENTITY_CAMERA], &camera), FNL_OK);
    expect_position(camera.position, 2, 4, 0);

    /* It is animated by its own animation, moves with what it hangs on, and is hidden and removed as one. */
    assert_int_equal(fnl_scene_set_time(scene, loaded.first[FNL_ENTITY_ANIMATION], 2), FNL_OK);
    expect_position(light_at(scene, loaded.first[FNL_ENTITY_LIGHT]).position, 6, 2, 0);
    expect_position(light_at(scene, 0).position, 1, 2, 0);
    fnl_mat4 place = mat4_translation(vec3_make(0, 0, 7));
    assert_int_equal(fnl_scene_set_instance_transform(scene, parent, &place), FNL_OK);
    expect_position(light_at(scene, loaded.first[FNL_ENTITY_LIGHT]).position, 6, 0, 7);
    place = mat4_translation(vec3_make(0, 0, 1));
    assert_int_equal(fnl_scene_set_instance_transform(scene, loaded.root, &place), FNL_OK);
    expect_position(light_at(scene, loaded.first[FNL_ENTITY_LIGHT]).position, 6, 0, 8);
    assert_int_equal(fnl_scene_set_instance_visible(scene, parent, false), FNL_OK);
    assert_false(scene->nodes.data[instance_of(scene, "b leaf").index].active);
    assert_int_equal(fnl_scene_set_instance_visible(scene, parent, true), FNL_OK);
    assert_true(scene->nodes.data[instance_of(scene, "b leaf").index].active);
    assert_int_equal(fnl_scene_remove_instance(scene, loaded.root), FNL_OK);
    assert_int_equal(fnl_scene_count(scene, FNL_ENTITY_INSTANCE), counts[FNL_ENTITY_INSTANCE]);
    assert_int_equal(fnl_scene_count(scene, FNL_ENTITY_LIGHT), counts[FNL_ENTITY_LIGHT]);
    fnl_scene_destroy(&scene);
    assert_int_equal(memory.live_bytes, 0);
    assert_int_equal(memory.wrong_sizes, 0);
}

/* All that a call could change and a test can see. */
struct sight {
    uint32_t counts[FNL_ENTITY_COUNT], primitives, samplers, files, messages;
    uint64_t versions[5];
};
static struct sight look_at(const fnl_scene *scene) {
    struct sight sight;
    memset(&sight, 0, sizeof sight);
    for (int kind = 0; kind < FNL_ENTITY_COUNT; kind++) sight.counts[kind] = fnl_scene_count(scene, (fnl_entity)kind);
    sight.primitives = scene->primitives.count;
    sight.samplers = scene->samplers.count;
    sight.files = scene->files.count;
    sight.messages = scene->messages.count;
    const uint64_t versions[5] = {scene->structure_version, scene->light_version, scene->transform_version,
                                  scene->decal_version, scene->material_version};
    memcpy(sight.versions, versions, sizeof versions);
    return sight;
}

static void test_errors_leave_the_scene_as_it_was(void **state) {
    UNUSED(state);
    size_t size_a, size_b;
    unsigned char *a, *b;
    struct test_memory memory = {0};
    fnl_host host = counting_host(&memory);
    host.log = quiet_log;
    fnl_scene *scene = open_first(&host, &a, &size_a, &b, &size_b);
    const fnl_instance_id nothing = {0, 0}, stale = {1, 12345};
    fnl_loaded loaded;
    const struct sight before = look_at(scene);
    fnl_load_params params = from_memory(b, size_b);
    assert_int_equal(fnl_scene_load_into(scene, stale, "b.glb", &params, &loaded), FNL_ERROR_INVALID);
    assert_int_equal(fnl_scene_load_into(scene, nothing, "builtin:spheres", &params, &loaded), FNL_ERROR_UNSUPPORTED);
    assert_int_equal(fnl_scene_load_into(scene, nothing, "/no/such.glb", NULL, &loaded), FNL_ERROR_FILE);
    params.size -= 40;
    assert_int_equal(fnl_scene_load_into(scene, nothing, "b.glb", &params, &loaded), FNL_ERROR_FORMAT);
    params.size = size_b;
    struct progress p = {.end_at = 7};
    params.progress = count_progress;
    params.user = &p;
    assert_int_equal(fnl_scene_load_into(scene, nothing, "b.glb", &params, &loaded), FNL_ERROR_CANCELLED);
    params.progress = NULL;
    struct sight now = look_at(scene);
    assert_memory_equal(&now, &before, sizeof before);
    assert_int_equal(loaded.root.generation, 0);

    /* Each allocation fails once, with all after it; so often that each array has to grow. */
    enum { ROUNDS = 40 };
    uint32_t failures = 0;
    for (uint32_t round = 0; round < ROUNDS; round++) {
        const struct sight at_first = look_at(scene);
        for (long long n = 1;; n++) {
            atomic_store(&memory.fail_at, atomic_load(&memory.allocations) + n);
            lines.count = 0;
            fnl_result result = fnl_scene_load_into(scene, nothing, "b.glb", &params, &loaded);
            atomic_store(&memory.fail_at, 0);
            if (result == FNL_OK) break;
            assert_int_equal(result, FNL_ERROR_MEMORY);
            assert_true(lines.count > 0); /* told */
            now = look_at(scene);
            assert_memory_equal(&now, &at_first, sizeof now);
            failures++;
        }
    }
    assert_true(failures > 15 * ROUNDS);
    assert_int_equal(fnl_scene_count(scene, FNL_ENTITY_INSTANCE), before.counts[FNL_ENTITY_INSTANCE] + 3 * ROUNDS);
    assert_int_equal(fnl_scene_count(scene, FNL_ENTITY_LIGHT), before.counts[FNL_ENTITY_LIGHT] + ROUNDS);
    fnl_scene_destroy(&scene);
    assert_int_equal(memory.live_bytes, 0);
    assert_int_equal(memory.wrong_sizes, 0);
    free(a);
    free(b);
}

/* ---- files that go again ---- */

enum { PICTURE_BYTES = 2000000 }; /* much more than all else of the file */

/* A triangle with a picture of so many bytes, most of them behind its end. */
static unsigned char *make_textured(size_t *size) {
    unsigned char *binary = calloc(1, 36 + PICTURE_BYTES);
    char json[1500];
    const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    memcpy(binary, positions, sizeof positions);
    memcpy(binary + 36, test_png, sizeof test_png);
    snprintf(json, sizeof json,
             "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":%d}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},"
             "{\"buffer\":0,\"byteOffset\":36,\"byteLength\":%d}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3,"
             "\"min\":[0,0,0],\"max\":[1,1,0]}],\"images\":[{\"bufferView\":1,\"mimeType\":\"image/png\"}],\"textures\":[{\"source\":0}],"
             "\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}}],"
             "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"material\":0}]}],"
             "\"nodes\":[{\"mesh\":0}],\"scenes\":[{\"nodes\":[0]}],\"scene\":0}",
             36 + PICTURE_BYTES, PICTURE_BYTES);
    unsigned char *glb = test_glb(json, binary, 36 + PICTURE_BYTES, size);
    free(binary);
    return glb;
}

/* What else may hold on to the file's image, or its mesh. */
enum holder { NOBODY, AN_INSTANCE, A_MATERIAL, A_DECAL, A_READER, HOLDERS };

static fnl_entity_info entity_at(const fnl_scene *scene, fnl_entity kind, uint32_t index) {
    fnl_entity_info info;
    assert_int_equal(fnl_scene_query_entity(scene, kind, index, &info), FNL_OK);
    return info;
}

struct held {
    fnl_instance_id instance;
    fnl_material_id material;
    fnl_decal_id decal;
};

static struct held hold(fnl_scene *scene, enum holder by, const fnl_loaded *loaded) {
    const fnl_image_id image = entity_at(scene, FNL_ENTITY_IMAGE, loaded->first[FNL_ENTITY_IMAGE]).id.image;
    const fnl_mesh_id mesh = entity_at(scene, FNL_ENTITY_MESH, loaded->first[FNL_ENTITY_MESH]).id.mesh;
    const fnl_mat4 place = mat4_identity();
    struct held held;
    fnl_material_params look = fnl_material_params_default();
    fnl_decal_params decal = fnl_decal_params_default();
    look.emissive_image = decal.color_image = image;
    if (by == AN_INSTANCE) assert_int_equal(fnl_scene_add_instance(scene, mesh, &place, &held.instance), FNL_OK);
    if (by == A_MATERIAL) assert_int_equal(fnl_scene_add_material(scene, &look, &held.material), FNL_OK);
    if (by == A_DECAL) assert_int_equal(fnl_scene_add_decal(scene, &decal, &held.decal), FNL_OK);
    if (by == A_READER) atomic_fetch_add(&scene->readers, 1);
    return held;
}

static void let_go(fnl_scene *scene, enum holder by, const struct held *held) {
    fnl_image pixel = {1, 1, FNL_PIXEL_FORMAT_RGBA8, (uint8_t[4]){1, 2, 3, 4}};
    fnl_image_id image;
    if (by == AN_INSTANCE) assert_int_equal(fnl_scene_remove_instance(scene, held->instance), FNL_OK);
    if (by == A_MATERIAL) assert_int_equal(fnl_scene_remove_material(scene, held->material), FNL_OK);
    if (by == A_DECAL) assert_int_equal(fnl_scene_remove_decal(scene, held->decal), FNL_OK);
    if (by != A_READER) return;
    atomic_fetch_sub(&scene->readers, 1); /* the next removal frees the file */
    assert_int_equal(fnl_scene_add_image(scene, &pixel, true, &image), FNL_OK);
    assert_int_equal(fnl_scene_remove_image(scene, image), FNL_OK);
}

static void expect_counts(const fnl_scene *scene, const uint32_t counts[FNL_ENTITY_COUNT]) {
    for (int kind = 0; kind < FNL_ENTITY_COUNT; kind++)
        if (fnl_scene_count(scene, (fnl_entity)kind) != counts[kind])
            fail_msg("kind %d: %u, not %u", kind, fnl_scene_count(scene, (fnl_entity)kind), counts[kind]);
}

static uint32_t primitives_of(const fnl_scene *scene) {
    fnl_scene_info info;
    assert_int_equal(fnl_scene_query_info(scene, &info), FNL_OK);
    return info.primitive_count;
}

static void count_all(const fnl_scene *scene, uint32_t counts[FNL_ENTITY_COUNT]) {
    for (int kind = 0; kind < FNL_ENTITY_COUNT; kind++) counts[kind] = fnl_scene_count(scene, (fnl_entity)kind);
}

/* A file is freed with its root, or with the last user of any of its parts. */
static void test_files_go_with_their_last_user(void **state) {
    UNUSED(state);
    for (int by = NOBODY; by < HOLDERS; by++) {
        size_t size_a, size_b, size;
        unsigned char *a, *b, *textured = make_textured(&size);
        struct test_memory memory = {0};
        fnl_host host = counting_host(&memory);
        host.log = quiet_log;
        fnl_scene *scene = open_first(&host, &a, &size_a, &b, &size_b);
        fnl_load_params params = from_memory(textured, size);
        uint32_t counts[FNL_ENTITY_COUNT];
        count_all(scene, counts);
        for (int round = 0; round < 3; round++) {
            fnl_loaded loaded;
            const long long before = memory.live_bytes;
            assert_int_equal(fnl_scene_load_into(scene, (fnl_instance_id){0, 0}, "c.glb", &params, &loaded), FNL_OK);
            assert_true(memory.live_bytes >= before + PICTURE_BYTES);
            const struct held held = hold(scene, (enum holder)by, &loaded);
            assert_int_equal(fnl_scene_remove_instance(scene, loaded.root), FNL_OK);
            const bool stays = memory.live_bytes >= before + PICTURE_BYTES;
            if (stays != (by != NOBODY)) fail_msg("holder %d: %lld bytes more than before", by, (long long)memory.live_bytes - before);
            let_go(scene, (enum holder)by, &held);
            if (round && memory.live_bytes != before) fail_msg("holder %d: %lld bytes stay", by, (long long)memory.live_bytes - before);
            expect_counts(scene, counts);
            assert_int_equal(scene->parts.count, 0);
        }
        fnl_scene_destroy(&scene);
        assert_int_equal(memory.live_bytes, 0);
        assert_int_equal(memory.wrong_sizes, 0);
        free(a);
        free(b);
        free(textured);
    }
}

/* While an instance outside the file shows its mesh, its meshes, materials and used images stay. */
static void test_what_is_used_stays_whole(void **state) {
    UNUSED(state);
    size_t size_a, size_b;
    unsigned char *a, *b;
    struct test_memory memory = {0};
    fnl_host host = counting_host(&memory);
    host.log = quiet_log;
    fnl_scene *scene = open_first(&host, &a, &size_a, &b, &size_b);
    fnl_load_params params = from_memory(b, size_b);
    fnl_loaded loaded;
    uint32_t counts[FNL_ENTITY_COUNT];
    count_all(scene, counts);
    assert_int_equal(fnl_scene_load_into(scene, (fnl_instance_id){0, 0}, "b.glb", &params, &loaded), FNL_OK);
    const fnl_material_id material = entity_at(scene, FNL_ENTITY_MATERIAL, loaded.first[FNL_ENTITY_MATERIAL]).id.material;
    const struct held held = hold(scene, AN_INSTANCE, &loaded);
    assert_int_equal(fnl_scene_remove_instance(scene, loaded.root), FNL_OK);
    counts[FNL_ENTITY_INSTANCE]++, counts[FNL_ENTITY_MESH]++, counts[FNL_ENTITY_MATERIAL]++, counts[FNL_ENTITY_IMAGE]++;
    expect_counts(scene, counts);
    fnl_mesh_info mesh;
    fnl_material_params look;
    assert_int_equal(fnl_scene_query_mesh(scene, counts[FNL_ENTITY_MESH] - 1, 0, &mesh), FNL_OK);
    assert_memory_equal(&mesh.params.material, &material, sizeof material);
    assert_true(mesh.params.positions[3] == 1);
    assert_int_equal(fnl_scene_query_material(scene, counts[FNL_ENTITY_MATERIAL] - 1, &look), FNL_OK);
    assert_int_not_equal(look.base_color_image.generation, 0);
    assert_int_equal(fnl_scene_remove_material(scene, material), FNL_ERROR_INVALID);
    assert_int_equal(fnl_scene_remove_image(scene, look.base_color_image), FNL_ERROR_INVALID);

    /* A file loaded meanwhile gets other indices. */
    fnl_loaded other;
    assert_int_equal(fnl_scene_load_into(scene, (fnl_instance_id){0, 0}, "b.glb", &params, &other), FNL_OK);
    const fnl_material_id second = entity_at(scene, FNL_ENTITY_MATERIAL, other.first[FNL_ENTITY_MATERIAL]).id.material;
    assert_int_not_equal(second.index, material.index);
    assert_int_equal(fnl_scene_remove_instance(scene, held.instance), FNL_OK);
    assert_string_equal(entity_at(scene, FNL_ENTITY_MATERIAL, counts[FNL_ENTITY_MATERIAL] - 1).name, "b paint");
    assert_int_equal(fnl_scene_set_material(scene, material, &look), FNL_ERROR_INVALID); /* the old id does not name the new material */
    assert_int_equal(fnl_scene_query_material(scene, counts[FNL_ENTITY_MATERIAL] - 1, &look), FNL_OK);
    assert_int_equal(fnl_scene_set_material(scene, second, &look), FNL_OK);
    fnl_scene_destroy(&scene);
    assert_int_equal(memory.live_bytes, 0);
    assert_int_equal(memory.wrong_sizes, 0);
    free(a);
    free(b);
}

/* Loads and unloads files of different sizes in any order: memory does not grow, and each loaded file stays intact. */
static void test_rounds_of_loading_keep_memory_flat(void **state) {
    UNUSED(state);
    enum { FILES = 3, ROUNDS = 10000 };
    size_t size_a, sizes[FILES];
    unsigned char *a, *files[FILES];
    struct test_memory memory = {0};
    fnl_host host = counting_host(&memory);
    host.log = quiet_log;
    fnl_scene *scene = open_first(&host, &a, &size_a, &files[0], &sizes[0]);
    files[1] = make_file("c", &sizes[1]);
    files[2] = make_textured(&sizes[2]);
    fnl_loaded loaded[FILES];
    bool there[FILES] = {false};
    uint32_t counts[FNL_ENTITY_COUNT], most = 0;
    long long bytes = 0;
    uint64_t random = 1;
    count_all(scene, counts);
    const uint32_t primitives = primitives_of(scene);
    for (uint32_t round = 0; round < ROUNDS; round++) {
        random = random * 6364136223846793005u + 1442695040888963407u;
        const uint32_t i = (uint32_t)(random >> 33) % FILES;
        fnl_load_params params = from_memory(files[i], sizes[i]);
        if (there[i])
            assert_int_equal(fnl_scene_remove_instance(scene, loaded[i].root), FNL_OK);
        else
            assert_int_equal(fnl_scene_load_into(scene, (fnl_instance_id){0, 0}, "x.glb", &params, &loaded[i]), FNL_OK);
        there[i] = !there[i];
        for (uint32_t k = 0; k < FILES; k++) {
            if (!there[k]) continue;
            const struct scene_node *root = &scene->nodes.data[loaded[k].root.index];
            assert_true(!root->removed && root->generation == loaded[k].root.generation && root->first_child != SCENE_NONE);
        }
        assert_int_equal(primitives_of(scene), primitives + there[0] + there[1] + there[2]);
        if (there[0] || there[1] || there[2]) continue;
        expect_counts(scene, counts);
        if (round < 1000) {
            bytes = memory.live_bytes;
            most = scene->nodes.count + scene->meshes.count + scene->primitives.count + scene->images.count + scene->materials.count +
                   scene->samplers.count + scene->animations.count + scene->cameras.count + scene->lights.count;
        } else if (memory.live_bytes != bytes) {
            fail_msg("round %u: %lld bytes more", round, (long long)memory.live_bytes - bytes);
        }
    }
    assert_true(most < 100);
    assert_int_equal(most, scene->nodes.count + scene->meshes.count + scene->primitives.count + scene->images.count + scene->materials.count +
                               scene->samplers.count + scene->animations.count + scene->cameras.count + scene->lights.count);
    fnl_scene_destroy(&scene);
    assert_int_equal(memory.live_bytes, 0);
    assert_int_equal(memory.wrong_sizes, 0);
    free(a);
    for (int i = 0; i < FILES; i++) free(files[i]);
}

/* ---- what calls add ---- */

static const char profile_text[] = "IESNA:LM-63-1995\nTILT=NONE\n1 1000 1 3 1 1 2 0 0 0\n1 1 1\n0 45 90\n0\n100 50 0\n";

static void test_rounds_of_adding_keep_memory_flat(void **state) {
    UNUSED(state);
    struct test_memory memory = {0};
    fnl_host host = counting_host(&memory);
    host.log = quiet_log;
    fnl_scene *scene;
    long long bytes = 0;
    uint32_t counts[FNL_ENTITY_COUNT];
    assert_int_equal(fnl_scene_create(&host, &scene), FNL_OK);
    count_all(scene, counts);
    for (uint32_t round = 0; round < 10000; round++) {
        if (round == 10) bytes = memory.live_bytes;
        fnl_image pixel = {1, 1, FNL_PIXEL_FORMAT_RGBA8, (uint8_t[4]){1, 2, 3, 4}};
        fnl_image_id image;
        fnl_material_params look = fnl_material_params_default();
        fnl_material_id material;
        const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
        fnl_mesh_params shape = {.vertex_count = 3, .positions = positions};
        fnl_mesh_id mesh;
        const fnl_mat4 place = mat4_identity();
        fnl_instance_id instance;
        fnl_light_profile_id profile;
        fnl_light_params light = fnl_light_params_default();
        fnl_light_id lamp;
        const fnl_camera camera = fnl_camera_default();
        assert_int_equal(fnl_scene_add_image(scene, &pixel, true, &image), FNL_OK);
        look.base_color_image = image;
        assert_int_equal(fnl_scene_add_material(scene, &look, &material), FNL_OK);
        shape.material = material;
        assert_int_equal(fnl_scene_add_mesh(scene, &shape, &mesh), FNL_OK);
        assert_int_equal(fnl_scene_add_instance(scene, mesh, &place, &instance), FNL_OK);
        assert_int_equal(fnl_scene_add_light_profile(scene, "p.ies", profile_text, sizeof profile_text - 1, &profile, NULL), FNL_OK);
        light.kind = FNL_LIGHT_SPOT;
        light.profile = profile;
        assert_int_equal(fnl_scene_add_light(scene, &light, &lamp), FNL_OK);
        assert_int_equal(fnl_scene_add_camera(scene, "eye", &camera), FNL_OK);

        /* Nothing can be removed while it is in use, or removed twice. */
        assert_int_equal(fnl_scene_remove_image(scene, image), FNL_ERROR_INVALID);
        assert_int_equal(fnl_scene_remove_material(scene, material), FNL_ERROR_INVALID);
        assert_int_equal(fnl_scene_remove_mesh(scene, mesh), FNL_ERROR_INVALID);
        assert_int_equal(fnl_scene_remove_light_profile(scene, profile), FNL_ERROR_INVALID);
        assert_int_equal(fnl_scene_remove_instance(scene, instance), FNL_OK);
        assert_int_equal(fnl_scene_remove_mesh(scene, mesh), FNL_OK);
        assert_int_equal(fnl_scene_remove_mesh(scene, mesh), FNL_ERROR_INVALID);
        assert_int_equal(fnl_scene_add_instance(scene, mesh, &place, &instance), FNL_ERROR_INVALID);
        assert_int_equal(fnl_scene_remove_material(scene, material), FNL_OK);
        assert_int_equal(fnl_scene_remove_material(scene, material), FNL_ERROR_INVALID);
        assert_int_equal(fnl_scene_remove_image(scene, image), FNL_OK);
        assert_int_equal(fnl_scene_remove_image(scene, image), FNL_ERROR_INVALID);
        assert_int_equal(fnl_scene_remove_light(scene, lamp), FNL_OK);
        assert_int_equal(fnl_scene_remove_light_profile(scene, profile), FNL_OK);
        assert_int_equal(fnl_scene_remove_light_profile(scene, profile), FNL_ERROR_INVALID);
        assert_int_equal(fnl_scene_remove_camera(scene, 0), FNL_OK);
        assert_int_equal(fnl_scene_remove_camera(scene, 0), FNL_ERROR_INVALID);
        expect_counts(scene, counts);
    }
    if (memory.live_bytes != bytes) fail_msg("%lld bytes more", (long long)memory.live_bytes - bytes);

    /* The generation of an id counts the reuses of its index. Destroying the scene frees the elements that remain. */
    fnl_image pixel = {1, 1, FNL_PIXEL_FORMAT_RGBA8, (uint8_t[4]){1, 2, 3, 4}};
    const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const fnl_mesh_params shape = {.vertex_count = 3, .positions = positions};
    const fnl_camera camera = fnl_camera_default();
    fnl_image_id image;
    fnl_light_profile_id profile;
    for (uint32_t i = 0; i < 2; i++) {
        fnl_mesh_id mesh;
        fnl_material_id material;
        assert_int_equal(fnl_scene_add_mesh(scene, &shape, &mesh), FNL_OK);
        assert_int_equal(fnl_scene_add_material(scene, NULL, &material), FNL_OK);
        assert_int_equal(fnl_scene_add_image(scene, &pixel, true, &image), FNL_OK);
        assert_int_equal(fnl_scene_add_camera(scene, "eye", &camera), FNL_OK);
        assert_int_equal(fnl_scene_add_light_profile(scene, "p.ies", profile_text, sizeof profile_text - 1, &profile, NULL), FNL_OK);
        const uint32_t generation = i ? FIRST_GENERATION : FIRST_GENERATION + 10000;
        assert_true(mesh.index == i && mesh.generation == generation);
        assert_true(material.index == i && material.generation == generation);
        assert_true(image.index == i && image.generation == generation);
    }
    fnl_scene_destroy(&scene);
    assert_int_equal(memory.live_bytes, 0);
    assert_int_equal(memory.wrong_sizes, 0);
}

/* Indices skip what was removed. */
static void test_removed_cameras_and_animations_are_skipped(void **state) {
    UNUSED(state);
    size_t size_a, size_b;
    unsigned char *a, *b;
    fnl_host host = fnl_host_default();
    host.log = quiet_log;
    fnl_scene *scene = open_first(&host, &a, &size_a, &b, &size_b);
    fnl_load_params params = from_memory(b, size_b);
    fnl_loaded loaded;
    fnl_camera camera;
    fnl_animation_info animation;
    assert_int_equal(fnl_scene_load_into(scene, (fnl_instance_id){0, 0}, "b.glb", &params, &loaded), FNL_OK);
    assert_int_equal(fnl_scene_remove_camera(scene, 0), FNL_OK);
    assert_int_equal(fnl_scene_query_camera(scene, 0, &camera), FNL_OK);
    expect_position(camera.position, 1, 2, 0);
    assert_string_equal(name_of(scene, FNL_ENTITY_CAMERA, 0), "b eye");
    assert_int_equal(fnl_scene_remove_animation(scene, 0), FNL_OK);
    assert_int_equal(fnl_scene_query_animation(scene, 0, &animation), FNL_OK);
    assert_string_equal(animation.name, "b walk");
    assert_int_equal(fnl_scene_set_time(scene, 0, 2), FNL_OK);
    expect_position(light_at(scene, 0).position, 1, 2, 0); /* of the first file: it stays where it was */
    expect_position(light_at(scene, 1).position, 5, 0, 0);
    assert_int_equal(fnl_scene_remove_animation(scene, 0), FNL_OK);
    assert_int_equal(fnl_scene_set_time(scene, 0, 1), FNL_OK); /* as in a scene without animations */
    assert_int_equal(fnl_scene_set_time(scene, 1, 1), FNL_ERROR_INVALID);
    assert_int_equal(fnl_scene_remove_instance(scene, loaded.root), FNL_OK);
    fnl_scene_destroy(&scene);
    free(a);
    free(b);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_load_can_be_cancelled_at_every_step),
        cmocka_unit_test(test_a_file_becomes_part_of_a_scene),
        cmocka_unit_test(test_errors_leave_the_scene_as_it_was),
        cmocka_unit_test(test_files_go_with_their_last_user),
        cmocka_unit_test(test_what_is_used_stays_whole),
        cmocka_unit_test(test_rounds_of_loading_keep_memory_flat),
        cmocka_unit_test(test_rounds_of_adding_keep_memory_flat),
        cmocka_unit_test(test_removed_cameras_and_animations_are_skipped),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
