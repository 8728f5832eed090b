/* SPDX-License-Identifier: MIT */
/* What the importer makes of files: primitive modes, materials, nodes, skins, morphs, animations, sample models. */
#include "tests/gltf_test_file.h"
#include "tests/stand_in.h"

#include <meshoptimizer.h>
#include <setjmp.h>

#include <cmocka.h>

static struct test_log file_log;

/** Loads a file that must load without any complaint. */
static fnl_scene *load_clean(const char *json, const void *binary, size_t size) {
    fnl_scene *scene = NULL;
    fnl_result result = test_load(&file_log, json, binary, size, &scene);
    if (result != FNL_OK || file_log.count) fail_msg("%s", file_log.text);
    return scene;
}

#define ASSET "\"asset\":{\"version\":\"2.0\"}"

/* ---- primitive modes ---- */

static void test_modes_expand_to_plain_primitives(void **state) {
    UNUSED(state);
    static const struct {
        uint32_t mode;
        enum scene_topology topology;
        uint32_t count, indices[12];
    } cases[] = {
        {0, SCENE_TOPOLOGY_POINTS, 5, {4, 3, 2, 1, 0}},
        {2, SCENE_TOPOLOGY_LINES, 10, {4, 3, 3, 2, 2, 1, 1, 0, 0, 4}},
        {3, SCENE_TOPOLOGY_LINES, 8, {4, 3, 3, 2, 2, 1, 1, 0}},
        {5, SCENE_TOPOLOGY_TRIANGLES, 9, {4, 3, 2, 3, 1, 2, 2, 1, 0}},
        {6, SCENE_TOPOLOGY_TRIANGLES, 9, {3, 2, 4, 2, 1, 4, 1, 0, 4}},
    };
    struct {
        float positions[15], normals[15];
        uint8_t indices[8];
    } binary = {0};
    for (int i = 0; i < 15; i++) binary.positions[i] = (float)(i * i % 7);
    for (int i = 0; i < 5; i++) binary.normals[i * 3 + 2] = 1;
    for (int i = 0; i < 5; i++) binary.indices[i] = (uint8_t)(4 - i);
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        char json[1024];
        snprintf(json, sizeof json,
                 "{" ASSET ",\"buffers\":[{\"byteLength\":128}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":60},"
                 "{\"buffer\":0,\"byteOffset\":60,\"byteLength\":60},{\"buffer\":0,\"byteOffset\":120,\"byteLength\":5}],"
                 "\"accessors\":["
                 "{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":5},"
                 "{\"bufferView\":1,\"componentType\":5126,\"type\":\"VEC3\",\"count\":5},"
                 "{\"bufferView\":2,\"componentType\":5121,\"type\":\"SCALAR\",\"count\":5}],"
                 "\"meshes\":[{\"primitives\":[{\"mode\":%u,\"indices\":2,\"attributes\":{\"POSITION\":0,\"NORMAL\":1}}]}]}",
                 cases[i].mode);
        fnl_scene *scene = load_clean(json, &binary, sizeof binary);
        const struct scene_primitive *primitive = &scene->primitives.data[0];
        assert_int_equal(primitive->topology, cases[i].topology);
        assert_int_equal(primitive->index_count, cases[i].count);
        assert_memory_equal(primitive->indices, cases[i].indices, cases[i].count * sizeof(uint32_t));
        assert_memory_equal(primitive->positions, binary.positions, sizeof binary.positions);
        fnl_scene_destroy(&scene);
    }
}

/** A primitive that names few vertices of a big shared buffer keeps those alone. */
static void test_unused_vertices_are_dropped(void **state) {
    UNUSED(state);
    static struct {
        float positions[3000], normals[3000];
        uint16_t indices[4];
    } binary;
    for (int i = 0; i < 3000; i++) binary.positions[i] = (float)i;
    for (int i = 0; i < 1000; i++) binary.normals[i * 3] = 1;
    uint16_t indices[3] = {999, 5, 500};
    memcpy(binary.indices, indices, sizeof indices);
    fnl_scene *scene = load_clean(
        "{" ASSET
        ",\"buffers\":[{\"byteLength\":24008}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":24000,\"byteStride\":12},"
        "{\"buffer\":0,\"byteOffset\":24000,\"byteLength\":6}],\"accessors\":["
        "{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":1000},"
        "{\"bufferView\":0,\"byteOffset\":12000,\"componentType\":5126,\"type\":\"VEC3\",\"count\":1000},"
        "{\"bufferView\":1,\"componentType\":5123,\"type\":\"SCALAR\",\"count\":3}],"
        "\"meshes\":[{\"primitives\":[{\"indices\":2,\"attributes\":{\"POSITION\":0,\"NORMAL\":1}}]}]}",
        &binary, sizeof binary);
    const struct scene_primitive *primitive = &scene->primitives.data[0];
    assert_int_equal(primitive->vertex_count, 3);
    for (uint32_t i = 0; i < 3; i++) {
        assert_int_equal(primitive->indices[i], i);
        assert_true(primitive->positions[i].x == (float)indices[i] * 3 && primitive->normals[i].x == 1);
    }
    fnl_scene_destroy(&scene);
}

