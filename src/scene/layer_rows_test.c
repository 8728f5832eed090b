/* SPDX-License-Identifier: MIT */
/* Every row of material_layers.h: through the public params and back, through a saved file, from an animation, and by its texture. */
#include "scene/layer_rows.h"
#include "tests/gltf_test_file.h"

#include <setjmp.h>
#include <unistd.h>

#include <cmocka.h>

static struct test_log lines;
static char saved[64];

static int make_path(void **state) {
    UNUSED(state);
    snprintf(saved, sizeof saved, "/tmp/fanal-layers-%ld.glb", (long)getpid());
    return 0;
}

static int remove_file(void **state) {
    UNUSED(state);
    unlink(saved);
    return 0;
}

static fnl_scene *empty_scene(void) {
    fnl_host host = test_host(&lines);
    fnl_scene *scene = NULL;
    assert_int_equal(fnl_scene_create(&host, &scene), FNL_OK);
    return scene;
}

/* A value within the limits that is neither a default nor that of another component. */
static float value_of(const struct layer_number *number, uint32_t component) {
    return (number->low >= 1 ? number->low : 0) + 0.375f + 0.125f * (float)component;
}

static void set_values(fnl_material_params *params, const fnl_layer_number *row, const struct layer_number *number) {
    for (uint32_t c = 0; c < row->count; c++) {
        const float value = value_of(number, c);
        memcpy((char *)params + row->offset + c * sizeof value, &value, sizeof value);
    }
}

static fnl_material_params query(const fnl_scene *scene) {
    fnl_material_params params;
    assert_int_equal(fnl_scene_query_material(scene, 0, &params), FNL_OK);
    return params;
}

static void expect_number(const fnl_scene *scene, const struct layer_number *number, const char *where) {
    const fnl_material_params params = query(scene);
    const float *values = (const float *)(const void *)((const char *)&params + number->params_offset);
    for (uint32_t c = 0; c < number->count; c++)
        if (values[c] != value_of(number, c)) fail_msg("%s %s: %g, not %g", number->name, where, (double)values[c], (double)value_of(number, c));
}

static fnl_scene *saved_and_loaded(const fnl_scene *scene) {
    fnl_host host = test_host(&lines);
    fnl_scene *again = NULL;
    assert_int_equal(fnl_scene_save(scene, saved, NULL), FNL_OK);
    assert_int_equal(fnl_scene_load(&host, saved, NULL, &again), FNL_OK);
    return again;
}

/* Switched on, so that the material is saved as one with the layer; textures are there, since some numbers stand in them. */
static void test_numbers_survive_calls_and_files(void **state) {
    UNUSED(state);
    const uint8_t white[4] = {255, 255, 255, 255};
    const fnl_image picture = {1, 1, FNL_PIXEL_FORMAT_RGBA8, (void *)(uintptr_t)white};
    fnl_layer_number row;
    uint32_t count = 0;
    for (; fnl_layer_number_query(count, &row); count++) {
        const struct layer_number *number = &layer_numbers[count];
        fnl_scene *scene = empty_scene();
        fnl_material_params params = fnl_material_params_default();
        fnl_material_id id;
        fnl_image_id image;
        assert_string_equal(row.name, number->name);
        assert_true(row.least < row.most && row.count == number->count && row.offset < sizeof params);
        assert_int_equal(fnl_scene_add_image(scene, &picture, false, &image), FNL_OK);
        params.clearcoat.normal_image = image;
        set_values(&params, &row, number);
        assert_int_equal(fnl_scene_add_material(scene, &params, &id), FNL_OK);
        expect_number(scene, number, "by a call");
        if (number->on != LAYER_NO_SWITCH) {
            assert_true(scene_material_layered(&scene->materials.data[0]));
            assert_int_equal(scene_material_layered_besides(&scene->materials.data[0]), number->on == LAYER_FORWARD);
        }
        fnl_scene *again = saved_and_loaded(scene);
        expect_number(again, number, "from a file");
        fnl_scene_destroy(&again);
        fnl_scene_destroy(&scene);
    }
    assert_int_equal(count, LAYER_NUMBER_COUNT);
}

