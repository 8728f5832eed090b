/* SPDX-License-Identifier: MIT */
/* KHR_animation_pointer: every property at several times, every interpolation, and what cannot be animated. */
#include "tests/gltf_test_file.h"

#include <setjmp.h>

#include <cmocka.h>

static struct test_log file_log;

/* ---- a file that has everything once ---- */

#define TURNED "\"index\":0,\"extensions\":{\"KHR_texture_transform\":{\"offset\":[0.125,0.25],\"scale\":[2,3],\"rotation\":0.5}}"
#define FLOATS(type, count, offset)                                                                                         \
    "{\"bufferView\":0,\"byteOffset\":" #offset ",\"componentType\":5126,\"type\":\"" type "\",\"count\":" #count "}"

static const char head[] =
    "{\"asset\":{\"version\":\"2.0\"},\"extensionsUsed\":[\"KHR_animation_pointer\",\"KHR_texture_transform\",\"KHR_lights_punctual\","
    "\"KHR_node_visibility\",\"KHR_materials_emissive_strength\",\"KHR_materials_ior\",\"KHR_materials_specular\",\"KHR_materials_clearcoat\","
    "\"KHR_materials_sheen\",\"KHR_materials_iridescence\",\"KHR_materials_anisotropy\","
    "\"KHR_materials_transmission\",\"KHR_materials_volume\",\"KHR_materials_dispersion\",\"KHR_materials_diffuse_transmission\"],\"extensionsRequired\":[\"KHR_animation_pointer\"],"
    "\"buffers\":[{\"byteLength\":216}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":216}],\"accessors\":["
    "{\"bufferView\":0,\"componentType\":5126,\"type\":\"SCALAR\",\"count\":3,\"min\":[1],\"max\":[4]},"
    FLOATS("SCALAR", 3, 12) "," FLOATS("VEC2", 3, 12) "," FLOATS("VEC3", 3, 12) "," FLOATS("VEC4", 3, 12) ","
    FLOATS("VEC4", 9, 12) "," FLOATS("SCALAR", 9, 12) "," FLOATS("SCALAR", 6, 12) ","
    "{\"bufferView\":0,\"byteOffset\":156,\"componentType\":5121,\"normalized\":true,\"type\":\"VEC4\",\"count\":3},"
    "{\"bufferView\":0,\"byteOffset\":156,\"componentType\":5121,\"type\":\"SCALAR\",\"count\":3},"
    "{\"bufferView\":0,\"byteOffset\":168,\"componentType\":5122,\"type\":\"SCALAR\",\"count\":3},"
    "{\"bufferView\":0,\"byteOffset\":176,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3,\"min\":[0,0,0],\"max\":[1,1,0]}],"
    "\"images\":[{\"uri\":\"data:image/png;base64," TEST_PNG_BASE64 "\"}],\"textures\":[{\"source\":0}],";
static const char parts[] = "\"materials\":[{},"
    "{\"pbrMetallicRoughness\":{\"metallicFactor\":0.5,\"baseColorTexture\":{" TURNED "},\"metallicRoughnessTexture\":{" TURNED "}},"
    "\"emissiveFactor\":[0.5,0.25,1],\"normalTexture\":{\"scale\":2," TURNED "},\"occlusionTexture\":{" TURNED "},\"emissiveTexture\":{" TURNED "},"
    "\"extensions\":{\"KHR_materials_emissive_strength\":{\"emissiveStrength\":3},\"KHR_materials_ior\":{},"
    "\"KHR_materials_specular\":{\"specularTexture\":{" TURNED "},\"specularColorTexture\":{" TURNED "}},"
    "\"KHR_materials_clearcoat\":{\"clearcoatTexture\":{" TURNED "},\"clearcoatRoughnessTexture\":{" TURNED "},\"clearcoatNormalTexture\":{" TURNED "}},"
    "\"KHR_materials_sheen\":{\"sheenColorTexture\":{" TURNED "},\"sheenRoughnessTexture\":{" TURNED "}},"
    "\"KHR_materials_iridescence\":{\"iridescenceTexture\":{" TURNED "},\"iridescenceThicknessTexture\":{" TURNED "}},"
    "\"KHR_materials_anisotropy\":{\"anisotropyTexture\":{" TURNED "}},"
    "\"KHR_materials_transmission\":{\"transmissionTexture\":{" TURNED "}},\"KHR_materials_volume\":{\"thicknessTexture\":{" TURNED "}},"
    "\"KHR_materials_dispersion\":{},\"KHR_materials_diffuse_transmission\":{\"diffuseTransmissionTexture\":{" TURNED "},"
    "\"diffuseTransmissionColorTexture\":{" TURNED "}}}},{}],"
    "\"meshes\":[{\"weights\":[0.5,0.25],\"primitives\":[{\"attributes\":{\"POSITION\":11},\"targets\":[{\"POSITION\":11},{\"POSITION\":11}]}]}],"
    "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":1,\"znear\":0.5}},"
    "{\"type\":\"orthographic\",\"orthographic\":{\"xmag\":1,\"ymag\":1,\"znear\":0.5,\"zfar\":50}}],"
    "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"directional\"},"
    "{\"type\":\"spot\",\"range\":9,\"spot\":{\"innerConeAngle\":0.1,\"outerConeAngle\":0.2}}]}},"
    "\"nodes\":[{\"camera\":0},{\"camera\":1},{\"children\":[3],\"extensions\":{\"KHR_node_visibility\":{\"visible\":true},"
    "\"KHR_lights_punctual\":{\"light\":1}}},{\"mesh\":0},{\"extensions\":{\"KHR_lights_punctual\":{\"light\":1}}},"
    "{\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}},{\"mesh\":0,\"weights\":[1,1]},{\"matrix\":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}],"
    "\"animations\":[";

