/* SPDX-License-Identifier: MIT */
/* fnl_scene_save: what is saved loads as what it was, what a file says is not lost, and the files keep the rules of GLB. */
#include "image/image.h"
#include "scene/gltf.h"
#include "scene/light_kinds.h"
#include "tests/gltf_test_file.h"

#include <setjmp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

static struct test_log lines;
static fnl_host plain; /* of the test itself */
static char folder[64], saved[96];

static int make_folder(void **state) {
    UNUSED(state);
    plain = host_resolve(NULL);
    strcpy(folder, "/tmp/fanal-save-XXXXXX");
    if (!mkdtemp(folder)) return -1;
    snprintf(saved, sizeof saved, "%s/saved.glb", folder);
    return 0;
}

static int remove_folder(void **state) {
    UNUSED(state);
    static const char *const names[] = {"saved.glb", "a.gltf", "masks.gltf", "seen.gltf", "a.bin", "b.bin", "a.png", "a.hdr"};
    char path[96];
    for (size_t i = 0; i < COUNT_OF(names); i++) {
        snprintf(path, sizeof path, "%s/%s", folder, names[i]);
        unlink(path);
    }
    return rmdir(folder); /* nothing else was left */
}

static const char *in_folder(const char *name) {
    static char path[96];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static void write_text(const char *name, const char *text) { assert_int_equal(file_save(&plain, in_folder(name), text, strlen(text)), FNL_OK); }

/* ---- a small validator ---- */

static uint32_t u32(const unsigned char *bytes) { return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24; }
static uint64_t number(const json_t *object, const char *key) { return (uint64_t)json_number_value(json_object_get(object, key)); }

static void check_accessors(json_t *root, const unsigned char *binary) {
    json_t *accessors = json_object_get(root, "accessors"), *views = json_object_get(root, "bufferViews"), *object;
    size_t i;
    json_array_foreach(accessors, i, object) {
        const char *type = json_string_value(json_object_get(object, "type"));
        const uint64_t component = number(object, "componentType"), width = component == 5123 ? 2 : component == 5121 ? 1 : 4;
        const uint64_t components = strcmp(type, "SCALAR") == 0 ? 1 : strcmp(type, "MAT4") == 0 ? 16 : (uint64_t)(type[3] - '0');
        json_t *view = json_array_get(views, number(object, "bufferView"));
        assert_non_null(view);
        const uint64_t stride = number(view, "byteStride") ? number(view, "byteStride") : components * width, offset = number(object, "byteOffset");
        assert_true(number(object, "count") > 0);
        assert_true(offset + (number(object, "count") - 1) * stride + components * width <= number(view, "byteLength"));
        assert_int_equal((number(view, "byteOffset") + offset) % width, 0);
    }
    json_t *mesh, *primitive;
    size_t m, p;
    json_array_foreach(json_object_get(root, "meshes"), m, mesh) json_array_foreach(json_object_get(mesh, "primitives"), p, primitive) {
        object = json_array_get(accessors, number(json_object_get(primitive, "attributes"), "POSITION"));
        json_t *view = json_array_get(views, number(object, "bufferView")), *low = json_object_get(object, "min"), *high = json_object_get(object, "max");
        assert_int_equal(json_array_size(low), 3);
        assert_int_equal(json_array_size(high), 3);
        struct box box = box_empty();
        for (uint64_t k = 0; k < number(object, "count"); k++) {
            vec3 v;
            memcpy(&v, binary + number(view, "byteOffset") + number(object, "byteOffset") + k * sizeof v, sizeof v);
            box_add_point(&box, v);
        }
        for (size_t c = 0; c < 3; c++) {
            assert_true((float)json_number_value(json_array_get(low, c)) == (&box.low.x)[c]);
            assert_true((float)json_number_value(json_array_get(high, c)) == (&box.high.x)[c]);
        }
    }
}

/* 4.4 of glTF 2.0, and that every byte belongs to a view but for padding. The JSON. */
static json_t *validate(bool whole) {
    struct file_view file;
    assert_int_equal(file_load(&plain, saved, &file), FNL_OK);
    assert_int_equal(u32(file.data), 0x46546c67);
    assert_int_equal(u32(file.data + 4), 2);
    assert_int_equal(u32(file.data + 8), file.size);
    assert_int_equal(file.size % 4, 0);
    const uint32_t length = u32(file.data + 12);
    assert_int_equal(u32(file.data + 16), 0x4e4f534a);
    assert_int_equal(length % 4, 0);
    json_t *root = json_loadb((const char *)file.data + 20, length, JSON_ALLOW_NUL, NULL);
    assert_non_null(root);
    const unsigned char *binary = file.data + 28 + length;
    if (file.size > 20 + length) {
        const uint32_t size = u32(file.data + 20 + length);
        assert_int_equal(u32(file.data + 24 + length), 0x004e4942);
        assert_int_equal(size % 4, 0);
        assert_int_equal(28 + length + size, file.size);
        json_t *buffers = json_object_get(root, "buffers"), *view;
        const uint64_t declared = number(json_array_get(buffers, 0), "byteLength");
        assert_true(declared <= size && size - declared < 4);
        assert_null(json_object_get(json_array_get(buffers, 0), "uri"));
        unsigned char *used = calloc(1, size);
        size_t i;
        json_array_foreach(json_object_get(root, "bufferViews"), i, view) {
            const uint64_t from = number(view, "byteOffset"), bytes = number(view, "byteLength");
            assert_int_equal(number(view, "buffer"), 0);
            assert_true(from + bytes <= declared && bytes > 0);
            memset(used + from, 1, bytes);
        }
        uint32_t gap = 0;
        for (uint32_t k = 0; k < size && whole; k++) {
            gap = used[k] ? 0 : gap + 1;
            assert_true(gap < 4);
        }
        free(used);
        check_accessors(root, binary);
    } else {
        assert_null(json_object_get(root, "buffers"));
    }
    file_free(&plain, &file);
    return root;
}

/* ---- comparing scenes ---- */

static fnl_scene *load(const char *path) {
    fnl_host host = test_host(&lines);
    fnl_scene *scene = NULL;
    if (fnl_scene_load(&host, path, NULL, &scene) != FNL_OK) fail_msg("%s:\n%s", path, lines.text);
    return scene;
}

static void save(const fnl_scene *scene) {
    if (fnl_scene_save(scene, saved, NULL) != FNL_OK) fail_msg("not saved:\n%s", lines.text);
}

static void same_bytes(const void *a, const void *b, size_t size) {
    assert_true(!a == !b);
    if (a) assert_memory_equal(a, b, size);
}

static void same_primitive(const struct scene_primitive *a, const struct scene_primitive *b) {
    assert_int_equal(a->vertex_count, b->vertex_count);
    assert_int_equal(a->index_count, b->index_count);
    assert_int_equal(a->material, b->material);
    assert_int_equal(a->topology, b->topology);
    const size_t count = a->vertex_count;
    same_bytes(a->indices, b->indices, a->index_count * sizeof *a->indices);
    same_bytes(a->positions, b->positions, count * sizeof(vec3));
    same_bytes(a->normals, b->normals, count * sizeof(vec3));
    same_bytes(a->tangents, b->tangents, count * sizeof(vec4));
    same_bytes(a->uv[0], b->uv[0], count * sizeof(vec2));
    same_bytes(a->uv[1], b->uv[1], count * sizeof(vec2));
    same_bytes(a->colors, b->colors, count * sizeof(vec4));
}

static void same_material(const struct scene_material *a, const struct scene_material *b) {
    assert_memory_equal(&a->base_color, &b->base_color, offsetof(struct scene_material, alpha_mode) - offsetof(struct scene_material, base_color));
    assert_int_equal(a->alpha_mode, b->alpha_mode);
    if (a->alpha_mode == FNL_ALPHA_MASK) assert_true(a->alpha_cutoff == b->alpha_cutoff);
    assert_true(a->double_sided == b->double_sided && a->unlit == b->unlit && a->casts_shadows == b->casts_shadows);
    assert_true(a->clearcoat.strength == b->clearcoat.strength && a->clearcoat.roughness == b->clearcoat.roughness);
    assert_memory_equal(a->sheen.color, b->sheen.color, 16);
    assert_memory_equal(&a->iridescence, &b->iridescence, 16);
    assert_memory_equal(&a->anisotropy, &b->anisotropy, 8);
    assert_true(a->transmission.strength == b->transmission.strength);
    assert_memory_equal(&a->volume, &b->volume, 20);
    assert_true(a->dispersion == b->dispersion);
    assert_memory_equal(&a->diffuse_transmission, &b->diffuse_transmission, 16);
    for (int i = 0; i < SCENE_TEXTURE_SLOT_COUNT; i++) {
        assert_true((a->textures[i].image == SCENE_NONE) == (b->textures[i].image == SCENE_NONE));
        if (a->textures[i].image == SCENE_NONE) continue;
        assert_int_equal(a->textures[i].uv_set, b->textures[i].uv_set);
        for (int k = 0; k < 6; k++) assert_true(a->textures[i].transform[k] == b->textures[i].transform[k]);
    }
}

static void same_light(const fnl_light_params *a, const fnl_light_params *b) {
    const fnl_light_kind_info *kind = fnl_light_kind_find(a->kind);
    assert_int_equal(a->kind, b->kind);
    assert_memory_equal(a->color, b->color, sizeof a->color);
    assert_true(a->intensity == b->intensity && a->casts_shadows == b->casts_shadows && a->shadow_update == b->shadow_update);
    assert_int_equal(a->mask, b->mask);
    assert_true(a->contact_scale == b->contact_scale);
    assert_true(kind->parallel ? a->source_angle == b->source_angle : a->source_radius == b->source_radius && a->range == b->range);
    if (kind->has_position) assert_memory_equal(&a->position, &b->position, sizeof a->position);
    if (kind->has_direction) assert_memory_equal(&a->direction, &b->direction, sizeof a->direction);
    /* It comes out of the node's axis and the direction, by a way on which some values cannot be met. */
    if (kind->has_up) assert_true(vec3_distance(a->up, b->up) < 2e-7f);
    for (uint32_t i = 0; i < kind->member_count; i++) {
        const fnl_light_member *m = &kind->members[i];
        assert_memory_equal(light_value_of(a, m), light_value_of(b, m), light_member_size(m));
    }
}

static void same_lights(const fnl_scene *a, const fnl_scene *b) {
    assert_int_equal(fnl_scene_count(a, FNL_ENTITY_LIGHT), fnl_scene_count(b, FNL_ENTITY_LIGHT));
    for (uint32_t i = 0; i < fnl_scene_count(a, FNL_ENTITY_LIGHT); i++) {
        fnl_light_params p, q;
        assert_int_equal(fnl_scene_query_light(a, i, &p), FNL_OK);
        assert_int_equal(fnl_scene_query_light(b, i, &q), FNL_OK);
        same_light(&p, &q);
    }
}

/* ---- scenes without a file ---- */

static void check_builtin(const char *source) {
    fnl_scene *made = load(source), *again;
    save(made);
    json_decref(validate(true));
    again = load(saved);
    if (lines.count) fail_msg("%s: warnings:\n%s", source, lines.text);
    assert_int_equal(made->meshes.count, again->meshes.count);
    assert_int_equal(made->primitives.count, again->primitives.count);
    for (uint32_t i = 0; i < made->primitives.count; i++) same_primitive(&made->primitives.data[i], &again->primitives.data[i]);
    assert_int_equal(made->materials.count, again->materials.count);
    for (uint32_t i = 0; i < made->materials.count; i++) same_material(&made->materials.data[i], &again->materials.data[i]);
    same_lights(made, again);
    assert_memory_equal(&made->ambient_sky, &again->ambient_sky, 3 * sizeof(vec3));
    assert_int_equal(made->cameras.count, again->cameras.count);
    fnl_scene_info p, q;
    fnl_scene_query_info(made, &p);
    fnl_scene_query_info(again, &q);
    assert_int_equal(p.triangle_count, q.triangle_count);
    assert_int_equal(p.instance_count, q.instance_count);
    fnl_scene_destroy(&made);
    fnl_scene_destroy(&again);
}

static void test_builtin_scenes_load_as_they_were(void **state) {
    UNUSED(state);
    check_builtin("builtin:spheres");
    check_builtin("builtin:hall?lights=30");
    check_builtin("builtin:glass");
}

static float between(struct random_state *r, float low, float high) { return random_range(r, low, high); }

static void test_lights_of_all_kinds_survive_to_the_bit(void **state) {
    UNUSED(state);
    enum { COUNT = 1200 };
    struct random_state r = {7};
    fnl_scene *scene, *again;
    fnl_host host = test_host(&lines);
    assert_int_equal(fnl_scene_create(&host, &scene), FNL_OK);
    for (uint32_t i = 0; i < COUNT; i++) {
        fnl_light_params p = fnl_light_params_default();
        fnl_light_id id;
        p.kind = (fnl_light_kind)(i % FNL_LIGHT_KIND_COUNT);
        p.position = vec3_make(between(&r, -100, 100), between(&r, -1e-3f, 1e-3f), between(&r, -3e4f, 3e4f));
        p.direction = i % 7 ? vec3_make(between(&r, -1, 1), between(&r, -1, 1), between(&r, -1, 1)) : vec3_make(0, -1, 0);
        p.up = i % 5 ? vec3_make(between(&r, -1, 1), between(&r, -1, 1), between(&r, -1, 1)) : vec3_make(0, 1, 0);
        for (int k = 0; k < 3; k++) p.color[k] = between(&r, 0, 2);
        p.intensity = between(&r, 0, 1e5f);
        p.range = i % 3 ? INFINITY : between(&r, 0.01f, 50);
        p.outer_cone_angle = between(&r, 0.1f, 1.5f);
        p.inner_cone_angle = p.outer_cone_angle * between(&r, 0, 0.99f);
        p.length = between(&r, 0, 5);
        p.wedge_angles[0] = between(&r, 0.01f, 1.4f);
        p.wedge_angles[1] = between(&r, 0.01f, 1.4f);
        p.box_size = vec3_make(between(&r, 0.1f, 9), between(&r, 0.1f, 9), between(&r, 0.1f, 9));
        p.inner_fraction = between(&r, 0, 1);
        p.casts_shadows = i % 2;
        p.shadow_update = i % 3 ? FNL_SHADOW_UPDATE_ALWAYS : FNL_SHADOW_UPDATE_ON_REQUEST;
        p.mask = i % 3 ? 255 : i & 255;
        p.contact_scale = i % 5 ? 1 : between(&r, 0, 3);
        p.source_radius = i % 4 ? 0 : between(&r, 0, 1);
        assert_int_equal(fnl_scene_add_light(scene, &p, &id), FNL_OK);
    }
    save(scene);
    again = load(saved);
    if (lines.count) fail_msg("warnings:\n%s", lines.text);
    same_lights(scene, again);
    fnl_scene_destroy(&scene);
    fnl_scene_destroy(&again);
}

static void test_pictures_and_materials_of_calls(void **state) {
    UNUSED(state);
    fnl_scene *scene, *again;
    fnl_host host = test_host(&lines);
    uint8_t pixels[5 * 3 * 4];
    fnl_image_id image;
    fnl_mesh_id mesh;
    fnl_instance_id instance;
    const mat4 place = {{1, 0, 0, 0, 0.25f, 2, 0, 0, 0, 0, -3, 0, 4, 5, 6, 1}}; /* sheared and mirrored */
    assert_int_equal(fnl_scene_create(&host, &scene), FNL_OK);
    for (uint32_t i = 0; i < sizeof pixels; i++) pixels[i] = (uint8_t)(i * 37 + i / 4);
    assert_int_equal(fnl_scene_add_image(scene, &(fnl_image){5, 3, FNL_PIXEL_FORMAT_RGBA8, pixels}, true, &image), FNL_OK);
    fnl_material_params m = fnl_material_params_default();
    m.base_color[1] = 0.1f;
    m.emissive[0] = 3.3f, m.emissive[1] = 1e-3f, m.emissive[2] = 700.1f;
    m.base_color_image = image;
    m.alpha_mode = FNL_ALPHA_MASK;
    m.alpha_cutoff = 0.3f;
    m.double_sided = true;
    m.casts_shadows = false;
    m.clearcoat = (fnl_clearcoat_params){.strength = 0.7f, .roughness = 0.1f, .image = image};
    m.sheen = (fnl_sheen_params){.color = {0.1f, 0.2f, 0.3f}, .roughness = 0.4f};
    m.iridescence = (fnl_iridescence_params){.strength = 0.3f, .ior = 1.7f, .thickness_minimum = 10, .thickness_maximum = 333};
    m.anisotropy = (fnl_anisotropy_params){.strength = 0.9f, .rotation = 1.1f};
    m.transmission.strength = 0.6f;
    m.volume = (fnl_volume_params){.thickness = 0.2f}; /* not attenuated, black */
    m.dispersion = 0.13f;
    m.diffuse_transmission = (fnl_diffuse_transmission_params){.strength = 0.2f, .color = {0.3f, 0, 1}};
    m.specular = 0.9f;
    m.specular_color[2] = 1.6f;
    m.ior = 0;
    const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0}, uv[] = {0, 0, 1, 0, 0, 1};
    fnl_mesh_params p = {.vertex_count = 3, .positions = positions, .uv = uv};
    assert_int_equal(fnl_scene_add_material(scene, &m, &p.material), FNL_OK);
    assert_int_equal(fnl_scene_add_mesh(scene, &p, &mesh), FNL_OK);
    assert_int_equal(fnl_scene_add_instance(scene, mesh, &place, &instance), FNL_OK);
    assert_int_equal(fnl_scene_set_instance_visible(scene, instance, false), FNL_OK);
    assert_int_equal(fnl_scene_add_camera(scene, "eye", &(fnl_camera){.position = {1, 2, 3}, .up = {0, 1, 0}, .orthographic = true, .vertical_extent = 7, .near_distance = 0.5f, .far_distance = 9, .pixel_aspect = 1, .view_mask = 5}), FNL_OK);
    save(scene);
    json_decref(validate(true));
    again = load(saved);
    same_primitive(&scene->primitives.data[0], &again->primitives.data[0]);
    same_material(&scene->materials.data[0], &again->materials.data[0]);
    assert_memory_equal(&scene->nodes.data[0].local_exact, &again->nodes.data[0].local_exact, sizeof(struct affine));
    assert_true(again->nodes.data[0].hidden && !again->nodes.data[0].active);
    fnl_camera camera;
    assert_int_equal(fnl_scene_query_camera(again, 0, &camera), FNL_OK);
    assert_true(camera.orthographic && camera.vertical_extent == 7 && camera.near_distance == 0.5f && camera.position.z == 3 && camera.view_mask == 5);
    const struct scene_image *picture = &again->images.data[again->materials.data[0].textures[SCENE_TEXTURE_BASE_COLOR].image];
    fnl_image decoded;
    assert_int_equal(image_decode(&host, picture->encoded, picture->encoded_size, "picture", true, &decoded), FNL_OK);
    assert_memory_equal(decoded.pixels, pixels, sizeof pixels);
    fnl_image_free(&host, &decoded);
    fnl_scene_destroy(&scene);
    fnl_scene_destroy(&again);
}

