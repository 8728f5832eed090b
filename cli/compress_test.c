/* SPDX-License-Identifier: MIT */
#include "command_capture.h"
#include "commands.h"

#include "base/base.h"
#include "fanal/image.h"

static char folder[64];
static int run(const char *line) {
    char words[512];
    snprintf(words, sizeof words, "compress %s", line);
    return capture(command_compress, words);
}

/* Red grows to the right, green downwards. */
static int set_up(void **state) {
    UNUSED(state);
    float pixels[16 * 8 * 4];
    for (uint32_t i = 0; i < 16 * 8; i++) {
        const float texel[4] = {1 + (float)(i % 16), 1 + (float)(i / 16), 0.5f, 1};
        memcpy(pixels + 4 * i, texel, sizeof texel);
    }
    fnl_image image = {16, 8, FNL_PIXEL_FORMAT_RGBA32F, pixels};
    snprintf(folder, sizeof folder, "/tmp/fanal-compress-test-XXXXXX");
    if (!mkdtemp(folder) || chdir(folder) != 0) return -1;
    return fnl_image_save(NULL, "a.exr", &image) == FNL_OK ? 0 : -1;
}

static int tear_down(void **state) {
    UNUSED(state);
    const char *names[] = {"a.exr", "b.exr", "a.dds", "a.ktx2", "out", "err"};
    for (uint32_t i = 0; i < COUNT_OF(names); i++) unlink(names[i]);
    return rmdir(folder); /* fails when anything else was left */
}

static void test_there_and_back(void **state) {
    UNUSED(state);
    static const char *const names[] = {"a.dds", "a.ktx2"};
    for (uint32_t i = 0; i < COUNT_OF(names); i++) {
        char line[64];
        snprintf(line, sizeof line, "a.exr -o %s", names[i]);
        assert_int_equal(run(line), 0);
        assert_non_null(strstr(out, "size   16 x 8, 1 face, 1 mip\n"));
        assert_non_null(strstr(out, "\nrmse   0."));
        assert_non_null(strstr(out, " ms on the CPU)\n"));
        assert_string_equal(err, "");
        snprintf(line, sizeof line, "%s -o b.exr", names[i]);
        assert_int_equal(run(line), 0);
        fnl_image read;
        assert_int_equal(fnl_image_load(NULL, "b.exr", &read), FNL_OK);
        assert_true(read.width == 16 && read.height == 8);
        for (uint32_t k = 0; k < 16 * 8; k++) {
            const float *texel = (const float *)read.pixels + 4 * k, expected[3] = {1 + (float)(k % 16), 1 + (float)(k / 16), 0.5f};
            for (int c = 0; c < 3; c++) assert_float_equal(texel[c], expected[c], 1.75f); /* red and green make a plane, not a line */
        }
        fnl_image_free(NULL, &read);
    }
}

static void test_options(void **state) {
    UNUSED(state);
    assert_int_equal(run("a.exr --cube 8 --mips --quality fast -o a.dds"), 0);
    assert_non_null(strstr(out, "size   8 x 8, 6 faces, 4 mips\n"));
    assert_non_null(strstr(out, "modes  11: 42  (blocks)\n")); /* 6 (4 + 1 + 1 + 1) */
    assert_int_equal(run("a.exr --signed --quality best -o a.dds"), 0);
    assert_int_equal(run("a.exr --quality fast --max-memory 2K -o a.dds"), 0);
    assert_int_equal(run("--help"), 0);
    assert_non_null(strstr(out, "Examples:"));
}

static void test_errors_name_what_is_wrong(void **state) {
    UNUSED(state);
    static const char *const cases[][2] = {
        {"a.exr", "-o FILE"},
        {"-o a.dds", "one picture"},
        {"missing.exr -o a.dds", "missing.exr"},
        {"a.exr -o a.png", "a.png: a picture is compressed to"},
        {"a.exr -o b.exr", "b.exr: a picture is compressed to"},
        {"a.exr -o none/a.dds", "none/a.dds"},
        {"a.exr --quality good -o a.dds", "--quality: 'good' is none of: fast, quality, best"},
        {"a.exr --on tpu -o a.dds", "--on: 'tpu'"},
        {"a.exr --cube 0 -o a.dds", "--cube: '0' is not a whole number from 1 to 4096"},
        {"a.exr --cube 4097 -o a.dds", "'4097'"},
        {"a.exr --cube 8x -o a.dds", "'8x'"},
        {"a.exr --device 0 -o a.dds", "--device goes with --on gpu"},
        {"a.exr --on gpu --quality best -o a.dds", "for --on cpu alone"},
        {"a.exr --max-memory 1K -o a.dds", "a.exr: the picture of 16 x 8 pixels needs 2048 bytes of memory, over the limit of 1024"},
        {"a.exr --max-memory x -o a.dds", "--max-memory: 'x'"},
        {"a.exr --frobnicate", "frobnicate"},
    };
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        assert_int_equal(run(cases[i][0]), 2);
        if (!strstr(err, cases[i][1])) fail_msg("'%s' is not in '%s'", cases[i][1], err);
        assert_string_equal(out, "");
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_there_and_back),
        cmocka_unit_test(test_options),
        cmocka_unit_test(test_errors_name_what_is_wrong),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