/* Set 0 runs along x, set 1 along y; the normal texture reads set 1, and so must the tangents. */
static void test_tangents_follow_the_normal_texture(void **state) {
    UNUSED(state);
    static const struct {
        vec3 positions[3], normals[3];
        vec2 uv0[3], uv1[3];
    } binary = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
                {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}},
                {{0, 0}, {1, 0}, {0, 1}},
                {{0, 0}, {0, 1}, {1, 0}}};
    for (int set = 0; set < 2; set++) {
        char json[2048];
        snprintf(json, sizeof json,
                 "{" ASSET ",\"buffers\":[{\"byteLength\":120}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},"
                 "{\"buffer\":0,\"byteOffset\":36,\"byteLength\":36},{\"buffer\":0,\"byteOffset\":72,\"byteLength\":24},"
                 "{\"buffer\":0,\"byteOffset\":96,\"byteLength\":24}],"
                 "\"images\":[{\"uri\":\"data:image/png;base64,"
                 "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAAC0lEQVR4nGP4DwQACfsD/fteaysAAAAASUVORK5CYII=\"}],"
                 "\"textures\":[{\"source\":0}],\"materials\":[{\"normalTexture\":{\"index\":0,\"texCoord\":%d}}],"
                 "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3},"
                 "{\"bufferView\":1,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3},"
                 "{\"bufferView\":2,\"componentType\":5126,\"type\":\"VEC2\",\"count\":3},"
                 "{\"bufferView\":3,\"componentType\":5126,\"type\":\"VEC2\",\"count\":3}],"
                 "\"meshes\":[{\"primitives\":[{\"material\":0,\"attributes\":{\"POSITION\":0,\"NORMAL\":1,"
                 "\"TEXCOORD_0\":2,\"TEXCOORD_1\":3}}]}]}",
                 set);
        fnl_scene *scene = load_clean(json, &binary, sizeof binary);
        const struct scene_primitive *primitive = &scene->primitives.data[0];
        vec4 tangent = primitive->tangents[0];
        assert_true((set ? tangent.y : tangent.x) > 0.999f);
        for (uint32_t i = 0; i < 3; i++) { /* the sets themselves stay where they were */
            const vec3 p = primitive->positions[i];
            assert_true(primitive->uv[0][i].x == p.x && primitive->uv[1][i].x == p.y);
        }
        fnl_scene_destroy(&scene);
    }
}

/* ---- materials ---- */

static void test_materials_and_textures(void **state) {
    UNUSED(state);
    /* A PNG of 1x1 white pixel, used once as colour and once as data. */
    fnl_scene *scene = load_clean(
        "{" ASSET ",\"extensionsUsed\":[\"KHR_texture_transform\",\"KHR_materials_emissive_strength\",\"KHR_materials_ior\","
        "\"KHR_materials_specular\",\"KHR_materials_unlit\"],"
        "\"images\":[{\"uri\":\"data:image/png;base64,"
        "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAAC0lEQVR4nGP4DwQACfsD/fteaysAAAAASUVORK5CYII=\"}],"
        "\"samplers\":[{\"magFilter\":9728,\"minFilter\":9985,\"wrapS\":33071,\"wrapT\":33648}],"
        "\"textures\":[{\"source\":0,\"sampler\":0},{\"source\":0}],"
        "\"materials\":[{\"name\":\"paint\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.1,0.2,0.3,0.4],"
        "\"metallicFactor\":0.5,"
        "\"roughnessFactor\":0.6,\"baseColorTexture\":{\"index\":0,\"texCoord\":1,\"extensions\":{\"KHR_texture_transform\":"
        "{\"offset\":[3,4],\"scale\":[2,5],\"rotation\":1.5707963267948966}}}},"
        "\"normalTexture\":{\"index\":1,\"scale\":0.7},\"occlusionTexture\":{\"index\":1,\"strength\":0.8},"
        "\"emissiveFactor\":[0.5,1,0],\"alphaMode\":\"MASK\",\"alphaCutoff\":0.3,\"doubleSided\":true,"
        "\"extensions\":{\"KHR_materials_emissive_strength\":{\"emissiveStrength\":1000},\"KHR_materials_ior\":{\"ior\":1."
        "33},"
        "\"KHR_materials_specular\":{\"specularFactor\":0.25,\"specularColorFactor\":[1,2,3]}}},"
        "{\"alphaMode\":\"BLEND\",\"extensions\":{\"KHR_materials_unlit\":{}}}]}",
        NULL, 0);
    const struct scene_material *m = &scene->materials.data[0];
    assert_string_equal(m->name, "paint");
    assert_true(m->base_color.x == 0.1f && m->base_color.w == 0.4f && m->metallic == 0.5f && m->roughness == 0.6f);
    assert_true(m->emissive.x == 500 && m->emissive.y == 1000 && m->emissive.z == 0);
    assert_true(m->ior == 1.33f && m->specular == 0.25f && m->specular_color.z == 3);
    assert_true(m->normal_scale == 0.7f && m->occlusion_strength == 0.8f && m->alpha_cutoff == 0.3f);
    assert_true(m->alpha_mode == FNL_ALPHA_MASK && m->double_sided && !m->unlit);
    assert_true(scene->materials.data[1].unlit && scene->materials.data[1].alpha_mode == FNL_ALPHA_BLEND);

    const struct scene_texture *base = &m->textures[SCENE_TEXTURE_BASE_COLOR], *normal = &m->textures[SCENE_TEXTURE_NORMAL];
    assert_int_equal(base->uv_set, 1);
    /* Turned by 90 degrees counter-clockwise in a picture whose v points down: u' = 5 v + 3, v' = -2 u + 4. */
    const float expected[6] = {0, 5, 3, -2, 0, 4};
    for (int i = 0; i < 6; i++) assert_true(fabsf(base->transform[i] - expected[i]) < 1e-6f);
    assert_int_equal(scene->images.count, 2);
    assert_true(scene->images.data[base->image].color && !scene->images.data[normal->image].color);
    assert_ptr_equal(scene->images.data[base->image].encoded, scene->images.data[normal->image].encoded);
    assert_true(scene->images.data[0].width == 1 && strcmp(scene->images.data[0].file_kind, "png") == 0);
    const struct scene_sampler *sampler = &scene->samplers.data[base->sampler];
    assert_true(sampler->mag == SCENE_FILTER_NEAREST && sampler->min == SCENE_FILTER_LINEAR &&
                sampler->mip == SCENE_FILTER_NEAREST);
    assert_true(sampler->mipmapped && sampler->wrap_u == SCENE_WRAP_CLAMP && sampler->wrap_v == SCENE_WRAP_MIRROR);
    assert_int_equal(normal->sampler, 0);
    fnl_scene_destroy(&scene);
}