/* ---- scenes of files ---- */

static const char document[] =
    "{\"asset\": {\"version\": \"2.0\", \"generator\": \"hand\", \"extras\": {\"who\": \"ä\\u0001\", \"number\": 0.1234567890123456789, \"big\": 9007199254740993}},\n"
    "\"extensionsUsed\": [\"KHR_lights_punctual\", \"KHR_materials_clearcoat\", \"ACME_thing\"],\n"
    "\"extensions\": {\"ACME_thing\": {\"deep\": [1, 2.5, {\"x\": null}]}, \"KHR_lights_punctual\": {\"lights\": [\n"
    "  {\"type\": \"point\", \"name\": \"shared\", \"intensity\": 3, \"extras\": {\"own\": 1}},\n"
    "  {\"type\": \"spot\", \"spot\": {}, \"color\": [1, 0.5, 0.1], \"extensions\": {\"ACME_thing\": {\"kept\": true}}},\n"
    "  {\"type\": \"directional\", \"intensity\": 2}]}},\n"
    "\"scene\": 1, \"scenes\": [{\"name\": \"other\"}, {\"nodes\": [0, 1, 4, 5, 6], \"extras\": [7]}],\n"
    "\"nodes\": [{\"name\": \"top\", \"children\": [2, 3], \"rotation\": [0, 0.6, 0, 0.8], \"extras\": {\"n\": 1}},\n"
    "  {\"mesh\": 0, \"scale\": [2, 2, 2]},\n"
    "  {\"translation\": [0, 1, 0], \"extensions\": {\"KHR_lights_punctual\": {\"light\": 0}}},\n"
    "  {\"translation\": [0, 2, 0], \"extensions\": {\"KHR_lights_punctual\": {\"light\": 0}, \"ACME_thing\": {}}},\n"
    "  {\"extensions\": {\"KHR_lights_punctual\": {\"light\": 1}}}, {\"extensions\": {\"KHR_lights_punctual\": {\"light\": 2}}},\n"
    "  {\"mesh\": 0, \"translation\": [9, 0, 0], \"children\": [7]}, {\"name\": \"leaf\"}],\n"
    "\"buffers\": [{\"uri\": \"a%2Ebin\", \"byteLength\": 42, \"name\": \"first\"}, {\"byteLength\": 40, \"uri\": \"b.bin\"},\n"
    "  {\"byteLength\": 4, \"uri\": \"data:application/octet-stream;base64,AAECAw==\"}],\n"
    "\"bufferViews\": [{\"buffer\": 0, \"byteLength\": 36}, {\"buffer\": 0, \"byteOffset\": 36, \"byteLength\": 6},\n"
    "  {\"buffer\": 1, \"byteLength\": 8}, {\"buffer\": 1, \"byteOffset\": 8, \"byteLength\": 32}],\n"
    "\"accessors\": [{\"bufferView\": 0, \"componentType\": 5126, \"count\": 3, \"type\": \"VEC3\", \"min\": [0, 0, 0], \"max\": [1, 1, 0]},\n"
    "  {\"bufferView\": 1, \"componentType\": 5123, \"count\": 3, \"type\": \"SCALAR\"},\n"
    "  {\"bufferView\": 2, \"componentType\": 5126, \"count\": 2, \"type\": \"SCALAR\", \"min\": [0], \"max\": [1]},\n"
    "  {\"bufferView\": 3, \"componentType\": 5126, \"count\": 2, \"type\": \"VEC4\"}],\n"
    "\"images\": [{\"uri\": \"a.png\", \"name\": \"grey\", \"extras\": 5}], \"textures\": [{\"source\": 0}],\n"
    "\"materials\": [{\"name\": \"m\", \"pbrMetallicRoughness\": {\"baseColorTexture\": {\"index\": 0, \"extras\": 1}}, \"extensions\": {\"KHR_materials_clearcoat\": "
    "{\"clearcoatFactor\": 0.5, \"unknown\": 1}, \"ACME_thing\": {\"m\": 1}}}],\n"
    "\"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0}, \"indices\": 1, \"material\": 0, \"extras\": {\"p\": 1}}], \"extras\": 2}],\n"
    "\"animations\": [{\"samplers\": [{\"input\": 2, \"output\": 3}], \"channels\": [{\"sampler\": 0, \"target\": {\"node\": 0, \"path\": \"rotation\"}}]}]}";

