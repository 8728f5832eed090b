/* SPDX-License-Identifier: MIT */
/**
 * A loaded scene is looked through and changed while a renderer shows it. After each change its picture has the bits of a scene that was
 * loaded from a file which says so.
 */
#include "fanal/trace.h"
#include "image/image.h"
#include "tests/gltf_test_file.h"
#include "tests/render_harness.h"

/* What the file says. */
struct file {
    float group[3], tip[3], color[3], intensity;
    const char *extra, *arm, *panel; /* "": left out; else as node list elements */
    uint32_t board_material;
};

static const struct file plain = {.color = {0.8f, 0.1f, 0.1f}, .intensity = 30, .extra = ",6", .arm = ",3", .panel = "1,"};
static struct test_log lines;

#define POINTER(text) "{\"path\":\"pointer\",\"extensions\":{\"KHR_animation_pointer\":{\"pointer\":\"" text "\"}}}"

static unsigned char *make_glb(const struct file *f, size_t *size) {
    struct {
        float positions[18], normals[18];
        uint8_t joints[24];
        float weights[24], inverse_bind[32], times[2], keys[6], colors[8], powers[2];
    } binary = {.positions = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, -1, 0, 1, 1, 0, -1, 1, 0}, .times = {0, 1}, .keys = {0, 0, 0, 0, 0.5f, 0},
                .colors = {0.5f, 0.25f, 0, 1, 0.25f, 0.75f, 1, 1}, .powers = {40, 8}};
    for (int i = 0; i < 6; i++) {
        binary.normals[i * 3 + 2] = 1;
        binary.joints[i * 4] = binary.positions[i * 3 + 1] > 0; /* the upper corners hang on the second joint */
        binary.weights[i * 4] = 1;
    }
    for (int i = 0; i < 32; i++) binary.inverse_bind[i] = i % 16 % 5 == 0;
    char json[6000];
    snprintf(json, sizeof json,
             "{\"asset\":{\"version\":\"2.0\"},"
             "\"extensionsUsed\":[\"KHR_lights_punctual\",\"KHR_materials_variants\",\"KHR_animation_pointer\"],"
             "\"buffers\":[{\"byteLength\":%zu}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":144,\"byteStride\":12},"
             "{\"buffer\":0,\"byteOffset\":144,\"byteLength\":24,\"byteStride\":4},{\"buffer\":0,\"byteOffset\":168,\"byteLength\":96,"
             "\"byteStride\":16},{\"buffer\":0,\"byteOffset\":264,\"byteLength\":128},{\"buffer\":0,\"byteOffset\":392,\"byteLength\":72}],"
             "\"accessors\":["
             "{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":6,\"min\":[-1,-1,0],\"max\":[1,1,0]},"
             "{\"bufferView\":0,\"byteOffset\":72,\"componentType\":5126,\"type\":\"VEC3\",\"count\":6},"
             "{\"bufferView\":1,\"componentType\":5121,\"type\":\"VEC4\",\"count\":6},"
             "{\"bufferView\":2,\"componentType\":5126,\"type\":\"VEC4\",\"count\":6},"
             "{\"bufferView\":3,\"componentType\":5126,\"type\":\"MAT4\",\"count\":2},"
             "{\"bufferView\":4,\"componentType\":5126,\"type\":\"SCALAR\",\"count\":2,\"min\":[0],\"max\":[1]},"
             "{\"bufferView\":4,\"byteOffset\":8,\"componentType\":5126,\"type\":\"VEC3\",\"count\":2},"
             "{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC2\",\"count\":6},"
             "{\"bufferView\":4,\"byteOffset\":32,\"componentType\":5126,\"type\":\"VEC4\",\"count\":2},"
             "{\"bufferView\":4,\"byteOffset\":64,\"componentType\":5126,\"type\":\"SCALAR\",\"count\":2}],"
             "\"materials\":[{\"name\":\"paint\",\"extras\":\"gloss\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[%g,%g,%g,1],"
             "\"metallicFactor\":0,\"roughnessFactor\":0.5}},"
             "{\"name\":\"cloth\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.1,0.7,0.2,1],\"metallicFactor\":0}}],"
             "\"extensions\":{\"KHR_materials_variants\":{\"variants\":[{\"name\":\"draped\"}]},\"KHR_lights_punctual\":{\"lights\":["
             "{\"name\":\"bulb\",\"type\":\"point\",\"intensity\":%g,\"extras\":{\"watts\":60}}]}},"
             "\"meshes\":[{\"name\":\"board\",\"primitives\":[{\"material\":%u,\"attributes\":{\"POSITION\":0,\"NORMAL\":1,"
             "\"TEXCOORD_0\":7},\"extensions\":{\"KHR_materials_variants\":{\"mappings\":[{\"material\":1,\"variants\":[0]}]}}}]},"
             "{\"name\":\"flag\",\"extras\":[1,2],\"primitives\":[{\"material\":1,\"attributes\":{\"POSITION\":0,\"NORMAL\":1,"
             "\"JOINTS_0\":2,\"WEIGHTS_0\":3}}]}],"
             "\"skins\":[{\"joints\":[4,5],\"inverseBindMatrices\":4}],"
             "\"nodes\":[{\"name\":\"group\",\"extras\":{\"id\":7},\"children\":[%s2],\"translation\":[%g,%g,%g]},"
             "{\"name\":\"panel\",\"mesh\":0},{\"name\":\"lamp\",\"translation\":[0,0.5,2],"
             "\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}},"
             "{\"name\":\"arm\",\"mesh\":1,\"skin\":0},{\"name\":\"base\",\"children\":[5],\"translation\":[-2.2,0,0]},"
             "{\"name\":\"tip\",\"translation\":[%g,%g,%g]},{\"name\":\"extra\",\"mesh\":0,\"translation\":[2.2,0,0]}],"
             "\"animations\":[{\"name\":\"rise\",\"samplers\":[{\"input\":5,\"output\":6}],"
             "\"channels\":[{\"sampler\":0,\"target\":{\"node\":%u,\"path\":\"translation\"}}]},"
             "{\"name\":\"fade\",\"samplers\":[{\"input\":5,\"output\":8},{\"input\":5,\"output\":9}],\"channels\":["
             "{\"sampler\":0,\"target\":" POINTER("/materials/0/pbrMetallicRoughness/baseColorFactor") "},"
             "{\"sampler\":1,\"target\":" POINTER("/extensions/KHR_lights_punctual/lights/0/intensity") "}]}],"
             "\"scenes\":[{\"nodes\":[0,4%s%s]}],\"scene\":0}",
             sizeof binary, (double)f->color[0], (double)f->color[1], (double)f->color[2], (double)f->intensity, f->board_material, f->panel,
             (double)f->group[0], (double)f->group[1], (double)f->group[2], (double)f->tip[0], (double)f->tip[1],
             (double)f->tip[2], 1u, f->arm, f->extra);
    return test_glb(json, &binary, sizeof binary, size);
}