/* ---- nodes ---- */

static void test_scenes_visibility_and_instancing(void **state) {
    UNUSED(state);
    struct {
        float positions[9], normals[9], places[6];
    } binary = {{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 0, 1, 0, 0, 1, 0, 0, 1}, {10, 0, 0, 20, 0, 0}};
    fnl_scene *scene = load_clean(
        "{" ASSET ",\"extensionsUsed\":[\"KHR_node_visibility\",\"EXT_mesh_gpu_instancing\",\"KHR_lights_punctual\"],"
        "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"point\",\"intensity\":7}]}},"
        "\"buffers\":[{\"byteLength\":96}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":96,\"byteStride\":12}],"
        "\"accessors\":["
        "{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3},"
        "{\"bufferView\":0,\"byteOffset\":36,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3},"
        "{\"bufferView\":0,\"byteOffset\":72,\"componentType\":5126,\"type\":\"VEC3\",\"count\":2}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1}}]}],"
        "\"nodes\":[{\"children\":[1,2],\"translation\":[0,5,0],\"scale\":[2,2,2]},"
        "{\"mesh\":0,\"extensions\":{\"EXT_mesh_gpu_instancing\":{\"attributes\":{\"TRANSLATION\":2}}}},"
        "{\"children\":[3],\"extensions\":{\"KHR_node_visibility\":{\"visible\":false}}},"
        "{\"mesh\":0,\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}},"
        "{\"mesh\":0,\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}}],"
        "\"scenes\":[{\"nodes\":[4]},{\"nodes\":[0]}],\"scene\":1}",
        &binary, sizeof binary);
    const bool active[5] = {true, true, false, false, false};
    for (uint32_t i = 0; i < 5; i++) assert_int_equal(scene->nodes.data[i].active, active[i]);
    assert_int_equal(scene->lights.count, 1); /* of the hidden node; none of node 4, which is in another scene */
    assert_int_equal(scene->lights.data[0].node, 3);
    fnl_scene_info info;
    assert_int_equal(fnl_scene_query_info(scene, &info), FNL_OK);
    assert_int_equal(info.instance_count, 2);
    assert_int_equal(info.triangle_count, 2);
    assert_true(info.bounds_low.x == 20 && info.bounds_high.x == 42 && info.bounds_low.y == 5 && info.bounds_high.y == 7);
    const bool visible[5] = {true, true, false, true, false};
    for (uint32_t i = 0; i < 5; i++) {
        fnl_instance_info node;
        assert_int_equal(fnl_scene_query_instance(scene, i, &node), FNL_OK);
        assert_true(node.visible == visible[i] && node.shown == active[i]);
    }
    for (uint32_t i = 2; i < 5; i += 2) { /* what the file hides can be shown */
        fnl_entity_info node;
        assert_int_equal(fnl_scene_query_entity(scene, FNL_ENTITY_INSTANCE, i, &node), FNL_OK);
        assert_int_equal(fnl_scene_set_instance_visible(scene, node.id.instance, true), FNL_OK);
    }
    assert_int_equal(fnl_scene_query_info(scene, &info), FNL_OK);
    assert_int_equal(info.instance_count, 4);
    fnl_scene_destroy(&scene);
}

/* ---- skins, morphs, animations ---- */