enum { MATERIAL = 1, SPOT = 0, OTHER_SPOT = 1, SUN = 2, CHILD = 3, OWN_WEIGHTS = 6 };
enum { SCALARS = 1, VECTORS_2, VECTORS_3, VECTORS_4, CUBIC_4, CUBIC_1, PAIRS, BYTES_4, BYTES_1, SHORTS_1 }; /* accessors */

static struct {
    float times[3], values[36];
    uint8_t bytes[12];
    int16_t shorts[4];
    vec3 positions[3];
    float padding;
} binary = {.times = {1, 2, 4}, .bytes = {0, 51, 102, 255, 255, 0, 102, 0, 51, 51, 51, 51}, .shorts = {3, 7, 1}, .positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};

#define TARGET(pointer) "{\"path\":\"pointer\",\"extensions\":{\"KHR_animation_pointer\":{\"pointer\":\"" pointer "\"}}}"

static char json[1 << 14];

static fnl_scene *load_text(const char *animations) {
    fnl_scene *scene = NULL;
    snprintf(json, sizeof json, "%s%s%s]}", head, parts, animations);
    if (test_load(&file_log, json, &binary, sizeof binary, &scene) != FNL_OK) fail_msg("not loaded: %s", file_log.text);
    return scene;
}

/* One animation of one channel. */
static fnl_scene *load_channel(const char *pointer, uint32_t output, const char *interpolation) {
    char text[1024];
    snprintf(text, sizeof text,
             "{\"samplers\":[{\"input\":0,\"output\":%u,\"interpolation\":\"%s\"}],\"channels\":[{\"sampler\":0,\"target\":" TARGET("%s") "}]}",
             output, interpolation, pointer);
    return load_text(text);
}

static fnl_scene *load_clean(const char *pointer, uint32_t output, const char *interpolation) {
    fnl_scene *scene = load_channel(pointer, output, interpolation);
    if (file_log.count) fail_msg("%s: %s", pointer, file_log.text);
    return scene;
}

static void set_time(fnl_scene *scene, double seconds) { assert_int_equal(fnl_scene_set_time(scene, 0, seconds), FNL_OK); }

static void expect_floats(const char *what, const void *bytes, const float *expected, uint32_t count) {
    const float *values = bytes;
    for (uint32_t i = 0; i < count; i++)
        if (fabsf(values[i] - expected[i]) > 1e-5f * fmaxf(1, fabsf(expected[i])))
            fail_msg("%s: component %u is %g, not %g", what, i, (double)values[i], (double)expected[i]);
}

/* Keys at 1, 2 and 4 seconds, of `width` components; what they are at a time. */
static void make_keys(uint32_t width, float base) {
    static const float steps[3] = {0, 0.5f, 0.25f};
    for (uint32_t key = 0; key < 3; key++)
        for (uint32_t i = 0; i < width; i++) binary.values[key * width + i] = base + steps[key] + 0.0625f * (float)i;
}

static const struct {
    double time;
    float step;
} moments[] = {{0, 0}, {1.5, 0.25f}, {2, 0.5f}, {3, 0.375f}, {9, 0.25f}};

static void keys_at(uint32_t moment, uint32_t width, float base, float *out) {
    for (uint32_t i = 0; i < width; i++) out[i] = base + moments[moment].step + 0.0625f * (float)i;
}

/* ---- each property ---- */

#define PROPERTY(pointer, type, member, base) {pointer, offsetof(type, member), sizeof(((type *)0)->member) / sizeof(float), base}
#define LOOK(pointer, member, base) PROPERTY("/materials/1/" pointer, struct scene_material, member, base)
#define LAMP(pointer, member, base) PROPERTY("/extensions/KHR_lights_punctual/lights/1/" pointer, fnl_light_params, member, base)
#define LENS(pointer, member, base) PROPERTY("/cameras/" pointer, fnl_camera, member, base)
struct property {
    const char *pointer;
    size_t offset;
    uint32_t width;
    float base;
};