static void test_numbers_are_animated(void **state) {
    UNUSED(state);
    for (uint32_t i = 0; i < LAYER_NUMBER_COUNT; i++) {
        const struct layer_number *number = &layer_numbers[i];
        char json[2048], layer[512];
        float keys[4] = {0}; /* the time, then the value */
        for (uint32_t c = 0; c < number->count; c++) keys[1 + c] = value_of(number, c);
        const char *slash = strchr(number->key, '/');
        snprintf(layer, sizeof layer, slash ? "{\"%.*s\":{\"index\":0}}" : "{}", slash ? (int)(slash - number->key) : 0, number->key);
        snprintf(json, sizeof json,
                 "{\"asset\":{\"version\":\"2.0\"},\"extensionsUsed\":[\"KHR_animation_pointer\",\"%s\"],"
                 "\"buffers\":[{\"byteLength\":16}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":16}],\"accessors\":["
                 "{\"bufferView\":0,\"componentType\":5126,\"type\":\"SCALAR\",\"count\":1,\"min\":[0],\"max\":[0]},"
                 "{\"bufferView\":0,\"byteOffset\":4,\"componentType\":5126,\"type\":\"%s\",\"count\":1}],"
                 "\"images\":[{\"uri\":\"data:image/png;base64," TEST_PNG_BASE64 "\"}],\"textures\":[{\"source\":0}],"
                 "\"materials\":[{\"extensions\":{\"%s\":%s}}],\"animations\":[{\"samplers\":[{\"input\":0,\"output\":1,\"interpolation\":\"STEP\"}],"
                 "\"channels\":[{\"sampler\":0,\"target\":{\"path\":\"pointer\",\"extensions\":{\"KHR_animation_pointer\":{\"pointer\":"
                 "\"/materials/0/extensions/%s/%s\"}}}}]}]}",
                 number->extension, number->count == 3 ? "VEC3" : "SCALAR", number->extension, layer, number->extension, number->key);
        fnl_scene *scene = NULL;
        if (test_load(&lines, json, keys, sizeof keys, &scene) != FNL_OK || lines.count) fail_msg("%s: %s", number->name, lines.text);
        assert_int_equal(fnl_scene_set_time(scene, 0, 0), FNL_OK);
        expect_number(scene, number, "animated");
        fnl_scene_destroy(&scene);
    }
}

static void test_textures_survive_calls_and_files(void **state) {
    UNUSED(state);
    const uint8_t white[4] = {255, 255, 255, 255};
    const fnl_image picture = {1, 1, FNL_PIXEL_FORMAT_RGBA8, (void *)(uintptr_t)white};
    fnl_layer_texture row;
    uint32_t count = 0;
    for (; fnl_layer_texture_query(count, &row); count++) {
        fnl_scene *scene = empty_scene();
        fnl_material_params params = fnl_material_params_default(), told;
        fnl_material_id id;
        fnl_image_id image;
        const enum scene_texture_slot slot = layer_textures[count].slot;
        assert_int_equal(slot, SCENE_TEXTURE_CORE_COUNT + count);
        assert_int_equal(fnl_scene_add_image(scene, &picture, scene_texture_is_color(slot), &image), FNL_OK);
        memcpy((char *)&params + row.offset, &image, sizeof image);
        assert_int_equal(fnl_scene_add_material(scene, &params, &id), FNL_OK);
        assert_int_equal(scene->materials.data[0].textures[slot].image, image.index);
        told = query(scene);
        assert_memory_equal((char *)&told + row.offset, &image, sizeof image);
        for (uint32_t other = 0; other < LAYER_TEXTURE_COUNT; other++) { /* and no other */
            fnl_image_id id_of_other;
            memcpy(&id_of_other, (char *)&told + layer_textures[other].params_offset, sizeof id_of_other);
            assert_int_equal(id_of_other.generation != 0, other == count);
        }
        fnl_scene *again = saved_and_loaded(scene);
        const uint32_t loaded = again->materials.data[0].textures[slot].image;
        if (loaded == SCENE_NONE) fail_msg("%s was not saved", row.name);
        assert_int_equal(again->images.data[loaded].color, scene_texture_is_color(slot));
        assert_int_equal(again->images.data[loaded].normals, scene_texture_is_normals(slot));
        fnl_scene_destroy(&again);
        fnl_scene_destroy(&scene);
    }
    assert_int_equal(count, LAYER_TEXTURE_COUNT);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_numbers_survive_calls_and_files),
        cmocka_unit_test(test_numbers_are_animated),
        cmocka_unit_test(test_textures_survive_calls_and_files),
    };
    return cmocka_run_group_tests(tests, make_path, remove_file);
}