static void test_skin_morph_and_animation(void **state) {
    UNUSED(state);
    struct {
        float positions[9], normals[9], deltas[9];
        uint8_t joints[12], weights[12];
        float inverse_bind[32], times[2], weight_keys[4], rotation_keys[24];
    } binary = {
        .positions = {0, 0, 0, 1, 0, 0, 0, 1, 0},
        .normals = {0, 0, 1, 0, 0, 1, 0, 0, 1},
        .deltas = {0, 0, 1, 0, 0, 1, 0, 0, 1},
        .joints = {1, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0},
        .weights = {255, 0, 0, 0, 51, 204, 0, 0, 254, 0, 0, 0}, /* the last is 1 but for rounding */
        .inverse_bind = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -3, 0, 1},
        .times = {0.5f, 2},
        .weight_keys = {0, 1, 1, 0}};
    for (int i = 0; i < 6; i++) binary.rotation_keys[i * 4 + 3] = 1;
    fnl_scene *scene = load_clean(
        "{" ASSET ",\"buffers\":[{\"byteLength\":380}],\"bufferViews\":["
        "{\"buffer\":0,\"byteLength\":108,\"byteStride\":12},{\"buffer\":0,\"byteOffset\":108,\"byteLength\":24,"
        "\"byteStride\":4},"
        "{\"buffer\":0,\"byteOffset\":132,\"byteLength\":128},{\"buffer\":0,\"byteOffset\":260,\"byteLength\":120}],"
        "\"accessors\":["
        "{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3},"
        "{\"bufferView\":0,\"byteOffset\":36,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3},"
        "{\"bufferView\":0,\"byteOffset\":72,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3},"
        "{\"bufferView\":1,\"componentType\":5121,\"type\":\"VEC4\",\"count\":3},"
        "{\"bufferView\":1,\"byteOffset\":12,\"componentType\":5121,\"normalized\":true,\"type\":\"VEC4\",\"count\":3},"
        "{\"bufferView\":2,\"componentType\":5126,\"type\":\"MAT4\",\"count\":2},"
        "{\"bufferView\":3,\"componentType\":5126,\"type\":\"SCALAR\",\"count\":2},"
        "{\"bufferView\":3,\"byteOffset\":8,\"componentType\":5126,\"type\":\"SCALAR\",\"count\":4},"
        "{\"bufferView\":3,\"byteOffset\":24,\"componentType\":5126,\"type\":\"VEC4\",\"count\":6}],"
        "\"meshes\":[{\"weights\":[0.25,0.5],\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1,\"JOINTS_0\":3,"
        "\"WEIGHTS_0\":4},"
        "\"targets\":[{\"POSITION\":2},{\"NORMAL\":2}]}]}],"
        "\"nodes\":[{\"children\":[1]},{\"translation\":[0,3,0]},{\"mesh\":0,\"skin\":0,\"weights\":[0.75,0.125]}],"
        "\"skins\":[{\"joints\":[0,1],\"inverseBindMatrices\":5,\"skeleton\":0}],"
        "\"animations\":[{\"name\":\"wave\",\"samplers\":[{\"input\":6,\"output\":7,\"interpolation\":\"STEP\"},"
        "{\"input\":6,\"output\":8,\"interpolation\":\"CUBICSPLINE\"}],"
        "\"channels\":[{\"sampler\":0,\"target\":{\"node\":2,\"path\":\"weights\"}},{\"sampler\":1,\"target\":{\"node\":1,"
        "\"path\":\"rotation\"}}]}]}",
        &binary, sizeof binary);
    const struct scene_primitive *primitive = &scene->primitives.data[0];
    assert_int_equal(primitive->joint_count, 4);
    assert_int_equal(primitive->joints[0], 1);
    assert_true(primitive->weights[0] == 1 && fabsf(primitive->weights[4] - 0.2f) < 1e-6f &&
                fabsf(primitive->weights[5] - 0.8f) < 1e-6f);
    assert_true(primitive->weights[8] == 1);
    assert_int_equal(primitive->morph_target_count, 2);
    assert_true(primitive->morph_targets[0].positions[1].z == 1 && !primitive->morph_targets[0].normals &&
                primitive->morph_targets[1].normals);
    assert_true(scene->meshes.data[0].morph_weights[1] == 0.5f && scene->nodes.data[2].morph_weights[0] == 0.75f);
    assert_true(scene->skins.data[0].joint_count == 2 && scene->skins.data[0].inverse_bind[1].m[13] == -3);
    const struct scene_animation *animation = &scene->animations.data[0];
    assert_true(animation->channel_count == 2 && animation->duration == 2 && strcmp(animation->name, "wave") == 0);
    assert_true(animation->channels[0].width == 2 && animation->channels[0].interpolation == SCENE_INTERPOLATION_STEP);
    assert_true(animation->channels[1].width == 4 && animation->channels[1].interpolation == SCENE_INTERPOLATION_CUBIC);
    assert_memory_equal(animation->channels[0].values, binary.weight_keys, sizeof binary.weight_keys);
    fnl_scene_destroy(&scene);
}

/* ---- EXT_meshopt_compression ---- */