static void test_materials(void **state) {
    UNUSED(state);
    static const struct property cases[] = {
        LOOK("pbrMetallicRoughness/baseColorFactor", base_color, 0.125f),
        LOOK("pbrMetallicRoughness/metallicFactor", metallic, 0.125f),
        LOOK("pbrMetallicRoughness/roughnessFactor", roughness, 0.125f),
        LOOK("alphaCutoff", alpha_cutoff, 0.125f),
        LOOK("normalTexture/scale", normal_scale, -5),
        LOOK("occlusionTexture/strength", occlusion_strength, 0.125f),
        LOOK("extensions/KHR_materials_ior/ior", ior, 1.125f),
        LOOK("extensions/KHR_materials_specular/specularFactor", specular, 0.125f),
        LOOK("extensions/KHR_materials_specular/specularColorFactor", specular_color, 2),
        LOOK("extensions/KHR_materials_clearcoat/clearcoatFactor", clearcoat.strength, 0.125f),
        LOOK("extensions/KHR_materials_clearcoat/clearcoatRoughnessFactor", clearcoat.roughness, 0.125f),
        LOOK("extensions/KHR_materials_clearcoat/clearcoatNormalTexture/scale", clearcoat.normal_scale, 3),
        LOOK("extensions/KHR_materials_sheen/sheenColorFactor", sheen.color, 0.125f),
        LOOK("extensions/KHR_materials_sheen/sheenRoughnessFactor", sheen.roughness, 0.125f),
        LOOK("extensions/KHR_materials_iridescence/iridescenceFactor", iridescence.strength, 0.125f),
        LOOK("extensions/KHR_materials_iridescence/iridescenceIor", iridescence.ior, 1.125f),
        LOOK("extensions/KHR_materials_iridescence/iridescenceThicknessMinimum", iridescence.thickness_minimum, 200),
        LOOK("extensions/KHR_materials_iridescence/iridescenceThicknessMaximum", iridescence.thickness_maximum, 200),
        LOOK("extensions/KHR_materials_anisotropy/anisotropyStrength", anisotropy.strength, 0.125f),
        LOOK("extensions/KHR_materials_anisotropy/anisotropyRotation", anisotropy.rotation, -2),
        LOOK("extensions/KHR_materials_transmission/transmissionFactor", transmission.strength, 0.125f),
        LOOK("extensions/KHR_materials_volume/thicknessFactor", volume.thickness, 2),
        LOOK("extensions/KHR_materials_volume/attenuationDistance", volume.attenuation_distance, 3),
        LOOK("extensions/KHR_materials_volume/attenuationColor", volume.attenuation_color, 0.125f),
        LOOK("extensions/KHR_materials_dispersion/dispersion", dispersion, 2),
        LOOK("extensions/KHR_materials_diffuse_transmission/diffuseTransmissionFactor", diffuse_transmission.strength, 0.125f),
        LOOK("extensions/KHR_materials_diffuse_transmission/diffuseTransmissionColorFactor", diffuse_transmission.color, 0.125f),
    };
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        const struct property *c = &cases[i];
        make_keys(c->width, c->base);
        fnl_scene *scene = load_clean(c->pointer, c->width, "LINEAR");
        struct scene_material before[3], expected;
        memcpy(before, scene->materials.data, sizeof before);
        for (uint32_t k = 0; k < COUNT_OF(moments); k++) {
            float values[4];
            keys_at(k, c->width, c->base, values);
            const uint64_t version = scene->material_version;
            set_time(scene, moments[k].time);
            assert_int_equal(scene->material_version, version + 1);
            set_time(scene, moments[k].time); /* nothing is new */
            assert_int_equal(scene->material_version, version + 1);
            memcpy(&expected, &before[MATERIAL], sizeof expected);
            memcpy((char *)&expected + c->offset, (char *)&scene->materials.data[MATERIAL] + c->offset, c->width * sizeof(float));
            expect_floats(c->pointer, (char *)&expected + c->offset, values, c->width);
            assert_memory_equal(&scene->materials.data[MATERIAL], &expected, sizeof expected); /* and nothing else */
        }
        assert_memory_equal(&scene->materials.data[0], &before[0], sizeof expected);
        assert_memory_equal(&scene->materials.data[2], &before[2], sizeof expected);
        fnl_scene_destroy(&scene);
    }
}

/* Emission is the product of two properties. */
static void test_emission(void **state) {
    UNUSED(state);
    static const char both[] =
        "{\"samplers\":[{\"input\":0,\"output\":3},{\"input\":0,\"output\":1}],\"channels\":[{\"sampler\":0,\"target\":"
        TARGET("/materials/1/emissiveFactor") "},{\"sampler\":1,\"target\":"
        TARGET("/materials/1/extensions/KHR_materials_emissive_strength/emissiveStrength") "}]}";
    static const char *const pointers[] = {"/materials/1/emissiveFactor",
                                           "/materials/1/extensions/KHR_materials_emissive_strength/emissiveStrength", NULL};
    for (uint32_t i = 0; i < COUNT_OF(pointers); i++) {
        make_keys(i == 1 ? 1 : 3, 0.125f);
        fnl_scene *scene = pointers[i] ? load_clean(pointers[i], i == 1 ? SCALARS : VECTORS_3, "LINEAR") : load_text(both);
        for (uint32_t k = 0; k < COUNT_OF(moments); k++) {
            float factor[4] = {0.5f, 0.25f, 1}, strength[4] = {3};
            if (i != 1) keys_at(k, 3, 0.125f, factor);
            if (i == 1) keys_at(k, 1, 0.125f, strength);
            set_time(scene, moments[k].time);
            if (i == 2) { /* the components of the first vector, in turn */
                static const float at_moments[] = {0.125f, 0.15625f, 0.1875f, 0.21875f, 0.25f};
                strength[0] = at_moments[k];
            }
            const float expected[3] = {factor[0] * strength[0], factor[1] * strength[0], factor[2] * strength[0]};
            expect_floats("emission", &scene->materials.data[MATERIAL].emissive, expected, 3);
        }
        /* What a call set goes when the time is set again, also to the same. */
        const vec3 last = scene->materials.data[MATERIAL].emissive;
        fnl_material_params look;
        assert_int_equal(fnl_scene_query_material(scene, MATERIAL, &look), FNL_OK);
        look.emissive[0] = 77;
        assert_int_equal(fnl_scene_set_material(scene, (fnl_material_id){MATERIAL, 1}, &look), FNL_OK);
        assert_true(scene->materials.data[MATERIAL].emissive.x == 77);
        set_time(scene, 9);
        assert_memory_equal(&scene->materials.data[MATERIAL].emissive, &last, sizeof last);
        fnl_scene_destroy(&scene);
    }
}