static void write_document(void) {
    const float triangle[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0}, times[10] = {0, 1, 0, 0, 0, 1, 0, 1, 0, 0};
    const uint16_t indices[3] = {0, 1, 2};
    unsigned char bytes[42];
    memcpy(bytes, triangle, 36);
    memcpy(bytes + 36, indices, 6);
    assert_int_equal(file_save(&plain, in_folder("a.bin"), bytes, sizeof bytes), FNL_OK);
    assert_int_equal(file_save(&plain, in_folder("b.bin"), times, sizeof times), FNL_OK);
    assert_int_equal(file_save(&plain, in_folder("a.png"), test_png, sizeof test_png), FNL_OK);
    write_text("a.gltf", document);
}

static fnl_scene *load_document(void) {
    write_document();
    return load(in_folder("a.gltf"));
}

/* What stands there before it was moved into one buffer is taken out of both. */
static void strip_storage(json_t *root) {
    static const char *const storage[] = {"buffers", "bufferViews", "images"};
    for (size_t i = 0; i < COUNT_OF(storage); i++) json_object_del(root, storage[i]);
}

static void expect_json(json_t *a, json_t *b) {
    if (json_equal(a, b)) return;
    char *x = json_dumps(a, JSON_SORT_KEYS), *y = json_dumps(b, JSON_SORT_KEYS);
    fail_msg("%s\ninstead of\n%s", x, y);
}