static fnl_scene *load(const struct file *f) {
    size_t size;
    unsigned char *glb = make_glb(f, &size);
    fnl_host host = test_host(&lines);
    fnl_scene *scene;
    if (gltf_load_memory(&host, glb, size, "test.glb", NULL, &scene) != FNL_OK || lines.count) fail_msg("%s", lines.text);
    free(glb);
    const fnl_vec3 ambient = {0.2f, 0.2f, 0.2f}; /* what is shown is seen without the lamp, too */
    assert_int_equal(fnl_scene_set_ambient(scene, ambient, ambient), FNL_OK);
    return scene;
}

static struct stage open_stage(fnl_scene *scene) {
    struct stage stage = stage_open_scene(scene);
    stage.frame.camera = fnl_camera_default();
    stage.frame.camera.position.z = 6;
    stage.frame.exposure = FNL_EXPOSURE_NONE;
    return stage;
}

static fnl_image shoot(struct stage *stage) {
    struct shot shot = stage_shoot(stage, &stage->frame);
    fnl_image radiance = shot.radiance;
    shot.radiance = (fnl_image){0};
    shot_free(&shot);
    return radiance;
}

/* The stage shows what a file shows; returns the number of pixels that differ from `before`. */
static uint64_t expect_file(struct stage *stage, const struct file *f, const fnl_image *before) {
    struct stage built = open_stage(load(f));
    fnl_image a = shoot(stage), b = shoot(&built);
    uint64_t wrong = count_differing(&a, &b), changed = before ? count_differing(&a, before) : 0;
    fnl_image_free(gpu_host(harness_device()), &a);
    fnl_image_free(gpu_host(harness_device()), &b);
    stage_close(&built);
    if (wrong) fail_msg("%llu pixels differ from the scene that was built so", (unsigned long long)wrong);
    return changed;
}

static fnl_entity_info find(const fnl_scene *scene, fnl_entity kind, const char *name) {
    uint32_t index;
    fnl_entity_info info;
    if (fnl_scene_find(scene, kind, name, &index) != FNL_OK) fail_msg("no '%s': %s", name, lines.text);
    assert_int_equal(fnl_scene_query_entity(scene, kind, index, &info), FNL_OK);
    assert_string_equal(info.name, name);
    return info;
}

static fnl_instance_id instance(const fnl_scene *scene, const char *name) {
    return find(scene, FNL_ENTITY_INSTANCE, name).id.instance;
}

static fnl_instance_info instance_info(const fnl_scene *scene, const char *name) {
    uint32_t index;
    fnl_instance_info info;
    assert_int_equal(fnl_scene_find(scene, FNL_ENTITY_INSTANCE, name, &index), FNL_OK);
    assert_int_equal(fnl_scene_query_instance(scene, index, &info), FNL_OK);
    return info;
}

static void test_everything_is_found_by_name(void **state) {
    UNUSED(state);
    fnl_scene *scene = load(&plain);
    const struct {
        fnl_entity kind;
        uint32_t count;
        const char *name, *extras;
    } known[] = {{FNL_ENTITY_INSTANCE, 7, "group", "{\"id\":7}"}, {FNL_ENTITY_INSTANCE, 7, "tip", NULL},
                 {FNL_ENTITY_LIGHT, 1, "bulb", "{\"watts\":60}"}, {FNL_ENTITY_MESH, 2, "flag", "[1,2]"},
                 {FNL_ENTITY_MATERIAL, 2, "paint", "\"gloss\""},  {FNL_ENTITY_ANIMATION, 2, "rise", NULL}};
    for (uint32_t i = 0; i < COUNT_OF(known); i++) {
        assert_int_equal(fnl_scene_count(scene, known[i].kind), known[i].count);
        fnl_entity_info info = find(scene, known[i].kind, known[i].name);
        if (known[i].extras)
            assert_string_equal(info.extras, known[i].extras);
        else
            assert_null(info.extras);
    }
    assert_int_equal(fnl_scene_count(scene, FNL_ENTITY_CAMERA), 0);
    fnl_instance_info tip = instance_info(scene, "tip");
    fnl_instance_id base = instance(scene, "base");
    assert_true(tip.parent.index == base.index && tip.parent.generation == base.generation);
    assert_true(tip.visible && tip.shown && tip.mesh.generation == 0 && fabsf(tip.world.m[12] + 2.2f) < 1e-6f);
    uint32_t index;
    lines.length = 0;
    assert_int_equal(fnl_scene_find(scene, FNL_ENTITY_MATERIAL, "wood", &index), FNL_ERROR_INVALID);
    assert_non_null(strstr(lines.text, "fnl_scene_find: test.glb: there is no 'wood' among the 2 materials: 'paint', 'cloth'"));
    fnl_scene_destroy(&scene);
}