static void test_texture_transforms(void **state) {
    UNUSED(state);
    static const char *const slots[SCENE_TEXTURE_SLOT_COUNT] = {
        "pbrMetallicRoughness/baseColorTexture", "pbrMetallicRoughness/metallicRoughnessTexture", "normalTexture", "occlusionTexture",
        "emissiveTexture", "extensions/KHR_materials_specular/specularTexture", "extensions/KHR_materials_specular/specularColorTexture",
        "extensions/KHR_materials_clearcoat/clearcoatTexture", "extensions/KHR_materials_clearcoat/clearcoatRoughnessTexture",
        "extensions/KHR_materials_clearcoat/clearcoatNormalTexture", "extensions/KHR_materials_sheen/sheenColorTexture",
        "extensions/KHR_materials_sheen/sheenRoughnessTexture", "extensions/KHR_materials_iridescence/iridescenceTexture",
        "extensions/KHR_materials_iridescence/iridescenceThicknessTexture", "extensions/KHR_materials_anisotropy/anisotropyTexture",
        "extensions/KHR_materials_transmission/transmissionTexture", "extensions/KHR_materials_volume/thicknessTexture",
        "extensions/KHR_materials_diffuse_transmission/diffuseTransmissionTexture",
        "extensions/KHR_materials_diffuse_transmission/diffuseTransmissionColorTexture"};
    static const char *const names[] = {"offset", "scale", "rotation"};
    for (uint32_t slot = 0; slot < SCENE_TEXTURE_SLOT_COUNT; slot++)
        for (uint32_t n = 0; n < COUNT_OF(names); n++) {
            char pointer[256];
            snprintf(pointer, sizeof pointer, "/materials/1/%s/extensions/KHR_texture_transform/%s", slots[slot], names[n]);
            make_keys(n == 2 ? 1 : 2, -0.5f);
            fnl_scene *scene = load_clean(pointer, n == 2 ? SCALARS : VECTORS_2, "LINEAR");
            for (uint32_t k = 0; k < COUNT_OF(moments); k++) {
                float turn[3][2] = {{0.125f, 0.25f}, {2, 3}, {0.5f}};
                keys_at(k, n == 2 ? 1 : 2, -0.5f, turn[n]);
                set_time(scene, moments[k].time);
                const float c = cosf(turn[2][0]), s = sinf(turn[2][0]);
                const float at[] = {c * turn[1][0], s * turn[1][1], turn[0][0], -s * turn[1][0], c * turn[1][1], turn[0][1]};
                const float still[] = {cosf(0.5f) * 2, sinf(0.5f) * 3, 0.125f, -sinf(0.5f) * 2, cosf(0.5f) * 3, 0.25f};
                for (uint32_t other = 0; other < SCENE_TEXTURE_SLOT_COUNT; other++)
                    expect_floats(pointer, scene->materials.data[MATERIAL].textures[other].transform, other == slot ? at : still, 6);
            }
            fnl_scene_destroy(&scene);
        }
}

static void test_lights(void **state) {
    UNUSED(state);
    static const struct property cases[] = {
        LAMP("color", color, 0.125f),
        LAMP("intensity", intensity, 100),
        LAMP("range", range, 5),
        LAMP("spot/innerConeAngle", inner_cone_angle, 0.125f),
        LAMP("spot/outerConeAngle", outer_cone_angle, 0.25f),
    };
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        const struct property *c = &cases[i];
        make_keys(c->width, c->base);
        fnl_scene *scene = load_clean(c->pointer, c->width, "LINEAR");
        assert_int_equal(scene->lights.count, 3);
        const fnl_light_params sun = scene->lights.data[SUN].params;
        const bool inner = c->offset == offsetof(fnl_light_params, inner_cone_angle); /* is no more than the outer one */
        for (uint32_t k = 0; k < COUNT_OF(moments); k++) {
            float values[4];
            keys_at(k, c->width, c->base, values);
            if (inner) values[0] = fminf(values[0], 0.2f);
            const uint64_t version = scene->light_version;
            set_time(scene, moments[k].time);
            for (uint32_t light = SPOT; light <= OTHER_SPOT; light++) { /* both nodes have the same light */
                const struct scene_light *lamp = &scene->lights.data[light];
                expect_floats(c->pointer, (const char *)&lamp->params + c->offset, values, c->width);
                assert_true(scene->light_slots.data[lamp->slot].changed_version > version);
            }
            if (inner) continue;
            const uint64_t changed = scene->light_version;
            set_time(scene, moments[k].time);
            assert_int_equal(scene->light_version, changed);
        }
        assert_memory_equal(&scene->lights.data[SUN].params, &sun, sizeof sun);
        fnl_scene_destroy(&scene);
    }

    /* A cone that opens past what the other angle was, in both orders; and a light that has gone, with another in its place. */
    static const char cone[] =
        "{\"samplers\":[{\"input\":0,\"output\":1},{\"input\":0,\"output\":%s}],\"channels\":["
        "{\"sampler\":0,\"target\":" TARGET("/extensions/KHR_lights_punctual/lights/1/spot/%s") "},"
        "{\"sampler\":1,\"target\":" TARGET("/extensions/KHR_lights_punctual/lights/1/spot/%s") "}]}";
    for (int order = 0; order < 2; order++) {
        char text[1024];
        snprintf(text, sizeof text, cone, "1", order ? "innerConeAngle" : "outerConeAngle", order ? "outerConeAngle" : "innerConeAngle");
        make_keys(1, 0.5f);
        fnl_scene *scene = load_text(text);
        for (uint32_t k = 0; k < 3; k++) {
            set_time(scene, moments[k].time);
            assert_true(scene->lights.data[SPOT].params.inner_cone_angle == 0.5f + moments[k].step);
            assert_true(scene->lights.data[SPOT].params.outer_cone_angle == 0.5f + moments[k].step);
        }
        fnl_light_params bulb = fnl_light_params_default();
        fnl_light_id id;
        assert_int_equal(fnl_scene_remove_light(scene, (fnl_light_id){SPOT, scene->lights.data[SPOT].generation}), FNL_OK);
        assert_int_equal(fnl_scene_add_light(scene, &bulb, &id), FNL_OK);
        assert_int_equal(id.index, SPOT);
        set_time(scene, 0);
        assert_true(scene->lights.data[SPOT].params.outer_cone_angle == bulb.outer_cone_angle);
        assert_true(scene->lights.data[OTHER_SPOT].params.outer_cone_angle == 0.5f);
        fnl_scene_destroy(&scene);
    }
}