static void test_an_unchanged_file_says_the_same(void **state) {
    UNUSED(state);
    fnl_scene *scene = load_document();
    assert_int_equal(fnl_scene_set_time(scene, 0, 0.4), FNL_OK); /* is no change */
    unlink(in_folder("a.bin"));                                   /* and nothing is read again */
    unlink(in_folder("b.bin"));
    unlink(in_folder("a.png"));
    save(scene);
    json_t *root = validate(false), *before = json_loads(document, JSON_ALLOW_NUL, NULL);
    json_t *image = json_array_get(json_object_get(root, "images"), 0);
    assert_string_equal(json_string_value(json_object_get(image, "mimeType")), "image/png");
    assert_string_equal(json_string_value(json_object_get(image, "name")), "grey");
    assert_int_equal(json_integer_value(json_object_get(image, "extras")), 5);
    assert_null(json_object_get(image, "uri"));
    assert_int_equal(json_array_size(json_object_get(root, "buffers")), 1);
    assert_string_equal(json_string_value(json_object_get(json_array_get(json_object_get(root, "buffers"), 0), "name")), "first");
    strip_storage(root);
    strip_storage(before);
    expect_json(root, before);
    json_decref(root);
    json_decref(before);
    fnl_scene *again = load(saved);
    same_primitive(&scene->primitives.data[0], &again->primitives.data[0]);
    same_material(&scene->materials.data[0], &again->materials.data[0]);
    assert_int_equal(fnl_scene_set_time(again, 0, 0.4), FNL_OK);
    for (uint32_t i = 0; i < scene->nodes.count; i++) assert_memory_equal(&scene->nodes.data[i].world, &again->nodes.data[i].world, sizeof(mat4));
    same_lights(scene, again);
    /* And once more, out of a .glb. */
    json_t *first = validate(false);
    save(again);
    json_t *second = validate(false);
    expect_json(second, first);
    json_decref(first);
    json_decref(second);
    fnl_scene_destroy(&scene);
    fnl_scene_destroy(&again);
}

/* All that it has is shown, before and after something stands around it. */
static void test_a_file_without_scenes_is_shown_whole(void **state) {
    UNUSED(state);
    for (int change = 0; change < 4; change++) {
        char text[sizeof document];
        write_document();
        strcpy(text, document);
        memcpy(strstr(text, "\"scene\": 1, "), "            ", 12); /* as long as what goes */
        char *from = strstr(text, "\"scenes\""), *to = strstr(text, "\"nodes\": [{\"name\"");
        memset(from, ' ', (size_t)(to - from));
        write_text("a.gltf", text);
        fnl_scene *scene = load(in_folder("a.gltf"));
        const vec3 sky = {1, 2, 3};
        const fnl_light_params lamp = fnl_light_params_default();
        fnl_light_id id;
        if (change == 1) assert_int_equal(fnl_scene_set_ambient(scene, sky, sky), FNL_OK);
        if (change == 2) assert_int_equal(fnl_scene_add_light(scene, &lamp, &id), FNL_OK);
        if (change == 3) assert_int_equal(fnl_scene_remove_instance(scene, (fnl_instance_id){6, scene->nodes.data[6].generation}), FNL_OK);
        save(scene);
        json_decref(validate(false));
        fnl_scene *again = load(saved);
        fnl_scene_info p, q;
        fnl_scene_query_info(scene, &p);
        fnl_scene_query_info(again, &q);
        assert_int_equal(p.instance_count, change == 3 ? 1 : 2);
        assert_int_equal(q.instance_count, p.instance_count);
        assert_memory_equal(&q.bounds_low, &p.bounds_low, 2 * sizeof p.bounds_low);
        same_lights(scene, again);
        fnl_scene_destroy(&scene);
        fnl_scene_destroy(&again);
    }
}

static fnl_entity_info entity(const fnl_scene *scene, fnl_entity kind, uint32_t index) {
    fnl_entity_info info;
    assert_int_equal(fnl_scene_query_entity(scene, kind, index, &info), FNL_OK);
    return info;
}

static void change_lights(fnl_scene *scene, fnl_light_params *moved) {
    fnl_light_params p;
    fnl_light_id id;
    fnl_scene_query_light(scene, 1, &p); /* of two that share theirs */
    p.intensity = 0.1f;
    p.casts_shadows = false;
    p.shadow_update = FNL_SHADOW_UPDATE_ON_REQUEST;
    p.mask = 6;
    assert_int_equal(fnl_scene_set_light(scene, entity(scene, FNL_ENTITY_LIGHT, 1).id.light, &p), FNL_OK);
    fnl_scene_query_light(scene, 2, &p); /* is put elsewhere */
    p.position = vec3_make(1.1f, 2.2f, 3.3f);
    p.direction = vec3_make(0.3f, -1, 0.2f);
    assert_int_equal(fnl_scene_set_light(scene, entity(scene, FNL_ENTITY_LIGHT, 2).id.light, &p), FNL_OK);
    fnl_scene_query_light(scene, 2, moved);
    assert_int_equal(fnl_scene_remove_light(scene, entity(scene, FNL_ENTITY_LIGHT, 3).id.light), FNL_OK);
    p = fnl_light_params_default();
    p.kind = FNL_LIGHT_BOX;
    p.box_size = vec3_make(1, 2, 3);
    assert_int_equal(fnl_scene_add_light(scene, &p, &id), FNL_OK);
}

