/* SPDX-License-Identifier: MIT */
/** Frames with textures of KTX2 files: which mips they show, and that blocks which stay compressed on the device look as they do decoded. */
#include "base/file.h"
#include "image/blocks.h"
#include "image/texture.h"
#include "ray/texture.h"
#include "tests/render_harness.h"
#include "tests/texture_file.h"

/* ---- files ---- */

enum { WIDTH = 128, HEIGHT = 64, MIPS = 8, LARGE = 2048, LARGE_MIPS = 12 };

struct bytes {
    unsigned char *data;
    size_t size;
    uint32_t width, height;
};

static fnl_host quiet_host(void) { return host_resolve(NULL); }

/* Random texels or blocks; `tint`: of RGBA8, each mip has one colour. */
static struct texture make_texture(enum texture_format format, uint32_t width, uint32_t height, uint32_t mips, bool tint) {
    const fnl_host host = quiet_host();
    struct random_state random = {5};
    struct texture t = {.format = format, .width = width, .height = height, .faces = 1, .mips = mips};
    assert_int_equal(texture_allocate(&host, &t), FNL_OK);
    const size_t size = texture_offset(&t, mips, 0);
    for (size_t i = 0; i < size; i++) t.bytes[i] = (unsigned char)(random_bits(&random) >> 40);
    for (uint32_t mip = 0; tint && mip < mips; mip++)
        for (size_t i = texture_offset(&t, mip, 0); i < texture_offset(&t, mip + 1, 0); i++)
            t.bytes[i] = i % 4 == 3 ? 255 : (unsigned char)((mip + 1) >> i % 4 & 1 ? 220 : 20);
    return t;
}

static struct bytes make_file(const struct texture *t, uint32_t vulkan) {
    struct test_ktx2 in = {.format = vulkan, .width = t->width, .height = t->height, .mips = t->mips, .scheme = 2, .bytes = t->bytes};
    for (uint32_t mip = 0; mip < t->mips; mip++) in.sizes[mip] = texture_face_bytes(t, mip);
    struct bytes out = {.width = t->width, .height = t->height};
    out.data = test_ktx2_make(&in, &out.size);
    return out;
}

/* ---- a board that fills the picture ---- */

struct board {
    const struct bytes *file; /* or the pixels of `raw` */
    const struct texture *raw;
    bool color, async, nearest, base; /* color: sRGB; nearest: texels are not filtered; base: only mip 0 is shown */
};

static uint32_t add_image(fnl_scene *scene, const struct board *b) {
    struct scene_image image = {.name = "board", .file_kind = "ktx2", .width = WIDTH, .height = HEIGHT, .color = b->color, .async = b->async};
    if (b->raw) image.pixels = arena_copy(&scene->arena, b->raw->bytes, (size_t)WIDTH * HEIGHT * 4);
    if (b->file) {
        image.encoded = b->file->data;
        image.encoded_size = b->file->size;
        image.width = b->file->width;
        image.height = b->file->height;
    }
    return scene_add_image(scene, &image);
}

/* One is near and shows mip 0; the other is small and far. */
static fnl_scene *make_scene(const struct board *b) {
    static const float positions[12] = {-1, -0.5f, 0, 1, -0.5f, 0, 1, 0.5f, 0, -1, 0.5f, 0}, uv[8] = {0, 1, 1, 1, 1, 0, 0, 0};
    static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    fnl_scene *scene;
    assert_int_equal(fnl_scene_create(NULL, &scene), FNL_OK);
    fnl_material_params look = fnl_material_params_default();
    const fnl_image_id id = {add_image(scene, b), FIRST_GENERATION};
    look.unlit = true;
    look.double_sided = true;
    fnl_material_id material;
    assert_int_equal(fnl_scene_add_material(scene, &look, &material), FNL_OK);
    struct scene_texture *texture = &scene->materials.data[material.index].textures[SCENE_TEXTURE_BASE_COLOR];
    const struct scene_sampler texels = {.mipmapped = !b->base};
    texture->image = id.index;
    if (b->nearest) texture->sampler = scene_add_sampler(scene, &texels);
    const fnl_mesh_params mesh = {.vertex_count = 4, .index_count = 6, .positions = positions, .uv = uv, .indices = indices, .material = material};
    fnl_mesh_id mesh_id;
    fnl_instance_id instance;
    assert_int_equal(fnl_scene_add_mesh(scene, &mesh, &mesh_id), FNL_OK);
    for (int i = 0; i < 2; i++) {
        const fnl_mat4 place = mat4_translation(i ? vec3_make(0, 4, -12) : vec3_make(0, 0, 0));
        assert_int_equal(fnl_scene_add_instance(scene, mesh_id, &place, &instance), FNL_OK);
    }
    assert_int_equal(fnl_scene_set_ambient(scene, (fnl_vec3){1, 1, 1}, (fnl_vec3){0.2f, 0.2f, 0.2f}), FNL_OK);
    return scene;
}