static void test_meshopt_views(void **state) {
    UNUSED(state);
    float vertices[12 * 6]; /* position and normal */
    uint32_t indices[36];
    struct random_state random = {3};
    for (int i = 0; i < 12; i++) {
        for (int k = 0; k < 3; k++) vertices[i * 6 + k] = random_range(&random, -1, 1);
        vertices[i * 6 + 3] = vertices[i * 6 + 4] = 0;
        vertices[i * 6 + 5] = 1;
    }
    for (uint32_t i = 0; i < 36; i++) indices[i] = i / 3 % 10 + i % 3;
    unsigned char binary[4096] = {0};
    size_t vertex_size = meshopt_encodeVertexBuffer(binary, 2048, vertices, 12, 24);
    meshopt_encodeIndexVersion(1);
    size_t index_size = meshopt_encodeIndexBuffer(binary + 2048, 2048, indices, 36);
    assert_true(vertex_size > 0 && index_size > 0);
    char json[2048];
    snprintf(
        json, sizeof json,
        "{" ASSET ",\"extensionsUsed\":[\"EXT_meshopt_compression\"],\"extensionsRequired\":[\"EXT_meshopt_compression\"],"
        "\"buffers\":[{\"byteLength\":4096},{\"byteLength\":1000,\"extensions\":{\"EXT_meshopt_compression\":{\"fallback\":"
        "true}}}],"
        "\"bufferViews\":[{\"buffer\":1,\"byteLength\":288,\"byteStride\":24,\"extensions\":{\"EXT_meshopt_compression\":"
        "{\"buffer\":0,\"byteLength\":%zu,\"byteStride\":24,\"mode\":\"ATTRIBUTES\",\"count\":12}}},"
        "{\"buffer\":1,\"byteOffset\":288,\"byteLength\":72,\"extensions\":{\"EXT_meshopt_compression\":"
        "{\"buffer\":0,\"byteOffset\":2048,\"byteLength\":%zu,\"byteStride\":2,\"mode\":\"TRIANGLES\",\"count\":36}}}],"
        "\"accessors\":["
        "{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":12},"
        "{\"bufferView\":0,\"byteOffset\":12,\"componentType\":5126,\"type\":\"VEC3\",\"count\":12},"
        "{\"bufferView\":1,\"componentType\":5123,\"type\":\"SCALAR\",\"count\":36}],"
        "\"meshes\":[{\"primitives\":[{\"indices\":2,\"attributes\":{\"POSITION\":0,\"NORMAL\":1}}]}]}",
        vertex_size, index_size);
    fnl_scene *scene = load_clean(json, binary, sizeof binary);
    const struct scene_primitive *primitive = &scene->primitives.data[0];
    assert_int_equal(primitive->index_count, 36);
    for (uint32_t i = 0; i < 12; i++) assert_memory_equal(&primitive->positions[i], vertices + i * 6, 12);
    for (uint32_t i = 0; i < 36; i += 3) { /* the code may turn a triangle, so that another corner comes first */
        bool same = false;
        for (uint32_t turn = 0; turn < 3; turn++)
            same |= primitive->indices[i] == indices[i + turn] && primitive->indices[i + 1] == indices[i + (turn + 1) % 3];
        assert_true(same);
    }
    fnl_scene_destroy(&scene);
    binary[20] ^= 0x55; /* broken data is found, not decoded into rubbish beyond the end */
    binary[2060] ^= 0xff;
    for (size_t cut = 1; cut < vertex_size; cut += 7) {
        char *length = strstr(json, "\"mode\":\"ATTRIBUTES\"");
        assert_non_null(length);
        char broken[2048];
        snprintf(broken, sizeof broken, "%s", json);
        char needle[64], *at;
        snprintf(needle, sizeof needle, "\"byteLength\":%zu,\"byteStride\":24,\"mode\"", vertex_size);
        at = strstr(broken, needle);
        assert_non_null(at);
        at += strlen("\"byteLength\":");
        for (size_t digits = (size_t)snprintf(NULL, 0, "%zu", vertex_size), i = 0; i < digits; i++)
            at[i] = i + 1 < digits ? ' ' : '1';
        assert_int_equal(test_load(&file_log, broken, binary, sizeof binary, &scene), FNL_OK);
        assert_non_null(
            strstr(file_log.text, "/bufferViews/0/extensions/EXT_meshopt_compression: the compressed data is broken"));
        fnl_scene_destroy(&scene);
    }
}

/* ---- sample models ---- */

/** A sample, or its stand-in if `made` is set or the sample is missing. */
static fnl_scene *load_sample(const char *name, bool made) {
    fnl_scene *scene;
    fnl_host host = test_host(&file_log);
    fnl_load_params params = fnl_load_params_default();
    const char *path = made ? NULL : stand_in_sample(name);
    unsigned char *model = path ? NULL : stand_in_model(name, &params.size);
    params.data = model;
    assert_int_equal(fnl_scene_load(&host, path ? path : name, &params, &scene), FNL_OK);
    if (model && file_log.count) fail_msg("%s", file_log.text);
    free(model);
    return scene;
}