static void test_changes_are_patched_in(void **state) {
    UNUSED(state);
    fnl_scene *scene = load_document();
    fnl_light_params moved, p;
    change_lights(scene, &moved);
    const mat4 place = {{1, 0.5f, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 7, 8, 9, 1}};
    assert_int_equal(fnl_scene_set_instance_transform(scene, entity(scene, FNL_ENTITY_INSTANCE, 1).id.instance, &place), FNL_OK);
    const mat4 turned = mat4_from_trs(vec3_make(1, 2, 3), quat_normalize((quat){0.1f, 0.2f, 0.3f, 0.9f}), vec3_make(1, 2, 3)); /* an animated node: no matrix */
    assert_int_equal(fnl_scene_set_instance_transform(scene, entity(scene, FNL_ENTITY_INSTANCE, 0).id.instance, &turned), FNL_OK);
    assert_int_equal(fnl_scene_set_instance_visible(scene, entity(scene, FNL_ENTITY_INSTANCE, 4).id.instance, false), FNL_OK);
    assert_int_equal(fnl_scene_set_instance_light_mask(scene, entity(scene, FNL_ENTITY_INSTANCE, 2).id.instance, 4), FNL_OK);
    assert_int_equal(fnl_scene_set_instance_view_mask(scene, entity(scene, FNL_ENTITY_INSTANCE, 3).id.instance, 9), FNL_OK);
    assert_int_equal(fnl_scene_remove_instance(scene, entity(scene, FNL_ENTITY_INSTANCE, 6).id.instance), FNL_OK);
    fnl_material_params m;
    fnl_scene_query_material(scene, 0, &m);
    m.roughness = 0.3f;
    m.clearcoat.strength = 0.75f;
    m.volume.thickness = 2;
    m.emissive[0] = 5;
    assert_int_equal(fnl_scene_set_material(scene, entity(scene, FNL_ENTITY_MATERIAL, 0).id.material, &m), FNL_OK);
    fnl_mesh_info mesh;
    fnl_scene_query_mesh(scene, 0, 0, &mesh);
    const float positions[] = {0, 0, 0, 3, 0, 0, 0, 3, 0.5f};
    mesh.params.positions = positions;
    mesh.params.normals = mesh.params.tangents = NULL;
    assert_int_equal(fnl_scene_set_mesh(scene, entity(scene, FNL_ENTITY_MESH, 0).id.mesh, 0, &mesh.params), FNL_OK);
    const vec3 sky = {1, 2, 3}, ground = {0, 0, 0.1f};
    assert_int_equal(fnl_scene_set_ambient(scene, sky, ground), FNL_OK);
    lines.count = 0;
    save(scene);
    assert_int_equal(lines.count, 0);
    json_t *root = validate(false), *nodes = json_object_get(root, "nodes"), *material = json_array_get(json_object_get(root, "materials"), 0);
    assert_non_null(json_object_get(json_array_get(nodes, 0), "rotation"));
    assert_null(json_object_get(json_array_get(nodes, 0), "matrix"));
    assert_non_null(json_object_get(json_array_get(nodes, 1), "matrix"));
    assert_null(json_object_get(json_array_get(nodes, 1), "scale"));
    /* What is beside stays. */
    assert_non_null(json_object_get(json_object_get(material, "extensions"), "ACME_thing"));
    json_t *coat = json_object_get(json_object_get(material, "extensions"), "KHR_materials_clearcoat");
    assert_int_equal(json_integer_value(json_object_get(coat, "unknown")), 1);
    json_t *documents = json_object_get(json_object_get(json_object_get(root, "extensions"), "KHR_lights_punctual"), "lights");
    assert_int_equal(json_array_size(documents), 5); /* the shared one has a copy, and the box is new */
    assert_int_equal(json_integer_value(json_object_get(json_object_get(json_array_get(documents, 3), "extras"), "own")), 1);
    assert_non_null(json_object_get(json_object_get(json_array_get(documents, 1), "extensions"), "ACME_thing"));
    json_decref(root);
    fnl_scene *again = load(saved);
    const mat4 locals[] = {scene_node_local(again, &again->nodes.data[0]), scene_node_local(again, &again->nodes.data[1])};
    assert_memory_equal(&locals[1], &place, sizeof place);
    for (int i = 0; i < 16; i++) assert_true(fabsf(locals[0].m[i] - turned.m[i]) < 1e-5f);
    assert_true(again->nodes.data[4].hidden && !again->nodes.data[6].active && !again->nodes.data[7].active);
    assert_int_equal(fnl_scene_count(again, FNL_ENTITY_LIGHT), 4 - 1 + 1);
    fnl_scene_query_light(again, 0, &p);
    assert_true(p.intensity == 3 && p.casts_shadows);
    fnl_scene_query_light(again, 1, &p);
    assert_true(p.intensity == 0.1f && !p.casts_shadows && p.shadow_update == FNL_SHADOW_UPDATE_ON_REQUEST && p.mask == 6);
    fnl_instance_info node;
    for (uint32_t i = 1; i < 4; i++) {
        fnl_scene_query_instance(again, i, &node);
        assert_int_equal(node.light_mask, i == 2 ? 4 : 255);
        assert_int_equal(node.view_mask, i == 3 ? 9 : 255);
    }
    fnl_scene_query_light(again, 2, &p);
    same_light(&p, &moved);
    same_material(&scene->materials.data[0], &again->materials.data[0]);
    assert_memory_equal(again->primitives.data[0].positions, positions, sizeof positions);
    assert_memory_equal(&again->ambient_sky, &sky, sizeof sky);
    assert_memory_equal(&again->ambient_ground, &ground, sizeof ground);
    fnl_scene_destroy(&scene);
    fnl_scene_destroy(&again);
}

static void test_what_was_added_to_a_file(void **state) {
    UNUSED(state);
    fnl_scene *scene = load_document(), *again;
    fnl_loaded loaded;
    assert_int_equal(fnl_scene_load_into(scene, entity(scene, FNL_ENTITY_INSTANCE, 1).id.instance, in_folder("a.gltf"), NULL, &loaded), FNL_OK);
    save(scene);
    json_decref(validate(false));
    again = load(saved);
    assert_int_equal(again->animations.count, 2);
    assert_int_equal(again->meshes.count, 2);
    assert_int_equal(fnl_scene_count(again, FNL_ENTITY_LIGHT), fnl_scene_count(scene, FNL_ENTITY_LIGHT));
    assert_int_equal(fnl_scene_set_time(scene, 1, 0.5), FNL_OK);
    assert_int_equal(fnl_scene_set_time(again, 1, 0.5), FNL_OK);
    fnl_scene_info p, q;
    fnl_scene_query_info(scene, &p);
    fnl_scene_query_info(again, &q);
    assert_int_equal(p.instance_count, q.instance_count);
    for (int i = 0; i < 3; i++) assert_true(fabsf((&p.bounds_low.x)[i] - (&q.bounds_low.x)[i]) < 1e-4f && fabsf((&p.bounds_high.x)[i] - (&q.bounds_high.x)[i]) < 1e-4f);
    fnl_scene_destroy(&scene);
    fnl_scene_destroy(&again);
}