static struct stage open_stage(const struct board *b) {
    struct stage stage = stage_open_scene(make_scene(b));
    stage.frame.width = b->nearest ? 192 : 64; /* 192: every texel of the near board is seen */
    stage.frame.height = b->nearest ? 144 : 48;
    stage.frame.ev = 0;
    stage.frame.shading = FNL_SHADING_FORWARD;
    stage.frame.lists = FNL_LISTS_ALL;
    stage.frame.camera = fnl_camera_default();
    stage.frame.camera.position = vec3_make(0, 0.4f, 2.2f);
    stage.frame.camera.target = vec3_make(0, 0.4f, 0);
    return stage;
}

static const struct gpu_image *device_image(const struct stage *stage) { return &stage->renderer->device_scene->images.data[0].gpu; }

static struct shot shoot(const struct board *b, VkFormat *out_format) {
    struct stage stage = open_stage(b);
    struct shot shot = stage_shoot(&stage, &stage.frame);
    if (out_format) *out_format = device_image(&stage)->params.format;
    stage_close(&stage);
    return shot;
}

static void expect_near(const struct shot *a, const struct shot *b, int most, const char *what) {
    const uint8_t *x = a->color.pixels, *y = b->color.pixels;
    int worst = 0;
    for (size_t i = 0; i < (size_t)a->color.width * a->color.height * 4; i++) worst = MAX(worst, abs(x[i] - y[i]));
    if (worst > most) fail_msg("%s: pixels differ by %d", what, worst);
}

/* ---- tests ---- */

/* A file without smaller mips is as good as pixels, of which they are made. */
static void test_one_mip_is_as_pixels_MA_8(void **state) {
    UNUSED(state);
    const fnl_host host = quiet_host();
    struct texture t = make_texture(TEXTURE_RGBA8, WIDTH, HEIGHT, 1, false);
    struct bytes file = make_file(&t, 43);
    struct shot a = shoot(&(struct board){.file = &file, .color = true}, NULL), b = shoot(&(struct board){.raw = &t, .color = true}, NULL);
    expect_near(&a, &b, 0, "one mip");
    assert_int_equal(count_differing(&a.radiance, &b.radiance), 0);
    shot_free(&a);
    shot_free(&b);
    free(file.data);
    texture_free(&host, &t);
}

/* The far board shows smaller mips of the file, on the device at once or in the background, and in the tracer's pictures. */
static void test_mips_are_those_of_the_file_MA_8(void **state) {
    UNUSED(state);
    fnl_host host = quiet_host();
    struct texture t = make_texture(TEXTURE_RGBA8, WIDTH, HEIGHT, MIPS, true);
    struct bytes file = make_file(&t, 43);
    struct shot a = shoot(&(struct board){.file = &file, .color = true, .nearest = true}, NULL);
    struct stage stage = open_stage(&(struct board){.file = &file, .color = true, .nearest = true, .async = true});
    while (fnl_renderer_render(stage.renderer, &stage.frame) == FNL_OK && counter_of(stage.renderer, "images.pending"));
    struct shot b = stage_shoot(&stage, &stage.frame);
    expect_near(&a, &b, 0, "in the background");
    stage_close(&stage);
    /* Mip 0 is red; the far board shows mip 2 or 3, red and green or blue. */
    const float *radiance = a.radiance.pixels, *near_pixel = radiance + 4 * (90 * 192 + 96);
    float green_or_blue = 0;
    for (uint32_t y = 0; y < 60; y++) {
        const float *pixel = radiance + 4 * (y * 192 + 96);
        green_or_blue = fmaxf(green_or_blue, fmaxf(pixel[1], pixel[2]));
    }
    assert_true(near_pixel[0] > 10 * near_pixel[1] && near_pixel[0] > 10 * near_pixel[2]);
    assert_true(green_or_blue > 0.9f * near_pixel[0]);
    /* The tracer has the same levels. */
    fnl_scene *scene = make_scene(&(struct board){.file = &file, .color = true});
    struct jobs *jobs;
    struct ray_image *images;
    assert_int_equal(jobs_create(&host, &jobs), FNL_OK);
    assert_int_equal(ray_images_create(scene, jobs, &images), FNL_OK);
    assert_int_equal(images[0].level_count, MIPS);
    assert_memory_equal(images[0].pixels, t.bytes, texture_offset(&t, MIPS, 0));
    ray_images_destroy(scene, &images);
    jobs_destroy(&jobs);
    fnl_scene_destroy(&scene);
    shot_free(&a);
    shot_free(&b);
    free(file.data);
    texture_free(&host, &t);
}