static void test_sample_counts(void **state) {
    UNUSED(state);
    /* Of stand-ins: a ball of r rings and s segments has 2 s (r - 1) triangles and (r + 1)(s + 1) vertices; a tube 2 s r triangles, and a joint is a node. */
    enum {
        HELMET_TRIANGLES = 2 * (16 * 39 + 24 * 23 + 24 * 15 + 2 * 16 * 15 + 32 * 31 + 24 * 11) + 12,
        HELMET_VERTICES = 41 * 17 + 25 * 25 + 17 * 25 + 2 * 17 * 17 + 33 * 33 + 13 * 25 + 24,
    };
    static const struct {
        const char *name;
        bool made; /* the stand-in, otherwise the sample */
        uint32_t triangles, vertices, meshes, materials, images, nodes, skins, animations;
    } cases[] = {
        {"FlightHelmet/FlightHelmet.gltf", false, 94722, 55392, 6, 6, 15, 6, 0, 0},
        {"DamagedHelmet.glb", false, 15452, 14556, 1, 1, 5, 1, 0, 0},
        {"Fox.glb", false, 576, 1728, 1, 1, 1, 26, 1, 3},
        {"CesiumMan.glb", false, 4672, 3572, 1, 1, 1, 22, 1, 1},
        {"CornellBox.glb", false, 36, 74, 4, 5, 0, 4, 0, 0},
        {"gltf_primitives.glb", false, 12, 24, 1, 4, 0, 1, 0, 0},
        {"FlightHelmet/FlightHelmet.gltf", true, HELMET_TRIANGLES, HELMET_VERTICES, 6, 6, 15, 6, 0, 0},
        {"DamagedHelmet.glb", true, 2 * 64 * 59, 61 * 65, 1, 1, 5, 1, 0, 0},
        {"Fox.glb", true, 2 * 6 * 48, 49 * 7, 1, 1, 1, 25, 1, 3},
        {"CesiumMan.glb", true, 2 * 28 * 83, 84 * 29, 1, 1, 1, 20, 1, 1},
        {"CornellBox.glb", true, 12 + 12 + 2 * 6, 24 + 24 + 4 * 6, 4, 5, 0, 4, 0, 0},
        {"gltf_primitives.glb", true, 12, 24, 1, 4, 0, 1, 0, 0},
        {"materials/SheenChair/SheenChair.gltf", true, 3 * 12 + 2 * (32 * 15 + 24 * 11) + 2, 3 * 24 + 17 * 33 + 13 * 25 + 4, 4, 6, 7, 4, 0, 0},
    };
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        if (!cases[i].made && !stand_in_sample(cases[i].name)) continue;
        fnl_scene *scene = load_sample(cases[i].name, cases[i].made);
        fnl_scene_info info;
        assert_int_equal(fnl_scene_query_info(scene, &info), FNL_OK);
        assert_int_equal(info.triangle_count, cases[i].triangles);
        assert_int_equal(info.unique_vertex_count, cases[i].vertices);
        assert_int_equal(info.mesh_count, cases[i].meshes);
        assert_int_equal(info.material_count, cases[i].materials);
        assert_int_equal(info.image_count, cases[i].images);
        assert_int_equal(info.node_count, cases[i].nodes);
        assert_int_equal(info.skin_count, cases[i].skins);
        assert_int_equal(info.animation_count, cases[i].animations);
        for (uint32_t k = 0; k < info.image_count; k++) assert_true(scene->images.data[k].width > 0);
        for (uint32_t k = 0; k < scene->primitives.count; k++) assert_non_null(scene->primitives.data[k].normals);
        fnl_scene_destroy(&scene);
    }
}

/** The primitives of the file make up a cube, each in another mode: every triangle faces away from the centre. */
static void check_primitive_modes(bool made) {
    fnl_scene *scene = load_sample("gltf_primitives.glb", made);
    assert_int_equal(scene->primitives.count, 4);
    for (uint32_t i = 0; i < scene->primitives.count; i++) {
        const struct scene_primitive *p = &scene->primitives.data[i];
        for (uint32_t k = 0; k + 2 < p->index_count; k += 3) {
            vec3 a = p->positions[p->indices[k]], b = p->positions[p->indices[k + 1]], c = p->positions[p->indices[k + 2]];
            vec3 n = vec3_cross(vec3_sub(b, a), vec3_sub(c, a));
            assert_true(vec3_dot(n, vec3_add(a, vec3_add(b, c))) > 0);
        }
    }
    fnl_scene_destroy(&scene);
}

static void test_sample_primitive_modes(void **state) {
    UNUSED(state);
    check_primitive_modes(false);
    check_primitive_modes(true);
}

static void check_lights(bool made) {
    fnl_scene *scene = load_sample("Lights.glb", made);
    fnl_scene_info info;
    assert_int_equal(fnl_scene_query_info(scene, &info), FNL_OK);
    assert_true(info.light_count == 4 && info.light_kind_counts[FNL_LIGHT_DIRECTIONAL] == 1 && info.light_kind_counts[FNL_LIGHT_POINT] == 1 &&
                info.light_kind_counts[FNL_LIGHT_SPOT] == 2);
    fnl_light_params point, spot, sun;
    assert_int_equal(fnl_scene_query_light(scene, 0, &point), FNL_OK);
    assert_true(point.kind == FNL_LIGHT_POINT && point.intensity == 5 && point.color[0] == 1 && point.color[1] == 0 &&
                isinf(point.range));
    assert_true(vec3_distance(point.position, vec3_make(2.599f, 3.569f, -1.005f)) < 1e-3f);
    assert_int_equal(fnl_scene_query_light(scene, 1, &spot), FNL_OK);
    assert_true(spot.kind == FNL_LIGHT_SPOT && spot.intensity == 10 && fabsf(spot.outer_cone_angle - 0.392699f) < 1e-4f);
    assert_true(fabsf(vec3_length(spot.direction) - 1) < 1e-5f);
    assert_int_equal(fnl_scene_query_light(scene, 3, &sun), FNL_OK);
    assert_true(sun.kind == FNL_LIGHT_DIRECTIONAL && fabsf(sun.intensity - 1) < 1e-6f && sun.color[1] == 1 &&
                sun.color[2] == 1);
    fnl_scene_destroy(&scene);
}

static void test_sample_lights(void **state) {
    UNUSED(state);
    check_lights(false);
    check_lights(true);
}

static fnl_scene *load_example(const char *path) {
    fnl_scene *scene;
    fnl_host host = test_host(&file_log);
    assert_int_equal(fnl_scene_load(&host, path, NULL, &scene), FNL_OK);
    return scene;
}