static void test_cameras(void **state) {
    UNUSED(state);
    static const struct property cases[] = {
        LENS("0/perspective/yfov", vertical_fov, 0.125f), LENS("0/perspective/znear", near_distance, 0.125f),
        LENS("1/orthographic/ymag", vertical_extent, -4), LENS("1/orthographic/znear", near_distance, 0.125f),
        LENS("1/orthographic/zfar", far_distance, 90),    LENS("1/orthographic/xmag", position, 1), /* unused, as the next two */
        LENS("0/perspective/zfar", position, 1),          LENS("0/perspective/aspectRatio", position, 1),
    };
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        const struct property *c = &cases[i];
        make_keys(1, c->base);
        fnl_scene *scene = load_clean(c->pointer, SCALARS, "LINEAR");
        fnl_camera before[2], after[2];
        for (uint32_t k = 0; k < 2; k++) assert_int_equal(fnl_scene_query_camera(scene, k, &before[k]), FNL_OK);
        for (uint32_t k = 0; k < COUNT_OF(moments); k++) {
            set_time(scene, moments[k].time);
            for (uint32_t n = 0; n < 2; n++) assert_int_equal(fnl_scene_query_camera(scene, n, &after[n]), FNL_OK);
            if (c->width == 1) {
                float value = c->base + moments[k].step;
                if (c->base < 0) value = -2 * value;
                fnl_camera *camera = &after[c->pointer[9] - '0'];
                expect_floats(c->pointer, (char *)camera + c->offset, &value, 1);
                memcpy((char *)camera + c->offset, (char *)&before[c->pointer[9] - '0'] + c->offset, sizeof value);
            }
            assert_memory_equal(before, after, sizeof before);
        }
        fnl_scene_destroy(&scene);
    }
    make_keys(1, 0); /* a view whose far end comes nearer than its near one can still be used */
    fnl_scene *scene = load_channel("/cameras/1/orthographic/zfar", SCALARS, "LINEAR");
    const fnl_host host = test_host(&file_log);
    for (uint32_t k = 0; k < COUNT_OF(moments); k++) {
        fnl_camera camera;
        set_time(scene, moments[k].time);
        assert_int_equal(fnl_scene_query_camera(scene, 1, &camera), FNL_OK);
        assert_int_equal(camera_check(CALL(&host), "", &camera), FNL_OK);
    }
    fnl_scene_destroy(&scene);
}

/* ---- nodes ---- */

static void test_nodes(void **state) {
    UNUSED(state);
    make_keys(3, 2);
    for (uint32_t scale = 0; scale < 2; scale++) {
        fnl_scene *scene = load_clean(scale ? "/nodes/2/scale" : "/nodes/2/translation", VECTORS_3, "LINEAR");
        for (uint32_t k = 0; k < COUNT_OF(moments); k++) {
            float values[3];
            keys_at(k, 3, 2, values);
            set_time(scene, moments[k].time);
            const float *m = scene->nodes.data[CHILD].world.m, diagonal[3] = {m[0], m[5], m[10]};
            expect_floats("world", scale ? diagonal : m + 12, values, 3);
        }
        fnl_scene_destroy(&scene);
    }
    /* A turn by a right angle, evenly. */
    const float turn[3][4] = {{0, 0, 0, 1}, {0, sqrtf(0.5f), 0, sqrtf(0.5f)}, {0, 1, 0, 0}};
    memcpy(binary.values, turn, sizeof turn);
    fnl_scene *scene = load_clean("/nodes/2/rotation", VECTORS_4, "LINEAR");
    for (int i = 0; i <= 4; i++) {
        set_time(scene, 1 + 0.25 * i);
        const float angle = PI / 8 * (float)i, expected[] = {cosf(angle), 0, -sinf(angle)};
        expect_floats("rotation", scene->nodes.data[CHILD].world.m, expected, 3);
    }
    fnl_scene_destroy(&scene);
}

static void test_weights(void **state) {
    UNUSED(state);
    static const struct {
        const char *pointer;
        uint32_t output;
        bool all_of_mesh, one;
    } cases[] = {{"/nodes/3/weights", PAIRS, false, false}, {"/nodes/3/weights/1", SCALARS, false, true}, {"/meshes/0/weights", PAIRS, true, false},
                 {"/meshes/0/weights/1", SCALARS, true, true}};
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        const uint32_t width = cases[i].one ? 1 : 2;
        make_keys(width, 0.125f);
        fnl_scene *scene = load_clean(cases[i].pointer, cases[i].output, "LINEAR");
        for (uint32_t k = 0; k < COUNT_OF(moments); k++) {
            const uint64_t version = scene->transform_version;
            float expected[4] = {0.5f, 0.25f}, own[2] = {1, 1};
            keys_at(k, width, 0.125f, expected + (cases[i].one ? 1 : 0));
            set_time(scene, moments[k].time);
            assert_true(scene->transform_version > version);
            expect_floats(cases[i].pointer, scene->nodes.data[CHILD].morph_weights, expected, 2);
            expect_floats(cases[i].pointer, scene->nodes.data[OWN_WEIGHTS].morph_weights, own, 2); /* of its own */
        }
        fnl_scene_destroy(&scene);
    }
}