/* 21 MiB of mips come over three frames or more; then they are those of a file that frames waited for. */
static void test_mips_come_in_parts_MA_8(void **state) {
    UNUSED(state);
    const fnl_host host = quiet_host();
    struct texture t = make_texture(TEXTURE_RGBA8, LARGE, LARGE, LARGE_MIPS, false);
    struct bytes file = make_file(&t, 43);
    struct stage stage = open_stage(&(struct board){.file = &file, .color = true, .nearest = true, .base = true, .async = true});
    const struct device_scene *d = stage.renderer->device_scene;
    uint32_t parts = 0;
    for (uint64_t pending = 1; pending;) {
        const uint64_t before = d->bytes_uploaded;
        assert_int_equal(fnl_renderer_render(stage.renderer, &stage.frame), FNL_OK);
        pending = counter_of(stage.renderer, "images.pending");
        assert_true(d->bytes_uploaded - before <= DEVICE_IMAGE_BYTES + (64 << 10)); /* and materials */
        parts += d->bytes_uploaded - before > 1 << 20;
    }
    assert_int_equal(parts, 3);
    struct shot shot = stage_shoot(&stage, &stage.frame);
    struct shot wanted = shoot(&(struct board){.file = &file, .color = true, .nearest = true, .base = true}, NULL); /* later: memory may keep what was there */
    assert_int_equal(count_differing(&shot.radiance, &wanted.radiance), 0);
    shot_free(&shot);
    shot_free(&wanted);
    stage_close(&stage);
    free(file.data);
    texture_free(&host, &t);
}

/* Blocks of BC7: mip 0 has every mode with every pattern. */
static void mark_modes(struct texture *t) {
    assert_true(texture_face_bytes(t, 0) == 8 * 64 * 16);
    for (size_t k = 0; k < texture_offset(t, t->mips, 0) / 16; k++) {
        const uint32_t mode = k % 8, low = 1u << mode | (uint32_t)(k / 8 % 64) << (mode + 1), bits = mode + 7;
        unsigned char *block = t->bytes + 16 * k;
        const uint32_t old = block[0] | (uint32_t)block[1] << 8, value = (old & ~((1u << bits) - 1)) | low;
        block[0] = (unsigned char)value;
        block[1] = (unsigned char)(value >> 8);
    }
}