/* The sample of the documentation: shapes in extras, posed by their nodes. */
static void test_light_shapes_in_extras(void **state) {
    UNUSED(state);
    fnl_scene *scene = load_example("examples/light_shapes.gltf");
    fnl_scene_info info;
    assert_int_equal(fnl_scene_query_info(scene, &info), FNL_OK);
    for (int kind = FNL_LIGHT_POINT; kind <= FNL_LIGHT_BOX; kind++) assert_int_equal(info.light_kind_counts[kind], 1);
    fnl_light_params capsule, wedge, box;
    assert_int_equal(fnl_scene_query_light(scene, 2, &capsule), FNL_OK);
    assert_int_equal(fnl_scene_query_light(scene, 3, &wedge), FNL_OK);
    assert_int_equal(fnl_scene_query_light(scene, 4, &box), FNL_OK);
    assert_true(capsule.kind == FNL_LIGHT_CAPSULE && capsule.length == 2 && capsule.direction.x > 0.9f);
    assert_true(wedge.kind == FNL_LIGHT_WEDGE && wedge.wedge_angles[0] == 0.36f && wedge.wedge_angles[1] == 0.2f);
    assert_true(box.kind == FNL_LIGHT_BOX && box.box_size.z == 5 && box.inner_fraction == 0.85f);
    assert_true(fabsf(vec3_dot(wedge.up, wedge.direction)) < 1e-5f && fabsf(vec3_length(wedge.up) - 1) < 1e-5f);
    assert_true(wedge.up.z < -0.8f && wedge.direction.y < -0.8f);
    fnl_scene_destroy(&scene);

    static const char json[] =
        "{" ASSET ",\"extensionsUsed\":[\"KHR_lights_punctual\"],\"extensions\":{\"KHR_lights_punctual\":{\"lights\":["
        "{\"type\":\"point\",\"extras\":{\"FNL_light_shapes\":{\"shape\":\"egg\"}}},"
        "{\"type\":\"spot\",\"spot\":{},\"extras\":[1,2]},"
        "{\"type\":\"point\",\"extras\":{\"FNL_light_shapes\":{\"shape\":\"wedge\",\"wedgeAngles\":[9,0.5]}}},"
        "{\"type\":\"point\",\"extras\":{\"FNL_light_shapes\":{\"shape\":\"rectangle\",\"rectangleSize\":[0.5,2],\"twoSided\":true}}}]}},"
        "\"nodes\":[{\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}},"
        "{\"extensions\":{\"KHR_lights_punctual\":{\"light\":1}}},{\"extensions\":{\"KHR_lights_punctual\":{\"light\":2}}},"
        "{\"extensions\":{\"KHR_lights_punctual\":{\"light\":3}}}]}";
    size_t size;
    unsigned char *glb = test_glb(json, NULL, 0, &size);
    fnl_host host = test_host(&file_log);
    assert_int_equal(gltf_load_memory(&host, glb, size, "shapes.glb", NULL, &scene), FNL_OK);
    free(glb);
    assert_non_null(strstr(file_log.text, "/lights/0/extras/FNL_light_shapes/shape: is none of capsule, wedge, box"));
    assert_non_null(strstr(file_log.text, "wedgeAngles"));
    assert_int_equal(file_log.count, 2);
    const fnl_light_params *panel = &scene->lights.data[3].params;
    assert_true(panel->kind == FNL_LIGHT_RECTANGLE && panel->rectangle_size[0] == 0.5f && panel->rectangle_size[1] == 2 && panel->two_sided);
    assert_int_equal(scene->lights.data[0].params.kind, FNL_LIGHT_POINT);
    assert_int_equal(scene->lights.data[1].params.kind, FNL_LIGHT_SPOT);
    assert_int_equal(scene->lights.data[2].params.kind, FNL_LIGHT_WEDGE);
    assert_true(scene->lights.data[2].params.wedge_angles[0] == 1.5f &&
                scene->lights.data[2].params.wedge_angles[1] == 0.5f);
    fnl_scene_destroy(&scene);
}

/* The scene of a document without buffers; what is told of it goes to `file_log`. */
static fnl_scene *load_logged(const char *json, const char *name) {
    size_t size;
    unsigned char *glb = test_glb(json, NULL, 0, &size);
    fnl_host host = test_host(&file_log);
    fnl_scene *scene;
    assert_int_equal(gltf_load_memory(&host, glb, size, name, NULL, &scene), FNL_OK);
    free(glb);
    return scene;
}

/* What materials say of shadows. */
static void test_material_shadows_in_extras(void **state) {
    UNUSED(state);
    static const char json[] = "{" ASSET ",\"materials\":[{\"extras\":{\"FNL_material_shadows\":{\"castsShadows\":false},\"mine\":1}},"
                               "{\"extras\":{\"FNL_material_shadows\":{\"castsShadows\":1}}},{\"extras\":[2]},{\"extras\":{\"FNL_material_shadows\":3}}]}";
    fnl_scene *scene = load_logged(json, "shadows.glb");
    assert_non_null(strstr(file_log.text, "/materials/1/extras/FNL_material_shadows/castsShadows: is a number, not a boolean"));
    assert_non_null(strstr(file_log.text, "/materials/3/extras/FNL_material_shadows"));
    assert_int_equal(file_log.count, 2);
    for (uint32_t i = 0; i < 4; i++) assert_int_equal(scene->materials.data[i].casts_shadows, i > 0);
    fnl_scene_destroy(&scene);
}