static void test_visibility(void **state) {
    UNUSED(state);
    fnl_scene *scene = load_clean("/nodes/2/extensions/KHR_node_visibility/visible", BYTES_1, "STEP"); /* 0, 51, 102 */
    static const struct {
        double time;
        bool visible;
    } cases[] = {{0, false}, {1.999, false}, {2, true}, {3.9, true}, {9, true}, {1.5, false}};
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        set_time(scene, cases[i].time);
        assert_int_equal(scene->nodes.data[CHILD].active, cases[i].visible);
        const uint64_t version = scene->structure_version;
        set_time(scene, cases[i].time);
        assert_int_equal(scene->structure_version, version);
    }
    fnl_scene_destroy(&scene);
}

/* ---- interpolations and types ---- */

static void test_interpolations(void **state) {
    UNUSED(state);
    const char *pointer = "/materials/1/pbrMetallicRoughness/baseColorFactor";
    make_keys(4, 0.125f);
    fnl_scene *scene = load_clean(pointer, VECTORS_4, "STEP");
    static const struct {
        double time;
        float step;
    } steps[] = {{0, 0}, {1.999, 0}, {2, 0.5f}, {3.999, 0.5f}, {4, 0.25f}, {5, 0.25f}};
    for (uint32_t i = 0; i < COUNT_OF(steps); i++) {
        set_time(scene, steps[i].time);
        assert_true(scene->materials.data[MATERIAL].base_color.w == 0.125f + steps[i].step + 0.1875f);
    }
    fnl_scene_destroy(&scene);

    /* Keys of a cubic give it back: (t^3 - t^2) / 64. */
    memset(binary.values, 0, sizeof binary.values);
    for (int k = 0; k < 3; k++) {
        const float t = binary.times[k];
        float *key = binary.values + 12 * k;
        key[1] = key[9] = (3 * t * t - 2 * t) / 64;
        key[5] = (t * t * t - t * t) / 64;
    }
    scene = load_clean(pointer, CUBIC_4, "CUBICSPLINE");
    for (float t = 1; t <= 4; t += 0.125f) {
        const float expected = (t * t * t - t * t) / 64;
        set_time(scene, (double)t);
        expect_floats("cubic", &scene->materials.data[MATERIAL].base_color.y, &expected, 1);
    }
    fnl_scene_destroy(&scene);

    /* A spline that runs past the limits of a property stays within them. */
    for (int i = 0; i < 9; i++) binary.values[i] = i % 3 == 1 ? 0.5f : i % 3 == 0 ? -60 : 60;
    scene = load_clean("/materials/1/pbrMetallicRoughness/metallicFactor", CUBIC_1, "CUBICSPLINE");
    set_time(scene, 1.5);
    assert_true(scene->materials.data[MATERIAL].metallic == 1);
    fnl_scene_destroy(&scene);

    scene = load_clean(pointer, BYTES_4, "LINEAR"); /* normalised integers, and plain ones */
    const float bytes[] = {0.5f, 0.1f, 0.4f, 0.5f}, number = 5;
    set_time(scene, 1.5);
    expect_floats("bytes", &scene->materials.data[MATERIAL].base_color, bytes, 4);
    fnl_scene_destroy(&scene);
    scene = load_clean("/materials/1/normalTexture/scale", SHORTS_1, "LINEAR");
    set_time(scene, 1.5);
    expect_floats("shorts", &scene->materials.data[MATERIAL].normal_scale, &number, 1);
    fnl_scene_destroy(&scene);
}

/* ---- several files ---- */

static void test_files_in_one_scene(void **state) {
    UNUSED(state);
    static const char all[] =
        "{\"samplers\":[{\"input\":0,\"output\":1},{\"input\":0,\"output\":9,\"interpolation\":\"STEP\"},{\"input\":0,\"output\":3}],\"channels\":["
        "{\"sampler\":0,\"target\":" TARGET("/materials/1/pbrMetallicRoughness/roughnessFactor") "},"
        "{\"sampler\":0,\"target\":" TARGET("/extensions/KHR_lights_punctual/lights/1/intensity") "},"
        "{\"sampler\":0,\"target\":" TARGET("/cameras/1/orthographic/znear") "},"
        "{\"sampler\":1,\"target\":" TARGET("/nodes/2/extensions/KHR_node_visibility/visible") "},"
        "{\"sampler\":2,\"target\":" TARGET("/nodes/7/translation") "},"
        "{\"sampler\":0,\"target\":" TARGET("/meshes/0/weights/0") "}]}";
    make_keys(1, 0.25f);
    fnl_scene *scene = load_text(all);
    static const char *const lines[] = {"/animations/0/channels/4/target/extensions/KHR_animation_pointer/pointer: node 7 has a matrix"};
    if (file_log.count != 1 || !strstr(file_log.text, lines[0])) fail_msg("%s", file_log.text);
    size_t size;
    unsigned char *glb = test_glb(json, &binary, sizeof binary, &size);
    fnl_load_params params = fnl_load_params_default();
    params.data = glb;
    params.size = size;
    fnl_loaded b;
    assert_int_equal(fnl_scene_load_into(scene, (fnl_instance_id){0, 0}, "b.glb", &params, &b), FNL_OK);
    free(glb);
    for (uint32_t i = 0; i < 2; i++) {
        assert_int_equal(fnl_scene_set_time(scene, i ? b.first[FNL_ENTITY_ANIMATION] : 0, i ? 2 : 0), FNL_OK);
        const float values[2] = {0.25f, i ? 0.75f : 1}, other_intensity = i ? 0.75f : 1;
        const uint32_t materials = b.first[FNL_ENTITY_MATERIAL], lights = b.first[FNL_ENTITY_LIGHT], cameras = b.first[FNL_ENTITY_CAMERA],
                       nodes = b.root.index + 1;
        expect_floats("a", &scene->materials.data[MATERIAL].roughness, values, 1);
        expect_floats("b", &scene->materials.data[materials + MATERIAL].roughness, values + 1, 1);
        expect_floats("a", &scene->lights.data[SPOT].params.intensity, values, 1);
        expect_floats("b", &scene->lights.data[lights + SPOT].params.intensity, &other_intensity, 1);
        expect_floats("b", &scene->lights.data[lights + OTHER_SPOT].params.intensity, &other_intensity, 1);
        assert_true(scene->lights.data[SUN].params.intensity == 1 && scene->lights.data[lights + SUN].params.intensity == 1);
        assert_true(scene->cameras.data[1].camera.near_distance == 0.25f);
        assert_true(scene->cameras.data[cameras + 1].camera.near_distance == (i ? 0.75f : 0.5f));
        assert_true(!scene->nodes.data[CHILD].active && scene->nodes.data[nodes + CHILD].active);
        assert_true(scene->nodes.data[CHILD].morph_weights[0] == 0.25f);
        assert_true(i ? scene->nodes.data[nodes + CHILD].morph_weights[0] == 0.75f : !scene->nodes.data[nodes + CHILD].morph_weights);
    }
    fnl_scene_destroy(&scene);
}