/* What the device makes of random blocks is within rounding what our decoders make of them: BC7 to the bit, all patterns of all modes. */
static void test_blocks_stay_compressed_MA_8(void **state) {
    UNUSED(state);
    static const struct {
        enum texture_format format;
        VkFormat linear, srgb; /* srgb: of the file */
        int most; /* difference */
    } cases[] = {{TEXTURE_BC1, VK_FORMAT_BC1_RGB_UNORM_BLOCK, VK_FORMAT_BC1_RGB_SRGB_BLOCK, 2},
                 {TEXTURE_BC1_ALPHA, VK_FORMAT_BC1_RGBA_UNORM_BLOCK, VK_FORMAT_BC1_RGBA_SRGB_BLOCK, 2},
                 {TEXTURE_BC3, VK_FORMAT_BC3_UNORM_BLOCK, VK_FORMAT_BC3_SRGB_BLOCK, 2},
                 {TEXTURE_BC7, VK_FORMAT_BC7_UNORM_BLOCK, VK_FORMAT_BC7_SRGB_BLOCK, 1},
                 {TEXTURE_BC7, VK_FORMAT_BC7_UNORM_BLOCK, 0, 0},
                 {TEXTURE_BC4, VK_FORMAT_BC4_UNORM_BLOCK, 0, 2},
                 {TEXTURE_BC5, VK_FORMAT_BC5_UNORM_BLOCK, 0, 2}};
    const fnl_host host = quiet_host();
    if (!gpu_info(harness_device())->texture_compression) skip();
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        const bool color = cases[i].srgb != 0;
        struct texture t = make_texture(cases[i].format, WIDTH, HEIGHT, MIPS, false), decoded;
        if (cases[i].format == TEXTURE_BC7) mark_modes(&t);
        struct bytes file = make_file(&t, color ? cases[i].srgb : cases[i].linear);
        assert_int_equal(texture_decode(&host, file.data, file.size, "blocks", &(struct texture_use){.mips = true}, &decoded), FNL_OK);
        struct bytes plain = make_file(&decoded, color ? 43 : 37);
        VkFormat format, plain_format;
        struct shot a = shoot(&(struct board){.file = &file, .color = color, .nearest = true}, &format),
                    b = shoot(&(struct board){.file = &plain, .color = color, .nearest = true}, &plain_format);
        assert_int_equal(format, cases[i].linear);
        assert_int_equal(plain_format, VK_FORMAT_R8G8B8A8_UNORM);
        if (color) expect_near(&a, &b, cases[i].most, "blocks");
        const float *x = a.radiance.pixels, *y = b.radiance.pixels; /* of which white is 1 */
        float worst = 0;
        for (size_t k = 0; !color && k < (size_t)a.radiance.width * a.radiance.height * 4; k++) worst = fmaxf(worst, fabsf(x[k] - y[k]));
        assert_true(worst * 255 <= (float)cases[i].most + 1e-3f);
        shot_free(&a);
        shot_free(&b);
        free(file.data);
        free(plain.data);
        texture_free(&host, &decoded);
        texture_free(&host, &t);
    }
}

/* Files of Basis Universal are BC7 on a device that samples it: a quarter of the bytes, the picture within its rounding. */
static void test_basis_universal_is_BC7_MA_8(void **state) {
    UNUSED(state);
    static const char *const paths[] = {"tests/textures/uastc_zstd.ktx2", "tests/textures/etc1s.ktx2"};
    const fnl_host host = quiet_host();
    const bool able = gpu_info(harness_device())->texture_compression;
    for (uint32_t i = 0; i < COUNT_OF(paths); i++) {
        struct file_view view;
        struct texture plain;
        assert_int_equal(file_load(&host, paths[i], &view), FNL_OK);
        assert_int_equal(texture_decode(&host, view.data, view.size, paths[i], &(struct texture_use){.mips = true}, &plain), FNL_OK);
        struct bytes file = {(unsigned char *)view.data, view.size, plain.width, plain.height}, decoded = make_file(&plain, 43);
        uint64_t uploaded[2];
        struct shot shots[2];
        for (uint32_t k = 0; k < 2; k++) {
            struct stage stage = open_stage(&(struct board){.file = k ? &decoded : &file, .color = true});
            shots[k] = stage_shoot(&stage, &stage.frame);
            assert_int_equal(device_image(&stage)->params.format, able && !k ? VK_FORMAT_BC7_UNORM_BLOCK : VK_FORMAT_R8G8B8A8_UNORM);
            uploaded[k] = stage.renderer->device_scene->bytes_uploaded;
            stage_close(&stage);
        }
        const uint64_t texels = texture_offset(&plain, plain.mips, 0) / 4;
        struct texture blocks = plain;
        blocks.format = TEXTURE_BC7;
        assert_int_equal(uploaded[1] - uploaded[0], able ? 4 * texels - texture_offset(&blocks, blocks.mips, 0) : 0);
        assert_true(texture_face_bytes(&blocks, 0) * 4 == texture_face_bytes(&plain, 0));
        expect_near(&shots[0], &shots[1], 4, paths[i]);
        for (uint32_t k = 0; k < 2; k++) shot_free(&shots[k]);
        free(decoded.data);
        texture_free(&host, &plain);
        file_free(&host, &view);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_one_mip_is_as_pixels_MA_8, harness_check),
        cmocka_unit_test_teardown(test_mips_are_those_of_the_file_MA_8, harness_check),
        cmocka_unit_test_teardown(test_mips_come_in_parts_MA_8, harness_check),
        cmocka_unit_test_teardown(test_blocks_stay_compressed_MA_8, harness_check),
        cmocka_unit_test_teardown(test_basis_universal_is_BC7_MA_8, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
