/* SPDX-License-Identifier: MIT */
/* Textures of KTX2 and DDS in glTF files: which image a texture shows, and what is said of those that cannot be. */
#include "tests/gltf_test_file.h"

#include <setjmp.h>

#include <cmocka.h>

#include "tests/texture_file.h"

static struct test_log file_log;
static unsigned char binary[8192];
static size_t ktx2_size;

/* The buffer: a PNG, and from byte 128 on a KTX2 file. */
static void fill(const struct test_ktx2 *in) {
    static const unsigned char pixels[4096] = {9, 8, 7, 6};
    struct test_ktx2 file = *in;
    file.bytes = pixels;
    file.mips = 1;
    file.width = file.height = 8;
    if (!file.sizes[0]) file.sizes[0] = 8 * 8 * 4;
    unsigned char *bytes = test_ktx2_make(&file, &ktx2_size);
    memcpy(binary, test_png, sizeof test_png);
    memcpy(binary + 128, bytes, ktx2_size);
    free(bytes);
}

/* `used`: members of the document; `texture`: of its texture; `slot`: of its material. */
static fnl_scene *load(const char *used, const char *texture, const char *slot, const char *mime) {
    char json[4096];
    snprintf(json, sizeof json,
             "{\"asset\":{\"version\":\"2.0\"}%s,\"buffers\":[{\"byteLength\":%zu}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":%zu},"
             "{\"buffer\":0,\"byteOffset\":128,\"byteLength\":%zu}],\"images\":[{\"bufferView\":0,\"mimeType\":\"image/png\"},{\"bufferView\":1,\"mimeType\":\"%s\"}],\"textures\":[{%s}],"
             "\"materials\":[{%s}]}",
             used, 128 + ktx2_size, sizeof test_png, ktx2_size, mime, texture, slot);
    fnl_scene *scene;
    assert_int_equal(test_load(&file_log, json, binary, 128 + ktx2_size, &scene), FNL_OK);
    return scene;
}

#define USED ",\"extensionsUsed\":[\"KHR_texture_basisu\"]"
#define BASISU "\"extensions\":{\"KHR_texture_basisu\":{\"source\":1}}"
#define COLOR "\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}"
#define NORMAL "\"normalTexture\":{\"index\":0}"

static const struct test_ktx2 rgba8_srgb = {.format = 43}, rgba8_linear = {.format = 37};

static uint32_t color_image(const fnl_scene *scene) { return scene->materials.data[0].textures[SCENE_TEXTURE_BASE_COLOR].image; }

static void test_the_extension_comes_before_the_source_MA_8(void **state) {
    UNUSED(state);
    fill(&rgba8_srgb);
    fnl_scene *scene = load(USED ",\"extensionsRequired\":[\"KHR_texture_basisu\"]", "\"source\":0," BASISU, COLOR, "image/ktx2");
    assert_string_equal(file_log.text, "");
    assert_int_equal(color_image(scene), 1);
    const struct scene_image *image = &scene->images.data[1];
    assert_string_equal(image->file_kind, "ktx2");
    assert_true(image->width == 8 && image->height == 8 && image->color && !image->normals);
    assert_string_equal(scene->extensions.data[0].name, "KHR_texture_basisu");
    assert_string_equal(scene->extensions.data[0].treatment, "full");
    fnl_scene_destroy(&scene);
    scene = load(USED, BASISU, COLOR, "image/ktx2");
    assert_int_equal(color_image(scene), 1);
    fnl_scene_destroy(&scene);
    scene = load(USED, BASISU, NORMAL, "image/ktx2");
    assert_true(!scene->images.data[1].color && scene->images.data[1].normals);
    fnl_scene_destroy(&scene);
    scene = load(USED, "\"source\":0", COLOR, "image/ktx2");
    assert_int_equal(color_image(scene), 0);
    fnl_scene_destroy(&scene);
}

static void expect_message(const struct test_ktx2 *in, const char *used, const char *slot, const char *mime, uint32_t width, const char *message) {
    fill(in);
    fnl_scene *scene = load(used, BASISU, slot, mime);
    if (!strstr(file_log.text, message)) fail_msg("'%s' is not in '%s'", message, file_log.text);
    assert_int_equal(file_log.count, *used ? 1 : 2); /* the extension's object is spoken of too */
    assert_int_equal(scene->images.data[1].width, width);
    fnl_scene_destroy(&scene);
}

static void test_what_is_said_of_files_MA_8(void **state) {
    UNUSED(state);
    expect_message(&rgba8_linear, USED, COLOR, "image/ktx2", 8,
                   "/materials/0/pbrMetallicRoughness/baseColorTexture: is a texture of colours, but the file of image 1 says that it holds linear values");
    expect_message(&rgba8_srgb, USED, NORMAL, "image/ktx2", 8,
                   "/materials/0/normalTexture: is a texture of numbers, but the file of image 1 says that it holds colours of sRGB");
    expect_message(&rgba8_srgb, USED, COLOR, "image/png", 8, "/images/1: its mimeType is 'image/png', but the bytes are image/ktx2");
    expect_message(&rgba8_srgb, "", COLOR, "image/ktx2", 8, "KHR_texture_basisu is not in extensionsUsed");
    expect_message(&(struct test_ktx2){.format = 97, .sizes = {8 * 8 * 8}}, USED, "", "image/ktx2", 0,
                   "/images/1: is a picture of floats, not of 8 bits a channel; it is shown as white");
    expect_message(&(struct test_ktx2){.format = 43, .faces = 6, .sizes = {8 * 8 * 24}}, USED, "", "image/ktx2", 0,
                   "/images/1: is a cube map, not a picture; it is shown as white");
    expect_message(&(struct test_ktx2){.format = 43, .sizes = {17}}, USED, "", "image/ktx2", 0,
                   "/images/1: the picture: broken KTX2: level 0 has 17 bytes, not 256 (at byte 88); it is shown as white");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_the_extension_comes_before_the_source_MA_8),
        cmocka_unit_test(test_what_is_said_of_files_MA_8),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