/* ---- what cannot be animated ---- */

#define CHANNEL "/animations/0/channels/0"
#define POINTER CHANNEL "/target/extensions/KHR_animation_pointer/pointer: "

static void test_broken_pointers(void **state) {
    UNUSED(state);
    static const struct {
        const char *pointer;
        uint32_t output;
        const char *interpolation, *line;
    } cases[] = {
        {"materials/1/alphaCutoff", SCALARS, "LINEAR", POINTER "'materials/1/alphaCutoff' is no JSON pointer; the channel is left out"},
        {"", SCALARS, "LINEAR", POINTER "'' names nothing that can be animated"},
        {"/materials/1/doubleSided", BYTES_1, "STEP", POINTER "'/materials/1/doubleSided' names nothing that can be animated"},
        {"/materials/1/alphaCutoff/0", SCALARS, "LINEAR", POINTER "'/materials/1/alphaCutoff/0' names nothing that can be"},
        {"/materials/1/pbrMetallicRoughness/baseColorFactor/0", SCALARS, "LINEAR", POINTER "'/materials/1/pbrMetallicRoughness/baseColorFactor/0' names nothing"},
        {"/materials/01/alphaCutoff", SCALARS, "LINEAR", POINTER "'/materials/01/alphaCutoff' names nothing that can be"},
        {"/materials/-1/alphaCutoff", SCALARS, "LINEAR", POINTER "'/materials/-1/alphaCutoff' names nothing that can be"},
        {"/materials/4294967297/alphaCutoff", SCALARS, "LINEAR", POINTER "'/materials/4294967297/alphaCutoff' names nothing that can be"},
        {"/materials/3/alphaCutoff", SCALARS, "LINEAR", POINTER "'/materials/3/alphaCutoff' names nothing that the file has"},
        {"/materials/0/normalTexture/scale", SCALARS, "LINEAR", POINTER "'/materials/0/normalTexture/scale' names nothing that the file has"},
        {"/nodes/8/translation", VECTORS_3, "LINEAR", POINTER "'/nodes/8/translation' names nothing that the file has"},
        {"/nodes/3/extensions/KHR_node_visibility/visible", BYTES_1, "STEP", POINTER "'/nodes/3/extensions/KHR_node_visibility/visible' names nothing that the file"},
        {"/extensions/KHR_lights_punctual/lights/2/color", VECTORS_3, "LINEAR", POINTER "'/extensions/KHR_lights_punctual/lights/2/color' names nothing that the file"},
        {"/extensions/KHR_lights_punctual/lights/0/spot/outerConeAngle", SCALARS, "LINEAR", POINTER "'/extensions/KHR_lights_punctual/lights/0/spot/outerConeAngle' names"},
        {"/cameras/0/orthographic/ymag", SCALARS, "LINEAR", POINTER "'/cameras/0/orthographic/ymag' names nothing that the file has"},
        {"/nodes/7/rotation", VECTORS_4, "LINEAR", POINTER "node 7 has a matrix, which cannot be animated; the channel is left out"},
        {"/nodes/2/weights", PAIRS, "LINEAR", POINTER "node 2 has no morph targets; the channel is left out"},
        {"/nodes/3/weights/2", SCALARS, "LINEAR", POINTER "refers to weight 2, but there are 2; the channel is left out"},
        {"/meshes/0/weights/2", SCALARS, "LINEAR", POINTER "refers to weight 2, but there are 2; the channel is left out"},
        {"/materials/1/alphaCutoff", VECTORS_2, "LINEAR", CHANNEL "/sampler: the output cannot be VEC2 of FLOAT for this path; the channel is left out"},
        {"/materials/1/emissiveFactor", VECTORS_4, "LINEAR", CHANNEL "/sampler: the output cannot be VEC4 of FLOAT"},
        {"/materials/1/emissiveFactor", SCALARS, "LINEAR", CHANNEL "/sampler: the output cannot be SCALAR of FLOAT"},
        {"/materials/1/alphaCutoff", CUBIC_1, "LINEAR", CHANNEL "/sampler: the output has 9 elements, but 3 are needed"},
        {"/materials/1/alphaCutoff", SCALARS, "CUBICSPLINE", CHANNEL "/sampler: the output has 3 elements, but 9 are needed"},
        {"/nodes/3/weights", SCALARS, "LINEAR", CHANNEL "/sampler: the output has 3 elements, but 6 are needed"},
        {"/nodes/2/extensions/KHR_node_visibility/visible", SCALARS, "STEP", CHANNEL "/sampler: the output cannot be SCALAR of FLOAT"},
        {"/nodes/2/extensions/KHR_node_visibility/visible", BYTES_1, "LINEAR", CHANNEL "/sampler: the interpolation must be STEP for this path"},
    };
    make_keys(4, 0.125f);
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        fnl_scene *scene = load_channel(cases[i].pointer, cases[i].output, cases[i].interpolation);
        if (file_log.count != 1 || !strstr(file_log.text, cases[i].line)) fail_msg("no '%s' alone in:\n%s", cases[i].line, file_log.text);
        assert_int_equal(scene->animations.count, 1);
        assert_int_equal(scene->animations.data[0].channel_count, 0);
        set_time(scene, 2);
        fnl_scene_destroy(&scene);
    }
    make_keys(1, 0.75f); /* clamped, but played */
    fnl_scene *scene = load_channel("/materials/1/pbrMetallicRoughness/metallicFactor", SCALARS, "LINEAR");
    if (file_log.count != 1 || !strstr(file_log.text, "/animations/0/samplers/0/output: 1 values are not in 0 .. 1, the first at key 1; they are clamped"))
        fail_msg("%s", file_log.text);
    set_time(scene, 2);
    assert_true(scene->materials.data[MATERIAL].metallic == 1);
    fnl_scene_destroy(&scene);
    make_keys(4, 0.4f); /* of the second key the last two components alone are out of range */
    scene = load_channel("/materials/1/pbrMetallicRoughness/baseColorFactor", VECTORS_4, "LINEAR");
    if (file_log.count != 1 || !strstr(file_log.text, "1 values are not in 0 .. 1, the first at key 1; they are clamped")) fail_msg("%s", file_log.text);
    fnl_scene_destroy(&scene);
}