/* Loaded into a scene whose own nodes are hidden then, a file looks as it does alone: geometry, skin, materials, lights, and its animation. */
static void test_a_file_in_a_scene_looks_as_it_does_alone(void **state) {
    UNUSED(state);
    struct file other = plain;
    other.color[1] = 0.9f;
    other.intensity = 80;
    struct stage stage = open_stage(load(&other)), alone = open_stage(load(&plain));
    fnl_image before = shoot(&stage);
    size_t size;
    unsigned char *glb = make_glb(&plain, &size);
    fnl_load_params params = fnl_load_params_default();
    params.data = glb;
    params.size = size;
    fnl_loaded loaded;
    assert_int_equal(fnl_scene_load_into(stage.scene, (fnl_instance_id){0, 0}, "plain.glb", &params, &loaded), FNL_OK);
    free(glb);
    static const char *const roots[] = {"group", "base", "arm", "extra"};
    for (uint32_t i = 0; i < COUNT_OF(roots); i++) /* the first of the name is the scene's own */
        assert_int_equal(fnl_scene_set_instance_visible(stage.scene, instance(stage.scene, roots[i]), false), FNL_OK);
    for (int pose = 0; pose < 2; pose++) {
        if (pose) {
            assert_int_equal(fnl_scene_set_time(stage.scene, loaded.first[FNL_ENTITY_ANIMATION], 0.6), FNL_OK);
            assert_int_equal(fnl_scene_set_time(alone.scene, 0, 0.6), FNL_OK);
        }
        fnl_image a = shoot(&stage), b = shoot(&alone);
        assert_int_equal(count_differing(&a, &b), 0);
        assert_true(count_differing(&a, &before) > 200);
        fnl_image_free(gpu_host(harness_device()), &a);
        fnl_image_free(gpu_host(harness_device()), &b);
    }
    fnl_image_free(gpu_host(harness_device()), &before);
    stage_close(&stage);
    stage_close(&alone);
}

static fnl_loaded load_file(struct stage *stage, const struct file *file) {
    size_t size;
    unsigned char *glb = make_glb(file, &size);
    fnl_load_params params = fnl_load_params_default();
    fnl_loaded loaded;
    params.data = glb;
    params.size = size;
    assert_int_equal(fnl_scene_load_into(stage->scene, (fnl_instance_id){0, 0}, "file.glb", &params, &loaded), FNL_OK);
    free(glb);
    return loaded;
}

static void expect_same_trace(const struct stage *a, const struct stage *b) {
    const fnl_scene *scenes[] = {a->scene, b->scene};
    fnl_trace traces[2];
    fnl_trace_params params = fnl_trace_params_default();
    params.width = params.height = 32;
    params.camera = a->frame.camera;
    for (int i = 0; i < 2; i++) assert_int_equal(fnl_scene_trace(scenes[i], &params, &traces[i]), FNL_OK);
    assert_int_equal(count_differing(&traces[0].radiance, &traces[1].radiance), 0);
    for (int i = 0; i < 2; i++) fnl_trace_free(&scenes[i]->host, &traces[i]);
}

/* Loads and unloads files while they are rendered: each renders as it would in its own scene, and no memory leaks. */
static void test_files_that_come_and_go(void **state) {
    UNUSED(state);
    struct file others[2] = {plain, plain};
    others[0].color[1] = 0.9f;
    others[0].extra = others[0].arm = ""; /* a smaller one */
    others[1].intensity = 90;
    others[1].board_material = 1;
    struct stage stage = open_stage(load(&plain)), alone = open_stage(load(&plain));
    static const char *const roots[] = {"group", "base", "arm", "extra"};
    for (uint32_t i = 0; i < COUNT_OF(roots); i++)
        assert_int_equal(fnl_scene_set_instance_visible(stage.scene, instance(stage.scene, roots[i]), false), FNL_OK);
    assert_int_equal(fnl_scene_set_time(alone.scene, 0, 0.6), FNL_OK);
    fnl_image wanted = shoot(&alone), nothing = shoot(&stage);
    assert_true(count_differing(&wanted, &nothing) > 200);
    uint64_t device_bytes = 0;
    for (uint32_t round = 0; round < 16; round++) {
        const struct file *other = &others[round % 2];
        const bool before = round % 4 < 2; /* whether the freed indices are below those of the remaining file, or above */
        fnl_loaded first = before ? load_file(&stage, other) : load_file(&stage, &plain), second = before ? load_file(&stage, &plain) : load_file(&stage, other);
        if (round % 3 == 0) { /* uploads both files first */
            fnl_image both = shoot(&stage);
            fnl_image_free(gpu_host(harness_device()), &both);
        }
        const fnl_loaded *shown = before ? &second : &first, *gone = before ? &first : &second;
        assert_int_equal(fnl_scene_remove_instance(stage.scene, gone->root), FNL_OK);
        assert_int_equal(fnl_scene_set_time(stage.scene, 2, 0.6), FNL_OK); /* animations 0 and 1 belong to the scene itself */
        fnl_image picture = shoot(&stage);
        if (count_differing(&picture, &wanted)) fail_msg("round %u: %llu pixels differ", round, (unsigned long long)count_differing(&picture, &wanted));
        fnl_image_free(gpu_host(harness_device()), &picture);
        if (round % 8 == 0) expect_same_trace(&stage, &alone);
        assert_int_equal(fnl_scene_remove_instance(stage.scene, shown->root), FNL_OK);
        picture = shoot(&stage);
        assert_int_equal(count_differing(&picture, &nothing), 0);
        fnl_image_free(gpu_host(harness_device()), &picture);
        if (round < 8) device_bytes = gpu_memory_stats(harness_device()).used_bytes;
    }
    assert_int_equal(gpu_memory_stats(harness_device()).used_bytes, device_bytes);
    fnl_image_free(gpu_host(harness_device()), &wanted);
    fnl_image_free(gpu_host(harness_device()), &nothing);
    stage_close(&stage);
    stage_close(&alone);
}