/* Saving omits unloaded files and their holes, and writes only the remaining cameras and animations of the document. */
static void test_what_was_removed(void **state) {
    UNUSED(state);
    fnl_scene *scene = load_document(), *again;
    fnl_loaded loaded[2];
    uint32_t counts[FNL_ENTITY_COUNT];
    for (int kind = 0; kind < FNL_ENTITY_COUNT; kind++) counts[kind] = fnl_scene_count(scene, (fnl_entity)kind);
    for (int i = 0; i < 2; i++) assert_int_equal(fnl_scene_load_into(scene, (fnl_instance_id){0}, in_folder("a.gltf"), NULL, &loaded[i]), FNL_OK);
    const fnl_camera camera = fnl_camera_default();
    assert_int_equal(fnl_scene_remove_instance(scene, loaded[0].root), FNL_OK);
    assert_int_equal(fnl_scene_add_camera(scene, "added", &camera), FNL_OK); /* in a hole before those of the second file */
    save(scene);
    json_decref(validate(false));
    again = load(saved);
    for (int kind = 0; kind < FNL_ENTITY_COUNT; kind++)
        if (kind != FNL_ENTITY_INSTANCE && kind != FNL_ENTITY_METADATA && fnl_scene_count(again, (fnl_entity)kind) != fnl_scene_count(scene, (fnl_entity)kind))
            fail_msg("kind %d: %u, not %u", kind, fnl_scene_count(again, (fnl_entity)kind), fnl_scene_count(scene, (fnl_entity)kind));
    fnl_scene_destroy(&again);
    assert_int_equal(fnl_scene_remove_instance(scene, loaded[1].root), FNL_OK);
    assert_int_equal(fnl_scene_count(scene, FNL_ENTITY_CAMERA), counts[FNL_ENTITY_CAMERA] + 1);
    assert_int_equal(fnl_scene_remove_camera(scene, counts[FNL_ENTITY_CAMERA]), FNL_OK);
    assert_true(counts[FNL_ENTITY_ANIMATION] > 0);
    assert_int_equal(fnl_scene_remove_animation(scene, 0), FNL_OK);
    counts[FNL_ENTITY_ANIMATION]--;
    save(scene);
    json_decref(validate(false));
    again = load(saved);
    for (int kind = 0; kind < FNL_ENTITY_COUNT; kind++)
        if (kind != FNL_ENTITY_METADATA && fnl_scene_count(again, (fnl_entity)kind) != counts[kind])
            fail_msg("kind %d: %u, not %u", kind, fnl_scene_count(again, (fnl_entity)kind), counts[kind]);
    fnl_scene_destroy(&scene);
    fnl_scene_destroy(&again);

    write_text("seen.gltf", "{\"asset\":{\"version\":\"2.0\"},\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":1,\"znear\":0.1}}],"
                            "\"nodes\":[{\"camera\":0,\"name\":\"left\"},{\"camera\":0,\"name\":\"right\",\"translation\":[4,0,0]}],"
                            "\"scenes\":[{\"nodes\":[0,1]}],\"scene\":0}");
    scene = load(in_folder("seen.gltf"));
    assert_int_equal(fnl_scene_remove_camera(scene, 0), FNL_OK);
    save(scene);
    json_decref(validate(false));
    again = load(saved);
    fnl_camera right;
    assert_int_equal(fnl_scene_count(again, FNL_ENTITY_CAMERA), 1);
    assert_int_equal(fnl_scene_count(again, FNL_ENTITY_INSTANCE), 2);
    assert_int_equal(fnl_scene_query_camera(again, 0, &right), FNL_OK);
    assert_true(right.position.x == 4);
    fnl_scene_destroy(&scene);
    fnl_scene_destroy(&again);
}

/* Masks of a file that was loaded into a scene: those of instances, and one that was taken back. */
static void test_masks_of_what_was_added(void **state) {
    UNUSED(state);
    static const char text[] = "{\"asset\":{\"version\":\"2.0\"},\"extensionsUsed\":[\"EXT_mesh_gpu_instancing\"],\"buffers\":[{\"byteLength\":36,"
                               "\"uri\":\"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],"
                               "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[1,1,0]}],"
                               "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],\"scene\":0,\"scenes\":[{\"nodes\":[0,1]}],"
                               "\"nodes\":[{\"mesh\":0,\"extras\":{\"FNL_light_mask\":0,\"FNL_view_mask\":3},\"extensions\":{\"EXT_mesh_gpu_instancing\":"
                               "{\"attributes\":{\"TRANSLATION\":0}}}},{\"mesh\":0,\"name\":\"freed\",\"extras\":{\"FNL_light_mask\":4,\"x\":1}}]}";
    write_text("masks.gltf", text);
    fnl_scene *scene, *again;
    fnl_loaded loaded;
    const fnl_host host = fnl_host_default();
    assert_int_equal(fnl_scene_create(&host, &scene), FNL_OK);
    assert_int_equal(fnl_scene_load_into(scene, (fnl_instance_id){0}, in_folder("masks.gltf"), NULL, &loaded), FNL_OK);
    assert_true(scene->has_light_masks); /* a mask of 0 counts although all lights have 255 */
    for (uint32_t i = 0; i < scene->nodes.count; i++)
        if (scene->nodes.data[i].name && strcmp(scene->nodes.data[i].name, "freed") == 0)
            assert_int_equal(fnl_scene_set_instance_light_mask(scene, (fnl_instance_id){i, scene->nodes.data[i].generation}, 255), FNL_OK);
    save(scene);
    json_decref(validate(false));
    again = load(saved);
    uint32_t instances = 0, freed = 0;
    for (uint32_t i = 0; i < again->nodes.count; i++) {
        const struct scene_node *node = &again->nodes.data[i];
        if (node->mesh == SCENE_NONE) continue;
        const bool is_freed = node->name && strcmp(node->name, "freed") == 0;
        freed += is_freed;
        instances += is_freed ? 0 : node->instance_count ? node->instance_count : 1;
        assert_int_equal(node->unlit, is_freed ? 0 : 255);
        assert_int_equal(node->unseen, is_freed ? 0 : 252);
        if (is_freed) assert_string_equal(node->extras, "{\"x\":1}");
    }
    assert_int_equal(instances, 3);
    assert_int_equal(freed, 1);
    fnl_scene_destroy(&scene);
    fnl_scene_destroy(&again);
}

/* ---- surroundings ---- */