/* Masks of lights and nodes; what is none is warned of. */
static void test_light_masks_in_extras(void **state) {
    UNUSED(state);
    static const char json[] =
        "{" ASSET ",\"extensionsUsed\":[\"KHR_lights_punctual\"],\"extensions\":{\"KHR_lights_punctual\":{\"lights\":["
        "{\"type\":\"point\",\"extras\":{\"FNL_light_mask\":6}},{\"type\":\"point\",\"extras\":{\"FNL_light_mask\":256}},{\"type\":\"point\"}]}},"
        "\"nodes\":[{\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}},\"extras\":{\"FNL_light_mask\":3,\"FNL_view_mask\":12}},"
        "{\"extensions\":{\"KHR_lights_punctual\":{\"light\":1}},\"extras\":{\"FNL_light_mask\":\"all\"}},{\"extensions\":{\"KHR_lights_punctual\":{\"light\":2}}}]"
        "}";
    fnl_scene *scene = load_logged(json, "masks.glb");
    assert_non_null(strstr(file_log.text, "/lights/1/extras/FNL_light_mask"));
    assert_non_null(strstr(file_log.text, "/nodes/1/extras/FNL_light_mask"));
    assert_int_equal(file_log.count, 2);
    static const uint32_t lights[] = {6, 255, 255}, nodes[] = {3, 255, 255};
    for (uint32_t i = 0; i < 3; i++) {
        fnl_instance_info node;
        assert_int_equal(scene->lights.data[i].params.mask, lights[i]);
        assert_int_equal(fnl_scene_query_instance(scene, i, &node), FNL_OK);
        assert_int_equal(node.light_mask, nodes[i]);
        assert_int_equal(node.view_mask, i == 0 ? 12 : 255);
    }
    assert_true(scene->has_light_masks);
    fnl_scene_destroy(&scene);
}

/* What lights say of their shadows; what is no such thing is warned of. */
static void test_light_shadows_in_extras(void **state) {
    UNUSED(state);
    static const char json[] =
        "{" ASSET ",\"extensionsUsed\":[\"KHR_lights_punctual\"],\"extensions\":{\"KHR_lights_punctual\":{\"lights\":["
        "{\"type\":\"point\",\"extras\":{\"FNL_light_shadows\":{\"castsShadows\":false,\"sourceRadius\":0.25,\"update\":\"on-request\"}}},"
        "{\"type\":\"point\",\"extras\":{\"FNL_light_shadows\":{\"castsShadows\":0}}},"
        "{\"type\":\"directional\",\"extras\":{\"FNL_light_shadows\":{\"sourceAngle\":-3,\"update\":\"sometimes\"}}}]}},"
        "\"nodes\":[{\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}},"
        "{\"extensions\":{\"KHR_lights_punctual\":{\"light\":1}}},{\"extensions\":{\"KHR_lights_punctual\":{\"light\":2}}}]"
        "}";
    fnl_scene *scene = load_logged(json, "shadows.glb");
    assert_non_null(strstr(file_log.text, "/lights/1/extras/FNL_light_shadows/castsShadows: is a number, not a boolean"));
    assert_non_null(strstr(file_log.text, "/lights/2/extras/FNL_light_shadows/sourceAngle"));
    assert_non_null(strstr(file_log.text, "/lights/2/extras/FNL_light_shadows/update: is neither always nor on-request"));
    assert_int_equal(file_log.count, 3);
    for (uint32_t i = 0; i < 3; i++) assert_int_equal(scene->lights.data[i].params.shadow_update, i == 0 ? FNL_SHADOW_UPDATE_ON_REQUEST : FNL_SHADOW_UPDATE_ALWAYS);
    for (uint32_t i = 0; i < 3; i++) assert_int_equal(scene->lights.data[i].params.casts_shadows, i > 0);
    assert_true(scene->lights.data[0].params.source_radius == 0.25f && scene->lights.data[1].params.source_radius == 0);
    assert_true(scene->lights.data[2].params.source_angle == 0);
    fnl_scene_destroy(&scene);
}

static void check_cameras(bool made) {
    fnl_scene *scene = load_sample("geometry-camera-light.glb", made);
    fnl_camera camera;
    assert_int_equal(fnl_scene_count(scene, FNL_ENTITY_CAMERA), 2);
    assert_int_equal(fnl_scene_query_camera(scene, 1, &camera), FNL_OK);
    assert_true(camera.orthographic && fabsf(camera.vertical_extent - 27) < 0.1f);
    uint32_t index = 9;
    fnl_entity_info entity;
    assert_int_equal(fnl_scene_query_entity(scene, FNL_ENTITY_CAMERA, 1, &entity), FNL_OK);
    assert_int_equal(fnl_scene_find(scene, FNL_ENTITY_CAMERA, entity.name, &index), FNL_OK);
    assert_int_equal(index, 1);
    fnl_scene_destroy(&scene);
}

static void test_sample_cameras(void **state) {
    UNUSED(state);
    check_cameras(false);
    check_cameras(true);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_modes_expand_to_plain_primitives),
        cmocka_unit_test(test_unused_vertices_are_dropped),
        cmocka_unit_test(test_tangents_follow_the_normal_texture),
        cmocka_unit_test(test_materials_and_textures),
        cmocka_unit_test(test_scenes_visibility_and_instancing),
        cmocka_unit_test(test_skin_morph_and_animation),
        cmocka_unit_test(test_meshopt_views),
        cmocka_unit_test(test_sample_counts),
        cmocka_unit_test(test_sample_primitive_modes),
        cmocka_unit_test(test_sample_lights),
        cmocka_unit_test(test_light_shapes_in_extras),
        cmocka_unit_test(test_material_shadows_in_extras),
        cmocka_unit_test(test_light_masks_in_extras),
        cmocka_unit_test(test_light_shadows_in_extras),
        cmocka_unit_test(test_sample_cameras),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