static void test_changes_show_as_if_built_so(void **state) {
    UNUSED(state);
    struct stage stage = open_stage(load(&plain));
    fnl_scene *scene = stage.scene;
    fnl_image first = shoot(&stage);
    struct file wanted = plain;

    const char *const hideable[] = {"extra", "arm"}; /* the latter is skinned */
    for (int i = 0; i < 2; i++) {
        assert_int_equal(fnl_scene_set_instance_visible(scene, instance(scene, hideable[i]), false), FNL_OK);
        struct file without = plain;
        *(i ? &without.arm : &without.extra) = "";
        assert_true(expect_file(&stage, &without, &first) > 200);
        assert_int_equal(fnl_scene_set_instance_visible(scene, instance(scene, hideable[i]), true), FNL_OK);
        assert_int_equal(expect_file(&stage, &plain, &first), 0);
    }

    /* A group with all that is below it: of the file without it the lamp is dark. */
    assert_int_equal(fnl_scene_set_instance_visible(scene, instance(scene, "group"), false), FNL_OK);
    fnl_instance_info panel = instance_info(scene, "panel");
    assert_true(panel.visible && !panel.shown);
    struct file dark = plain;
    dark.panel = "";
    dark.intensity = 0;
    assert_true(expect_file(&stage, &dark, &first) > 200);
    assert_int_equal(fnl_scene_set_instance_visible(scene, instance(scene, "group"), true), FNL_OK);

    assert_int_equal(expect_file(&stage, &plain, &first), 0);
    scene->moved.count = 0; /* from here on moves alone are sent, and only of nodes that are listed */
    scene->moved_since = scene->transform_version;

    fnl_mat4 place = mat4_translation(vec3_make(0.25f, -0.5f, 0.5f));
    assert_int_equal(fnl_scene_set_instance_transform(scene, instance(scene, "group"), &place), FNL_OK);
    wanted.group[0] = 0.25f;
    wanted.group[1] = -0.5f;
    wanted.group[2] = 0.5f;
    assert_true(expect_file(&stage, &wanted, &first) > 200); /* the lamp moves along */

    place = mat4_translation(vec3_make(0.5f, 0.25f, 0)); /* a joint */
    assert_int_equal(fnl_scene_set_instance_transform(scene, instance(scene, "tip"), &place), FNL_OK);
    wanted.tip[0] = 0.5f;
    wanted.tip[1] = 0.25f;
    fnl_image before = shoot(&stage);
    assert_int_equal(expect_file(&stage, &wanted, &before), 0);
    assert_true(count_differing(&before, &first) > 200);
    fnl_image_free(gpu_host(harness_device()), &before);

    fnl_material_params look;
    uint32_t index;
    assert_int_equal(fnl_scene_find(scene, FNL_ENTITY_MATERIAL, "paint", &index), FNL_OK);
    assert_int_equal(fnl_scene_query_material(scene, index, &look), FNL_OK);
    assert_true(look.base_color[0] == 0.8f && look.roughness == 0.5f && look.metallic == 0);
    look.base_color[0] = 0.1f;
    look.base_color[2] = 0.9f;
    before = shoot(&stage);
    assert_int_equal(fnl_scene_set_material(scene, find(scene, FNL_ENTITY_MATERIAL, "paint").id.material, &look), FNL_OK);
    wanted.color[0] = 0.1f;
    wanted.color[2] = 0.9f;
    assert_true(expect_file(&stage, &wanted, &before) > 200);
    fnl_image_free(gpu_host(harness_device()), &before);

    fnl_instance_id arm = instance(scene, "arm"), extra = instance(scene, "extra");
    fnl_light_id bulb = find(scene, FNL_ENTITY_LIGHT, "bulb").id.light;
    assert_int_equal(fnl_scene_remove_instance(scene, instance(scene, "panel")), FNL_OK);
    assert_int_equal(fnl_scene_remove_instance(scene, extra), FNL_OK);
    wanted.panel = wanted.extra = "";
    assert_true(expect_file(&stage, &wanted, &first) > 200);
    assert_int_equal(fnl_scene_count(scene, FNL_ENTITY_INSTANCE), 5);
    assert_int_equal(fnl_scene_set_instance_visible(scene, extra, true), FNL_ERROR_INVALID);
    assert_int_equal(instance(scene, "arm").index, arm.index); /* though it has another index now */
    assert_int_equal(fnl_scene_set_time(scene, 0, 1), FNL_OK); /* of the panel that is gone */
    assert_int_equal(expect_file(&stage, &wanted, NULL), 0);
    fnl_light_params light;
    assert_int_equal(fnl_scene_query_light(scene, 0, &light), FNL_OK);
    light.intensity = 5;
    assert_int_equal(fnl_scene_set_light(scene, bulb, &light), FNL_OK);
    wanted.intensity = 5;
    assert_int_equal(expect_file(&stage, &wanted, NULL), 0);

    /* A light goes with its node, and removed nodes leave their places to nobody: ids stay what they were. */
    assert_int_equal(fnl_scene_remove_instance(scene, instance(scene, "group")), FNL_OK);
    assert_int_equal(fnl_scene_count(scene, FNL_ENTITY_LIGHT), 0);
    assert_int_equal(fnl_scene_set_light(scene, bulb, &light), FNL_ERROR_INVALID);
    fnl_instance_id added;
    const fnl_mat4 identity = mat4_identity();
    assert_int_equal(fnl_scene_add_instance(scene, find(scene, FNL_ENTITY_MESH, "board").id.mesh, &identity, &added), FNL_OK);
    assert_true(added.index > arm.index);
    assert_int_equal(fnl_scene_set_instance_visible(scene, arm, false), FNL_OK);
    fnl_image_free(gpu_host(harness_device()), &first);
    stage_close(&stage);
}