static void test_environments(void **state) {
    UNUSED(state);
    float pixels[8 * 4 * 4];
    for (size_t i = 0; i < COUNT_OF(pixels); i++) pixels[i] = 0.1f + (float)(i % 11);
    assert_int_equal(fnl_image_save(NULL, in_folder("a.hdr"), &(fnl_image){8, 4, FNL_PIXEL_FORMAT_RGBA32F, pixels}), FNL_OK);
    for (int of_file = 0; of_file < 2; of_file++) {
        fnl_scene *scene = load_document(), *again;
        fnl_environment_params e = fnl_environment_params_default();
        char path[96];
        snprintf(path, sizeof path, "%s", in_folder("a.hdr"));
        e.source = of_file ? path : "builtin:sky";
        e.rotation = 0.7f;
        e.intensity = 2;
        e.background = false;
        assert_int_equal(fnl_scene_set_environment(scene, &e), FNL_OK);
        assert_string_equal(fnl_scene_source(scene, 0), in_folder("a.gltf"));
        assert_non_null(fnl_scene_source(scene, 3)); /* a.bin, b.bin, a.png */
        assert_true(of_file ? strcmp(fnl_scene_source(scene, 4), path) == 0 : fnl_scene_source(scene, 4) == NULL);
        assert_null(fnl_scene_source(scene, 5));
        save(scene);
        json_decref(validate(false));
        again = load(saved);
        const struct scene_environment *a = &scene->environment, *b = &again->environment;
        assert_true(a->rotation == b->rotation && a->intensity == b->intensity && a->background == b->background && a->parted == b->parted);
        assert_int_equal(a->panorama.width, b->panorama.width);
        assert_memory_equal(a->panorama.texels, b->panorama.texels, sizeof(float) * 3 * a->panorama.width * a->panorama.height);
        same_lights(scene, again);
        save(again); /* and again, out of the file */
        fnl_scene *third = load(saved);
        assert_int_equal(third->environment.panorama.width, a->panorama.width);
        same_lights(scene, third);
        fnl_scene_destroy(&scene);
        fnl_scene_destroy(&again);
        fnl_scene_destroy(&third);
    }
}

static void test_probes(void **state) {
    UNUSED(state);
    fnl_scene *scene = load_document(), *again, *third;
    fnl_probe_params box = fnl_probe_params_default(), p;
    fnl_probe_id first, second;
    const fnl_probe_params usual = box;
    box.centre = vec3_make(0.1f, 2, 3);
    box.half_size = vec3_make(4, 0.3f, 5);
    box.rotation = (fnl_vec4){0, 0.6f, 0, 0.8f};
    box.capture.y = 0.2f;
    box.wall = 0.01f, box.softness = 2, box.blend = 0.7f, box.intensity = 0.1f;
    box.face_size = 64, box.priority = -3;
    box.shadows = false, box.reflection = true, box.mask = 5;
    assert_int_equal(fnl_scene_add_probe(scene, &box, &first), FNL_OK);
    assert_int_equal(fnl_scene_add_probe(scene, &usual, &second), FNL_OK);
    save(scene);
    again = load(saved);
    assert_int_equal(fnl_scene_count(again, FNL_ENTITY_PROBE), 2);
    fnl_scene_query_probe(scene, 0, &box); /* as it is kept */
    fnl_scene_query_probe(again, 0, &p);
    assert_memory_equal(&p.centre, &box.centre, 13 * sizeof(float));
    assert_true(p.wall == box.wall && p.softness == 2 && p.blend == 0.7f && p.intensity == 0.1f && p.face_size == 64 && p.priority == -3 && p.mask == 5 && !p.shadows && p.reflection);
    fnl_scene *host; /* a merged probe's mask counts as one that was added */
    fnl_loaded loaded;
    assert_int_equal(fnl_scene_create(&again->host, &host), FNL_OK);
    assert_int_equal(fnl_scene_load_into(host, (fnl_instance_id){0}, saved, NULL, &loaded), FNL_OK);
    assert_true(host->has_light_masks);
    fnl_scene_destroy(&host);
    assert_int_equal(fnl_scene_remove_probe(again, entity(again, FNL_ENTITY_PROBE, 0).id.probe), FNL_OK);
    assert_int_equal(fnl_scene_remove_probe(again, entity(again, FNL_ENTITY_PROBE, 0).id.probe), FNL_OK);
    save(again);
    third = load(saved);
    assert_int_equal(fnl_scene_count(third, FNL_ENTITY_PROBE), 0);
    fnl_scene_destroy(&scene);
    fnl_scene_destroy(&again);
    fnl_scene_destroy(&third);
}

/* ---- what goes wrong ---- */

/* Saved places are doubles: of a file's moved nodes, and of entities added near a distant origin that moved since. */
static void test_places_far_away(void **state) {
    UNUSED(state);
    static const double far[3] = {6371000, -48, 0.3}, home[3] = {0, 0, 0};
    for (int of_file = 0; of_file < 2; of_file++) {
        fnl_scene *scene = of_file ? load_document() : NULL;
        if (!of_file) assert_int_equal(fnl_scene_load(NULL, "builtin:spheres?lights=3", NULL, &scene), FNL_OK);
        fnl_light_params light = fnl_light_params_default();
        fnl_probe_params probe = fnl_probe_params_default();
        fnl_camera camera = fnl_camera_default();
        fnl_light_id light_id;
        fnl_probe_id probe_id;
        fnl_instance_id instance;
        const mat4 moved = mat4_from_trs(vec3_make(0.7f, 0.1f, 0), quat_axis_angle(vec3_make(0, 1, 0), 0.3f), vec3_make(2, 1, 1));
        light.kind = FNL_LIGHT_SPOT;
        light.position = probe.centre = camera.position = vec3_make(0.3f, 0.7f, 0.9f);
        assert_int_equal(fnl_scene_set_origin(scene, far), FNL_OK);
        assert_int_equal(fnl_scene_add_light(scene, &light, &light_id), FNL_OK);
        assert_int_equal(fnl_scene_add_probe(scene, &probe, &probe_id), FNL_OK);
        assert_int_equal(fnl_scene_add_camera(scene, "own", &camera), FNL_OK);
        assert_int_equal(fnl_scene_add_instance(scene, (fnl_mesh_id){0, FIRST_GENERATION}, &moved, &instance), FNL_OK);
        const fnl_instance_id root = {0, scene->nodes.data[0].generation};
        assert_int_equal(fnl_scene_set_instance_transform(scene, root, &moved), FNL_OK);
        assert_int_equal(fnl_scene_set_origin(scene, home), FNL_OK);
        save(scene);
        json_decref(validate(false));
        fnl_scene *again = load(saved);
        assert_int_equal(fnl_scene_set_origin(again, far), FNL_OK);
        assert_int_equal(fnl_scene_set_origin(scene, far), FNL_OK);
        for (uint32_t i = 0; i < scene->nodes.count; i++) {
            const struct scene_node *a = &scene->nodes.data[i], *b = &again->nodes.data[i];
            if (a->instances) continue; /* saved as nodes */
            for (int k = 0; k < 3; k++) assert_true(fabs(a->world_exact.m[9 + k] - b->world_exact.m[9 + k]) <= 1e-8);
            for (int k = 0; k < 9; k++) assert_true(fabs(a->world_exact.m[k] - b->world_exact.m[k]) <= 1e-6);
        }
        fnl_camera copy;
        assert_int_equal(fnl_scene_query_camera(again, fnl_scene_count(again, FNL_ENTITY_CAMERA) - 1, &copy), FNL_OK);
        const struct scene_light *last = &again->lights.data[again->lights.count - 1];
        const vec3 places[] = {last->params.position, copy.position, again->probes.data[again->probes.count - 1].params.centre};
        for (int k = 0; k < 3; k++)
            if (!(vec3_distance(places[k], light.position) < 2e-7f)) fail_msg("%d is at %.9g %.9g %.9g", k, (double)places[k].x, (double)places[k].y, (double)places[k].z);
        fnl_scene_destroy(&scene);
        fnl_scene_destroy(&again);
    }
}

static bool exists(const char *path) {
    struct stat status;
    return stat(path, &status) == 0;
}

