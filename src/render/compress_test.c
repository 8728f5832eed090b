/* SPDX-License-Identifier: MIT */
/** fnl_image_compress: the same file from the CPU and the device, what its numbers mean, and what it refuses. */
#include "base/file.h"
#include "image/bc6h.h"
#include "image/image.h"
#include "image/texture.h"
#include "tests/render_harness.h"

#include <unistd.h>

enum { WIDTH = 22, HEIGHT = 11 };

static char folder[] = "/tmp/fanal-compress-XXXXXX";
static const char *path_of(const char *name) {
    static char path[128];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static float pixels[WIDTH * HEIGHT * 4];
static const fnl_image picture = {WIDTH, HEIGHT, FNL_PIXEL_FORMAT_RGBA32F, pixels};

static int begin(void **state) {
    struct random_state random = {4};
    for (uint32_t i = 0; i < COUNT_OF(pixels); i++) pixels[i] = random_range(&random, -1, 8) * (float)(1 + i / 4 % WIDTH);
    return mkdtemp(folder) ? harness_begin(state) : -1;
}

static int end(void **state) { return rmdir(folder) == 0 ? harness_end(state) : -1; }

static struct file_view compress(const fnl_compress_params *params, fnl_compress_stats *stats) {
    const fnl_host host = host_resolve(NULL);
    struct file_view view;
    assert_int_equal(fnl_image_compress(NULL, path_of("a.ktx2"), &picture, params, stats), FNL_OK);
    assert_int_equal(file_load(&host, path_of("a.ktx2"), &view), FNL_OK);
    unlink(path_of("a.ktx2"));
    return view;
}

static void test_device_and_CPU_write_the_same_file_BC_2(void **state) {
    UNUSED(state);
    const fnl_host host = host_resolve(NULL);
    for (uint32_t i = 0; i < 4; i++) {
        fnl_compress_params params = fnl_compress_params_default();
        fnl_compress_stats of_cpu, of_device;
        params.quality = i & 1 ? FNL_COMPRESS_QUALITY : FNL_COMPRESS_FAST;
        params.is_signed = i & 2;
        params.mips = true;
        params.cube_size = i == 1 || i == 2 ? 10 : 0;
        struct file_view cpu = compress(&params, &of_cpu);
        params.device = harness_device();
        struct file_view device = compress(&params, &of_device);
        assert_int_equal(cpu.size, device.size);
        assert_memory_equal(cpu.data, device.data, cpu.size);
        of_device.seconds = of_cpu.seconds;
        assert_memory_equal(&of_cpu, &of_device, sizeof of_cpu);
        assert_int_equal(of_cpu.faces, params.cube_size ? 6 : 1);
        assert_int_equal(of_cpu.mips, params.cube_size ? 4 : 5); /* 10 5 2 1; 22 11 5 2 1 */
        assert_int_equal(of_cpu.pixels, params.cube_size ? 6 * (100 + 25 + 4 + 1) : 22 * 11 + 11 * 5 + 5 * 2 + 2 * 1 + 1);
        uint64_t blocks = 0;
        for (uint32_t mode = 1; mode <= 14; mode++) blocks += of_cpu.blocks[mode];
        assert_int_equal(blocks, params.cube_size ? 6 * (9 + 4 + 1 + 1) : 18 + 6 + 2 + 1 + 1);
        file_free(&host, &cpu);
        file_free(&host, &device);
    }
}

/* The numbers of the greatest mip are those of the picture that the file gives. */
static void test_numbers_are_those_of_the_file(void **state) {
    UNUSED(state);
    fnl_compress_params params = fnl_compress_params_default();
    fnl_compress_stats stats;
    fnl_image read;
    params.is_signed = true;
    assert_int_equal(fnl_image_compress(NULL, path_of("a.dds"), &picture, &params, &stats), FNL_OK);
    assert_int_equal(fnl_image_load(NULL, path_of("a.dds"), &read), FNL_OK);
    unlink(path_of("a.dds"));
    assert_true(read.width == WIDTH && read.height == HEIGHT && read.format == FNL_PIXEL_FORMAT_RGBA32F);
    double sum = 0;
    for (uint32_t i = 0; i < COUNT_OF(pixels); i++)
        if (i % 4 < 3) sum += pow((double)((const float *)read.pixels)[i] - (double)pixels[i], 2);
    assert_float_equal((float)(sqrt(sum / (WIDTH * HEIGHT * 3)) / stats.rmse), 1, 1e-4f);
    fnl_image_free(NULL, &read);
}

/* Integers are sRGB, and mips are means of linear light. */
static void test_integers_are_sRGB_and_mips_are_means(void **state) {
    UNUSED(state);
    uint8_t bytes[8 * 8 * 4];
    for (uint32_t i = 0; i < COUNT_OF(bytes); i++) bytes[i] = i / 4 % 2 ? 188 : 0; /* 188: 0.503 */
    const fnl_image grey = {8, 8, FNL_PIXEL_FORMAT_RGBA8, bytes};
    fnl_compress_params params = fnl_compress_params_default();
    fnl_image read;
    params.mips = true;
    assert_int_equal(fnl_image_compress(NULL, path_of("a.dds"), &grey, &params, NULL), FNL_OK);
    assert_int_equal(fnl_image_load(NULL, path_of("a.dds"), &read), FNL_OK);
    assert_float_equal(((const float *)read.pixels)[0], 0, 0.001f);
    assert_float_equal(((const float *)read.pixels)[4], 0.503f, 0.003f);
    fnl_image_free(NULL, &read);
    const fnl_host host = host_resolve(NULL);
    struct texture texture;
    assert_int_equal(texture_load(&host, path_of("a.dds"), &texture), FNL_OK);
    float half[4 * 4 * 4];
    bc6h_decode_picture(texture.bytes + texture_offset(&texture, 1, 0), false, 4, 4, half);
    for (uint32_t i = 0; i < COUNT_OF(half); i++) assert_float_equal(half[i], (i % 4 == 3 ? 1 : 0.2515f), 0.002f);
    texture_free(&host, &texture);
    unlink(path_of("a.dds"));
}

static char last_line[1024];
static void keep_line(void *user, fnl_log_level level, const char *line) {
    UNUSED(user);
    UNUSED(level);
    snprintf(last_line, sizeof last_line, "%s", line);
}

static void test_refusals_say_why(void **state) {
    UNUSED(state);
    const fnl_host host = {.log = keep_line};
    const struct {
        const char *path, *said;
        fnl_compress_params params;
        fnl_result result;
    } cases[] = {
        {"a.png", "not as '.png'", {.quality = FNL_COMPRESS_FAST}, FNL_ERROR_UNSUPPORTED},
        {"a.dds", "for the CPU alone", {.quality = FNL_COMPRESS_BEST, .device = harness_device()}, FNL_ERROR_INVALID},
        {"a.dds", "params.cube_size", {.cube_size = 4097}, FNL_ERROR_INVALID},
        {"a.dds", "params.quality", {.quality = (fnl_compress_quality)3}, FNL_ERROR_INVALID},
    };
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        assert_int_equal(fnl_image_compress(&host, path_of(cases[i].path), &picture, &cases[i].params, NULL), cases[i].result);
        if (!strstr(last_line, cases[i].said)) fail_msg("'%s' is not in '%s'", cases[i].said, last_line);
    }
    const fnl_image high = {10, 6, FNL_PIXEL_FORMAT_RGBA32F, pixels};
    assert_int_equal(fnl_image_compress(&host, NULL, &high, &(fnl_compress_params){.cube_size = 8}, NULL), FNL_ERROR_INVALID);
    assert_non_null(strstr(last_line, "10x6 pixels"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_device_and_CPU_write_the_same_file_BC_2, harness_check),
        cmocka_unit_test_teardown(test_numbers_are_those_of_the_file, harness_check),
        cmocka_unit_test_teardown(test_integers_are_sRGB_and_mips_are_means, harness_check),
        cmocka_unit_test_teardown(test_refusals_say_why, harness_check),
    };
    return cmocka_run_group_tests(tests, begin, end);
}