static void test_what_is_set_holds_until_it_is_animated(void **state) {
    UNUSED(state);
    fnl_scene *scene = load(&plain);
    fnl_mat4 place = mat4_translation(vec3_make(3, 4, 5));
    assert_int_equal(fnl_scene_set_time(scene, 0, 1), FNL_OK);
    assert_true(instance_info(scene, "panel").world.m[13] == 0.5f);
    assert_int_equal(fnl_scene_set_instance_transform(scene, instance(scene, "panel"), &place), FNL_OK);
    assert_int_equal(fnl_scene_set_instance_transform(scene, instance(scene, "extra"), &place), FNL_OK);
    assert_int_equal(fnl_scene_set_instance_transform(scene, instance(scene, "group"), &place), FNL_OK);
    assert_true(instance_info(scene, "panel").world.m[13] == 8);
    assert_int_equal(fnl_scene_set_time(scene, 0, 0.5), FNL_OK);
    assert_true(instance_info(scene, "panel").transform.m[13] == 0.25f && instance_info(scene, "panel").transform.m[12] == 0);
    assert_true(instance_info(scene, "panel").world.m[13] == 4.25f); /* animated; below the group, which stays */
    assert_true(instance_info(scene, "extra").world.m[13] == 4);

    /* Lights follow their nodes until they are put elsewhere. */
    fnl_light_id bulb = find(scene, FNL_ENTITY_LIGHT, "bulb").id.light;
    fnl_light_params light;
    assert_int_equal(fnl_scene_query_light(scene, 0, &light), FNL_OK);
    assert_true(light.position.x == 3 && light.position.y == 4.5f && light.position.z == 7);
    light.color[0] = 0.5f;
    assert_int_equal(fnl_scene_set_light(scene, bulb, &light), FNL_OK);
    place = mat4_translation(vec3_make(1, 0, 0));
    assert_int_equal(fnl_scene_set_instance_transform(scene, instance(scene, "group"), &place), FNL_OK);
    assert_int_equal(fnl_scene_query_light(scene, 0, &light), FNL_OK);
    assert_true(light.position.x == 1 && light.position.y == 0.5f && light.color[0] == 0.5f);
    light.position.y = 9;
    assert_int_equal(fnl_scene_set_light(scene, bulb, &light), FNL_OK);
    place = mat4_translation(vec3_make(2, 0, 0));
    assert_int_equal(fnl_scene_set_instance_transform(scene, instance(scene, "group"), &place), FNL_OK);
    assert_int_equal(fnl_scene_query_light(scene, 0, &light), FNL_OK);
    assert_true(light.position.x == 1 && light.position.y == 9);
    assert_int_equal(fnl_scene_remove_instance(scene, instance(scene, "group")), FNL_OK);
    assert_int_equal(fnl_scene_count(scene, FNL_ENTITY_LIGHT), 1); /* it is no longer the node's */
    fnl_scene_destroy(&scene);
}

/* Hiding and recolouring upload no image again; only those that changed or came. */
static void test_images_stay_on_the_device(void **state) {
    UNUSED(state);
    fnl_scene *scene = load(&plain);
    uint8_t pixels[2][4 * 4 * 4];
    fnl_image_id ids[2];
    memset(pixels[0], 200, sizeof pixels[0]);
    memset(pixels[1], 90, sizeof pixels[1]);
    for (int i = 0; i < 2; i++)
        assert_int_equal(fnl_scene_add_image(scene, &(fnl_image){4, 4, FNL_PIXEL_FORMAT_RGBA8, pixels[i]}, true, &ids[i]), FNL_OK);
    fnl_material_id paint = find(scene, FNL_ENTITY_MATERIAL, "paint").id.material;
    fnl_material_params look;
    assert_int_equal(fnl_scene_query_material(scene, paint.index, &look), FNL_OK);
    look.base_color_image = ids[0];
    assert_int_equal(fnl_scene_set_material(scene, paint, &look), FNL_OK);
    struct stage stage = open_stage(scene);
    const struct device_scene *d = stage.renderer->device_scene;
    fnl_image first = shoot(&stage);
    assert_int_equal(d->image_upload_count, 1);
    look.base_color[1] = 0.9f;
    assert_int_equal(fnl_scene_set_material(scene, paint, &look), FNL_OK);
    assert_int_equal(fnl_scene_set_instance_visible(scene, instance(scene, "arm"), false), FNL_OK);
    fnl_image second = shoot(&stage);
    assert_int_equal(d->upload_count, 2);
    assert_int_equal(d->image_upload_count, 1);
    look.base_color_image = ids[1];
    assert_int_equal(fnl_scene_set_material(scene, paint, &look), FNL_OK);
    fnl_image third = shoot(&stage);
    assert_int_equal(d->image_upload_count, 2);
    assert_true(count_differing(&first, &second) > 200);
    assert_true(count_differing(&second, &third) > 200);
    fnl_image_free(gpu_host(harness_device()), &first);
    fnl_image_free(gpu_host(harness_device()), &second);
    fnl_image_free(gpu_host(harness_device()), &third);
    stage_close(&stage);
}

static uint64_t texture_bytes(struct stage *stage) {
    struct shot shot = stage_shoot(stage, &stage->frame);
    uint64_t bytes = 0;
    for (uint32_t k = 0; k < shot.stats.memory_kind_count; k++)
        if (strcmp(shot.stats.memory_kinds[k].name, "textures") == 0) bytes += shot.stats.memory_kinds[k].bytes;
    shot_free(&shot);
    return bytes;
}

/* What is freed is so once no frame that may use it is left. */
static uint64_t texture_bytes_later(struct stage *stage) {
    for (int i = 0; i < 3; i++) (void)texture_bytes(stage);
    return texture_bytes(stage);
}