static void test_errors_leave_no_file(void **state) {
    UNUSED(state);
    fnl_scene *scene = load_document();
    unlink(saved);
    assert_int_equal(fnl_scene_save(scene, "/tmp/fanal-no-such-folder/x.glb", NULL), FNL_ERROR_FILE);
    assert_non_null(strstr(lines.text, "/tmp/fanal-no-such-folder/x.glb"));
    for (uint32_t size = 0; size < 4000; size += 100) {
        const fnl_save_params params = {.max_size = size};
        const fnl_result result = fnl_scene_save(scene, saved, &params);
        assert_true(result == FNL_ERROR_UNSUPPORTED || (size > 2000 && result == FNL_OK));
        assert_int_equal(exists(saved), result == FNL_OK);
    }
    assert_true(exists(saved));
    /* A file that is there stays as it was. */
    json_t *before = validate(false);
    assert_int_equal(fnl_scene_save(scene, saved, &(fnl_save_params){.max_size = 1000}), FNL_ERROR_UNSUPPORTED);
    json_t *after = validate(false);
    expect_json(after, before);
    json_decref(before);
    json_decref(after);
    fnl_scene_destroy(&scene);
}

/* A reference to something that the file does not have stays one, whatever the file gets when it is saved. */
static void test_dangling_references_stay_so(void **state) {
    UNUSED(state);
    write_document();
    write_text("a.gltf", "{\"asset\": {\"version\": \"2.0\"}, \"extensionsUsed\": [\"KHR_lights_punctual\"], \"scenes\": [{\"nodes\": [0, 1, 2, 3]}], \"scene\": 0,\n"
                         "\"nodes\": [{\"extensions\": {\"KHR_lights_punctual\": {\"light\": 0}}}, {\"mesh\": 1.0, \"camera\": 0, \"children\": [4]}, {\"mesh\": 0}],\n"
                         "\"buffers\": [{\"uri\": \"a.bin\", \"byteLength\": 42}], \"bufferViews\": [{\"buffer\": 0, \"byteLength\": 36}],\n"
                         "\"accessors\": [{\"bufferView\": 0, \"componentType\": 5126, \"count\": 3, \"type\": \"VEC3\"}],\n"
                         "\"materials\": [{\"emissiveTexture\": {\"index\": 0}}],\n"
                         "\"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0, \"TEXCOORD_0\": 1}, \"material\": 1}]}]}");
    fnl_scene *scene = load(in_folder("a.gltf")), *again;
    uint8_t pixel[4] = {9, 8, 7, 255};
    const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0}, uv[] = {0, 0, 1, 0, 0, 1};
    const mat4 place = mat4_identity();
    fnl_material_params m = fnl_material_params_default();
    fnl_mesh_params p = {.vertex_count = 3, .positions = positions, .uv = uv};
    const fnl_light_params lamp = fnl_light_params_default();
    const fnl_camera camera = fnl_camera_default();
    fnl_mesh_id mesh;
    fnl_instance_id instance;
    fnl_light_id light;
    assert_int_equal(fnl_scene_add_image(scene, &(fnl_image){1, 1, FNL_PIXEL_FORMAT_RGBA8, pixel}, true, &m.base_color_image), FNL_OK);
    assert_int_equal(fnl_scene_add_material(scene, &m, &p.material), FNL_OK);
    assert_int_equal(fnl_scene_add_mesh(scene, &p, &mesh), FNL_OK);
    assert_int_equal(fnl_scene_add_instance(scene, mesh, &place, &instance), FNL_OK);
    assert_int_equal(fnl_scene_add_light(scene, &lamp, &light), FNL_OK);
    assert_int_equal(fnl_scene_add_camera(scene, "eye", &camera), FNL_OK);
    save(scene);
    again = load(saved);
    assert_int_equal(fnl_scene_count(again, FNL_ENTITY_LIGHT), 1);
    assert_int_equal(again->meshes.count, 2);
    assert_int_equal(again->cameras.count, 1);
    assert_int_equal(again->nodes.data[1].mesh, SCENE_NONE);
    assert_int_equal(again->nodes.data[1].camera, SCENE_NONE);
    assert_int_equal(again->nodes.data[1].first_child, SCENE_NONE);
    assert_int_equal(again->primitives.data[0].material, SCENE_NONE);
    assert_null(again->primitives.data[0].uv[0]);
    assert_int_equal(again->materials.data[0].textures[SCENE_TEXTURE_EMISSIVE].image, SCENE_NONE);
    fnl_scene_destroy(&scene);
    fnl_scene_destroy(&again);
}

static void test_what_is_left_out_is_told(void **state) {
    UNUSED(state);
    fnl_host host = test_host(&lines);
    fnl_scene *scene;
    fnl_probe_id probe;
    fnl_light_id light;
    const vec3 points[] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const fnl_light_params lamp = fnl_light_params_default();
    const fnl_probe_params box = fnl_probe_params_default();
    assert_int_equal(fnl_scene_create(&host, &scene), FNL_OK);
    save(scene); /* of nothing at all */
    json_decref(validate(true));
    assert_int_equal(lines.count, 0);
    assert_int_equal(fnl_scene_add_probe(scene, &box, &probe), FNL_OK);
    assert_int_equal(fnl_scene_add_light(scene, &lamp, &light), FNL_OK);
    assert_int_equal(fnl_scene_set_light_hull(scene, light, points, 4), FNL_OK);
    assert_int_equal(fnl_scene_scatter_decals(scene, 0, 1), FNL_OK);
    assert_int_equal(fnl_scene_set_light_cutoff(scene, 0.5f, 0.05f), FNL_OK);
    save(scene);
    assert_int_equal(lines.count, 2);
    assert_non_null(strstr(lines.text, "left out: the hulls of 1 lights"));
    fnl_scene_destroy(&scene);
}

/* JSON cannot hold such a name: the file gets one that is near to it. */
static void test_names_that_are_not_utf8_are_told(void **state) {
    UNUSED(state);
    fnl_host host = test_host(&lines);
    fnl_scene *scene;
    const fnl_camera camera = fnl_camera_default();
    assert_int_equal(fnl_scene_create(&host, &scene), FNL_OK);
    assert_int_equal(fnl_scene_add_camera(scene, "t\xfcr", &camera), FNL_OK);
    save(scene);
    assert_non_null(strstr(lines.text, "saved.glb: left out: bytes of the name 't?r' that are not UTF-8"));
    json_t *root = validate(true);
    json_t *first = json_array_get(json_object_get(root, "cameras"), 0);
    assert_string_equal(json_string_value(json_object_get(first, "name")), "t?r");
    json_decref(root);
    fnl_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_builtin_scenes_load_as_they_were),
        cmocka_unit_test(test_lights_of_all_kinds_survive_to_the_bit),
        cmocka_unit_test(test_pictures_and_materials_of_calls),
        cmocka_unit_test(test_an_unchanged_file_says_the_same),
        cmocka_unit_test(test_a_file_without_scenes_is_shown_whole),
        cmocka_unit_test(test_dangling_references_stay_so),
        cmocka_unit_test(test_changes_are_patched_in),
        cmocka_unit_test(test_what_was_added_to_a_file),
        cmocka_unit_test(test_what_was_removed),
        cmocka_unit_test(test_masks_of_what_was_added),
        cmocka_unit_test(test_environments),
        cmocka_unit_test(test_probes),
        cmocka_unit_test(test_places_far_away),
        cmocka_unit_test(test_errors_leave_no_file),
        cmocka_unit_test(test_what_is_left_out_is_told),
        cmocka_unit_test(test_names_that_are_not_utf8_are_told),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