static void test_broken_targets(void **state) {
    UNUSED(state);
#define CUTOFF "\"extensions\":{\"KHR_animation_pointer\":{\"pointer\":\"/materials/1/alphaCutoff\"}}"
    static const struct {
        const char *targets[2];
        const char *line;
        uint32_t channels;
    } cases[] = {
        {{"{\"path\":\"pointer\"}"}, CHANNEL "/target/path: is 'pointer', but there is no KHR_animation_pointer; the channel is left out", 0},
        {{"{\"path\":\"pointer\",\"extensions\":{\"KHR_animation_pointer\":{}}}"}, CHANNEL "/target/extensions/KHR_animation_pointer: has no 'pointer'", 0},
        {{"{\"path\":\"pointer\",\"node\":2," CUTOFF "}"}, CHANNEL "/target/node: stands beside a pointer; it is ignored", 1},
        {{"{\"path\":\"weights\",\"node\":3," CUTOFF "}"}, CHANNEL "/target/extensions/KHR_animation_pointer: is ignored: the path is not 'pointer'", 0},
        {{"{\"path\":\"pointer\"," CUTOFF "}", "{\"path\":\"pointer\"," CUTOFF "}"},
         CHANNEL "/target: channel 1 has the same target, and is played instead", 2},
        {{TARGET("/nodes/3/weights/0"), TARGET("/nodes/3/weights/0")}, CHANNEL "/target: channel 1 has the same target", 2},
    };
    make_keys(2, 0.125f);
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        char text[1024];
        int n = snprintf(text, sizeof text, "{\"samplers\":[{\"input\":0,\"output\":%d}],\"channels\":[", i == 3 ? PAIRS : SCALARS);
        for (uint32_t k = 0; k < 2 && cases[i].targets[k]; k++)
            n += snprintf(text + n, sizeof text - (size_t)n, "%s{\"sampler\":0,\"target\":%s}", k ? "," : "", cases[i].targets[k]);
        snprintf(text + n, sizeof text - (size_t)n, "]}");
        fnl_scene *scene = load_text(text);
        if (file_log.count != 1 || !strstr(file_log.text, cases[i].line)) fail_msg("no '%s' alone in:\n%s", cases[i].line, file_log.text);
        assert_int_equal(scene->animations.data[0].channel_count, i == 3 ? 1 : cases[i].channels);
        fnl_scene_destroy(&scene);
    }
    /* A node's path and a pointer to it are the same target too. */
    fnl_scene *scene = load_text("{\"samplers\":[{\"input\":0,\"output\":3}],\"channels\":[{\"sampler\":0,\"target\":{\"node\":2,\"path\":\"scale\"}},"
                                 "{\"sampler\":0,\"target\":" TARGET("/nodes/2/scale") "}]}");
    if (file_log.count != 1 || !strstr(file_log.text, CHANNEL "/target: channel 1 has the same target")) fail_msg("%s", file_log.text);
    fnl_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_materials),     cmocka_unit_test(test_emission),      cmocka_unit_test(test_texture_transforms),
        cmocka_unit_test(test_lights),        cmocka_unit_test(test_cameras),       cmocka_unit_test(test_nodes),
        cmocka_unit_test(test_weights),       cmocka_unit_test(test_visibility),    cmocka_unit_test(test_interpolations),
        cmocka_unit_test(test_files_in_one_scene), cmocka_unit_test(test_broken_pointers), cmocka_unit_test(test_broken_targets),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