static void test_images_that_no_material_uses_leave_the_device(void **state) {
    UNUSED(state);
    enum { SIDE = 256, BYTES = SIDE * SIDE * 4 };
    static uint8_t pixels[BYTES];
    fnl_scene *scene = load(&plain);
    fnl_image_id ids[2];
    memset(pixels, 150, sizeof pixels);
    for (int i = 0; i < 2; i++)
        assert_int_equal(fnl_scene_add_image(scene, &(fnl_image){SIDE, SIDE, FNL_PIXEL_FORMAT_RGBA8, pixels}, true, &ids[i]), FNL_OK);
    struct stage stage = open_stage(scene);
    fnl_image first = shoot(&stage);
    const uint64_t none = texture_bytes(&stage);
    fnl_material_id paint = find(scene, FNL_ENTITY_MATERIAL, "paint").id.material;
    fnl_material_params usual, look;
    assert_int_equal(fnl_scene_query_material(scene, paint.index, &usual), FNL_OK);
    look = usual;
    for (int i = 0; i < 3; i++) { /* the first again at the end */
        look.base_color_image = ids[i % 2];
        assert_int_equal(fnl_scene_set_material(scene, paint, &look), FNL_OK);
        const uint64_t one = texture_bytes_later(&stage);
        if (one < none + BYTES || one >= none + 2 * BYTES) fail_msg("%llu bytes, %llu without a texture", (unsigned long long)one, (unsigned long long)none);
    }
    assert_int_equal(fnl_scene_set_material(scene, paint, &usual), FNL_OK);
    assert_int_equal(texture_bytes_later(&stage), none);
    fnl_image last = shoot(&stage);
    assert_int_equal(count_differing(&first, &last), 0);
    fnl_image_free(gpu_host(harness_device()), &last);

    /* A file that goes. */
    char *png;
    size_t png_size, size;
    assert_int_equal(image_png_encode(gpu_host(harness_device()), "x", &(fnl_image){SIDE, SIDE, FNL_PIXEL_FORMAT_RGBA8, pixels}, &png, &png_size), FNL_OK);
    const size_t binary_size = 60 + png_size;
    unsigned char *binary = calloc(1, binary_size);
    const float corners[15] = {-1, -1, 1, 1, -1, 1, 0, 1, 1, 0, 0, 1, 0, 0, 1};
    memcpy(binary, corners, sizeof corners);
    memcpy(binary + 60, png, png_size);
    char json[1500];
    snprintf(json, sizeof json,
             "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":%zu}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":60},"
             "{\"buffer\":0,\"byteOffset\":60,\"byteLength\":%zu}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3,"
             "\"min\":[-1,-1,1],\"max\":[1,1,1]},{\"bufferView\":0,\"byteOffset\":36,\"componentType\":5126,\"type\":\"VEC2\",\"count\":3}],"
             "\"images\":[{\"bufferView\":1,\"mimeType\":\"image/png\"}],\"textures\":[{\"source\":0}],"
             "\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}}],"
             "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1},\"material\":0}]}],"
             "\"nodes\":[{\"mesh\":0}],\"scenes\":[{\"nodes\":[0]}],\"scene\":0}",
             binary_size, png_size);
    unsigned char *glb = test_glb(json, binary, binary_size, &size);
    fnl_load_params params = fnl_load_params_default();
    params.data = glb;
    params.size = size;
    for (int round = 0; round < 4; round++) {
        fnl_loaded loaded;
        params.async = round == 3;
        assert_int_equal(fnl_scene_load_into(scene, (fnl_instance_id){0, 0}, "flag.glb", &params, &loaded), FNL_OK);
        if (round < 3) assert_true(texture_bytes_later(&stage) >= none + BYTES);
        else (void)texture_bytes(&stage); /* it is being decoded, or waits for it */
        assert_int_equal(fnl_scene_remove_instance(scene, loaded.root), FNL_OK);
        assert_int_equal(texture_bytes_later(&stage), none);
        last = shoot(&stage);
        assert_int_equal(count_differing(&first, &last), 0);
        fnl_image_free(gpu_host(harness_device()), &last);
    }
    free(png);
    free(binary);
    free(glb);
    fnl_image_free(gpu_host(harness_device()), &first);
    stage_close(&stage);
}

/* A baked decal is in copies of materials and textures: they follow their originals. */
static void bake(fnl_scene *scene) {
    fnl_decal_params decal = fnl_decal_params_default();
    decal.kind = FNL_DECAL_BAKED;
    decal.instance = instance(scene, "extra");
    decal.color[1] = decal.color[2] = 0;
    /* Its texels show four times; the first of these places is what is painted. */
    decal.transform = mat4_mul(mat4_translation(vec3_make(-0.3f, -0.65f, 0)), mat4_scaling(vec3_make(0.5f, 0.5f, 1)));
    fnl_decal_id id;
    assert_int_equal(fnl_scene_add_decal(scene, &decal, &id), FNL_OK);
}

/* A variant, as if the meshes had its materials, and what is painted on them too. */
static void test_variants_show_as_if_built_so(void **state) {
    UNUSED(state);
    struct file draped = plain;
    draped.board_material = 1;
    fnl_scene *scenes[2] = {load(&plain), load(&draped)};
    struct stage stage = open_stage(scenes[0]);
    fnl_image first = shoot(&stage);
    assert_int_equal(fnl_scene_select_variant(scenes[0], 0), FNL_OK);
    assert_true(expect_file(&stage, &draped, &first) > 200);
    assert_int_equal(fnl_scene_select_variant(scenes[0], FNL_NO_VARIANT), FNL_OK);
    assert_int_equal(expect_file(&stage, &plain, &first), 0);
    fnl_image_free(gpu_host(harness_device()), &first);
    struct stage built = open_stage(scenes[1]);
    first = shoot(&built);
    for (int i = 0; i < 2; i++) bake(scenes[i]);
    assert_int_equal(fnl_scene_select_variant(scenes[0], 0), FNL_OK);
    fnl_image a = shoot(&stage), b = shoot(&built);
    assert_true(count_differing(&b, &first) > 20);
    assert_int_equal(count_differing(&a, &b), 0);
    fnl_image_free(gpu_host(harness_device()), &first);
    fnl_image_free(gpu_host(harness_device()), &a);
    fnl_image_free(gpu_host(harness_device()), &b);
    stage_close(&built);
    stage_close(&stage);
}

static void paint_with(fnl_scene *scene, const fnl_image_id *image, float blue, float specular) {
    fnl_material_id paint = find(scene, FNL_ENTITY_MATERIAL, "paint").id.material;
    fnl_material_params look;
    assert_int_equal(fnl_scene_query_material(scene, paint.index, &look), FNL_OK);
    look.base_color_image = *image;
    look.base_color[2] = blue;
    look.specular = specular;
    assert_int_equal(fnl_scene_set_material(scene, paint, &look), FNL_OK);
}

static void test_baked_decals_follow_their_material(void **state) {
    UNUSED(state);
    uint8_t pixels[2][4 * 8 * 8];
    fnl_image_id images[2][2];
    memset(pixels[0], 230, sizeof pixels[0]);
    memset(pixels[1], 120, sizeof pixels[1]);
    struct stage edited = open_stage(load(&plain)), built = open_stage(load(&plain));
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < 2; k++) {
            uint32_t side = i ? 8 : 4;
            fnl_image image = {side, side, FNL_PIXEL_FORMAT_RGBA8, pixels[i]};
            assert_int_equal(fnl_scene_add_image(k ? built.scene : edited.scene, &image, true, &images[k][i]), FNL_OK);
        }
    paint_with(edited.scene, &images[0][0], 0.1f, 1);
    bake(edited.scene);
    fnl_image before = shoot(&edited);
    paint_with(edited.scene, &images[0][1], 0.1f, 1); /* another picture, of another size */
    paint_with(edited.scene, &images[0][1], 0.6f, 0.2f);
    const fnl_scene *scene = edited.scene;
    uint32_t own = scene->meshes.data[scene->painted.data[0].own_mesh].first_primitive;
    uint32_t picture = scene->materials.data[scene->primitives.data[own].material].textures[SCENE_TEXTURE_BASE_COLOR].image;
    assert_int_equal(scene->images.data[picture].width, 8); /* there is room for it */
    paint_with(built.scene, &images[1][1], 0.6f, 0.2f);
    bake(built.scene);
    fnl_image a = shoot(&edited), b = shoot(&built);
    assert_true(count_differing(&a, &before) > 200);
    assert_int_equal(count_differing(&a, &b), 0);
    fnl_image_free(gpu_host(harness_device()), &a);
    fnl_image_free(gpu_host(harness_device()), &b);
    assert_int_equal(fnl_scene_set_instance_visible(edited.scene, instance(edited.scene, "extra"), false), FNL_OK);
    assert_int_equal(fnl_scene_set_instance_visible(edited.scene, instance(edited.scene, "extra"), true), FNL_OK);
    paint_with(edited.scene, &images[0][0], 0.1f, 1);
    a = shoot(&edited);
    assert_int_equal(count_differing(&a, &before), 0);
    fnl_image_free(gpu_host(harness_device()), &a);
    fnl_image_free(gpu_host(harness_device()), &before);
    stage_close(&edited);
    stage_close(&built);
}

/* A smaller board of other texture coordinates, with the material of the flag; of two triangles, or of one. */
static void shrink_board(fnl_scene *scene, uint32_t index_count) {
    fnl_mesh_id board = find(scene, FNL_ENTITY_MESH, "board").id.mesh;
    fnl_mesh_info info;
    assert_int_equal(fnl_scene_query_mesh(scene, board.index, 0, &info), FNL_OK);
    fnl_mesh_params changed = info.params;
    float *positions = malloc(changed.vertex_count * 12), *uv = malloc(changed.vertex_count * 8);
    for (uint32_t i = 0; i < 3 * changed.vertex_count; i++) positions[i] = info.params.positions[i] * 0.8f;
    for (uint32_t i = 0; i < 2 * changed.vertex_count; i++) uv[i] = 0.5f - 0.4f * positions[i / 2 * 3 + i % 2];
    changed.positions = positions;
    changed.uv = uv;
    changed.tangents = NULL; /* made for the new coordinates */
    changed.index_count = index_count;
    changed.material = find(scene, FNL_ENTITY_MATERIAL, "cloth").id.material;
    assert_int_equal(fnl_scene_set_mesh(scene, board, 0, &changed), FNL_OK);
    free(positions);
    free(uv);
}

/* A mesh that changes under a baked decal is painted anew, for the one instance that has the decal; the others show it plain. */
static void test_baked_decals_follow_their_mesh(void **state) {
    UNUSED(state);
    static const uint32_t index_counts[] = {6, 3};
    for (uint32_t i = 0; i < COUNT_OF(index_counts); i++) {
        struct stage edited = open_stage(load(&plain)), built = open_stage(load(&plain));
        bake(edited.scene);
        fnl_image before = shoot(&edited);
        shrink_board(edited.scene, index_counts[i]);
        fnl_image a = shoot(&edited);
        shrink_board(built.scene, index_counts[i]);
        fnl_image unpainted = shoot(&built);
        bake(built.scene);
        fnl_image b = shoot(&built);
        assert_true(count_differing(&a, &before) > 200);
        assert_true(count_differing(&b, &unpainted) > 20);
        assert_int_equal(count_differing(&a, &b), 0);
        fnl_image_free(gpu_host(harness_device()), &a);
        fnl_image_free(gpu_host(harness_device()), &b);
        fnl_image_free(gpu_host(harness_device()), &before);
        fnl_image_free(gpu_host(harness_device()), &unpainted);
        const fnl_scene *scene = edited.scene;
        fnl_mesh_info info;
        assert_int_equal(fnl_scene_query_mesh(scene, scene->painted.data[0].mesh, 0, &info), FNL_OK);
        lines.length = 0;
        const fnl_mesh_id copy = {scene->painted.data[0].own_mesh, 1};
        assert_int_equal(fnl_scene_set_mesh(edited.scene, copy, 0, &info.params), FNL_ERROR_INVALID);
        assert_non_null(strstr(lines.text, "is a copy that baked decals are painted on, change the mesh itself (index 0)"));
        stage_close(&edited);
        stage_close(&built);
    }
}

/* A skin that is posed by its joints looks as one whose file says so. */
static void test_poses_show_as_if_built_so(void **state) {
    UNUSED(state);
    struct stage stage = open_stage(load(&plain));
    fnl_image first = shoot(&stage);
    struct file wanted = plain;
    wanted.tip[0] = 0.5f;
    wanted.tip[1] = 0.25f;
    const fnl_mat4 joints[2] = {mat4_translation(vec3_make(-2.2f, 0, 0)), mat4_translation(vec3_make(0.5f, 0.25f, 0))};
    const fnl_pose pose = {.joints = joints, .joint_count = 2};
    assert_int_equal(fnl_scene_set_pose(stage.scene, instance(stage.scene, "arm"), &pose), FNL_OK);
    assert_true(expect_file(&stage, &wanted, &first) > 100);
    fnl_image_free(gpu_host(harness_device()), &first);
    stage_close(&stage);
}

/* A material and a light that are animated, between frames. Baked decals too. */
static void test_animated_properties_show_as_if_built_so(void **state) {
    UNUSED(state);
    struct file wanted = plain;
    const float color[] = {0.4375f, 0.375f, 0.25f};
    memcpy(wanted.color, color, sizeof color);
    wanted.intensity = 32;
    for (int baked = 0; baked < 2; baked++) {
        struct stage stage = open_stage(load(&plain)), built = open_stage(load(&wanted));
        if (baked) {
            bake(stage.scene);
            bake(built.scene);
        }
        fnl_image first = shoot(&stage);
        assert_int_equal(fnl_scene_set_time(stage.scene, 1, 0.25), FNL_OK);
        fnl_image a = shoot(&stage), b = shoot(&built);
        assert_true(count_differing(&a, &first) > 1000);
        assert_int_equal(count_differing(&a, &b), 0);
        fnl_image_free(gpu_host(harness_device()), &first);
        fnl_image_free(gpu_host(harness_device()), &a);
        fnl_image_free(gpu_host(harness_device()), &b);
        stage_close(&stage);
        stage_close(&built);
    }
}

/* A texture that is moved on its surface takes along what is painted on it. */
static void test_baked_decals_follow_texture_transforms(void **state) {
    UNUSED(state);
    uint8_t pixels[4 * 8 * 8];
    for (uint32_t i = 0; i < sizeof pixels; i++) pixels[i] = (uint8_t)(100 + i % 32 * 4);
    struct stage stages[2] = {open_stage(load(&plain)), open_stage(load(&plain))};
    fnl_image pictures[2], first = {0};
    for (int k = 0; k < 2; k++) {
        fnl_scene *scene = stages[k].scene;
        const fnl_image image = {8, 8, FNL_PIXEL_FORMAT_RGBA8, pixels};
        const struct scene_texture_turn turn = {.offset = {0.25f, 0}, .scale = {0.5f, 0.5f}};
        fnl_image_id id;
        assert_int_equal(fnl_scene_add_image(scene, &image, true, &id), FNL_OK);
        paint_with(scene, &id, 0.1f, 1);
        if (k == 0) {
            bake(scene);
            first = shoot(&stages[k]);
        }
        const uint32_t paint = find(scene, FNL_ENTITY_MATERIAL, "paint").id.material.index;
        const struct scene_material before = scene->materials.data[paint];
        scene_turn_texture(&scene->materials.data[paint].textures[SCENE_TEXTURE_BASE_COLOR], &turn);
        scene_materials_changed(scene);
        assert_int_equal(scene_repaint(scene, paint, &before), FNL_OK);
        if (k == 1) bake(scene);
        pictures[k] = shoot(&stages[k]);
    }
    assert_true(count_differing(&pictures[0], &first) > 200);
    assert_int_equal(count_differing(&pictures[0], &pictures[1]), 0);
    fnl_image_free(gpu_host(harness_device()), &first);
    for (int k = 0; k < 2; k++) {
        fnl_image_free(gpu_host(harness_device()), &pictures[k]);
        stage_close(&stages[k]);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_everything_is_found_by_name, harness_check),
        cmocka_unit_test_teardown(test_a_file_in_a_scene_looks_as_it_does_alone, harness_check),
        cmocka_unit_test_teardown(test_files_that_come_and_go, harness_check),
        cmocka_unit_test_teardown(test_changes_show_as_if_built_so, harness_check),
        cmocka_unit_test_teardown(test_what_is_set_holds_until_it_is_animated, harness_check),
        cmocka_unit_test_teardown(test_variants_show_as_if_built_so, harness_check),
        cmocka_unit_test_teardown(test_images_stay_on_the_device, harness_check),
        cmocka_unit_test_teardown(test_images_that_no_material_uses_leave_the_device, harness_check),
        cmocka_unit_test_teardown(test_baked_decals_follow_their_material, harness_check),
        cmocka_unit_test_teardown(test_baked_decals_follow_their_mesh, harness_check),
        cmocka_unit_test_teardown(test_poses_show_as_if_built_so, harness_check),
        cmocka_unit_test_teardown(test_animated_properties_show_as_if_built_so, harness_check),
        cmocka_unit_test_teardown(test_baked_decals_follow_texture_transforms, harness_check),
    };
    return cmocka_run_group_tests_name("render: edits", tests, harness_begin, harness_end);
}
