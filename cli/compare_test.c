/* SPDX-License-Identifier: MIT */
#include "command_capture.h"
#include "commands.h"

#include "base/base.h"
#include "base/file.h"
#include "fanal/image.h"

#include <jansson.h>
#include <math.h>

static char folder[64];
static int run(const char *line) {
    char words[512];
    snprintf(words, sizeof words, "compare %s", line);
    return capture(command_compare, words);
}

static void save(const char *name, uint32_t width, fnl_pixel_format format, int step) {
    uint8_t bytes[32 * 16 * 4];
    float floats[32 * 16 * 4];
    for (uint32_t i = 0; i < COUNT_OF(bytes); i++) {
        bytes[i] = (uint8_t)(i % 4 == 3 ? (strcmp(name, "clear.png") == 0 ? 100 : 255) : i % 200);
        floats[i] = (float)bytes[i] / 255;
    }
    bytes[(5 * 32 + 7) * 4 + 1] = (uint8_t)(bytes[(5 * 32 + 7) * 4 + 1] + step);
    if (strcmp(name, "infinite.exr") == 0) floats[77] = HUGE_VALF;
    fnl_image image = {width, 16, format, format == FNL_PIXEL_FORMAT_RGBA8 ? (void *)bytes : floats};
    assert_int_equal(fnl_image_save(NULL, name, &image), FNL_OK);
}

static int set_up(void **state) {
    UNUSED(state);
    snprintf(folder, sizeof folder, "/tmp/fanal-compare-test-XXXXXX");
    if (!mkdtemp(folder) || chdir(folder) != 0) return -1;
    save("a.png", 32, FNL_PIXEL_FORMAT_RGBA8, 0);
    save("b.png", 32, FNL_PIXEL_FORMAT_RGBA8, 3);
    save("narrow.png", 16, FNL_PIXEL_FORMAT_RGBA8, 0);
    save("a.exr", 32, FNL_PIXEL_FORMAT_RGBA32F, 0);
    save("clear.png", 32, FNL_PIXEL_FORMAT_RGBA8, 0);
    save("infinite.exr", 32, FNL_PIXEL_FORMAT_RGBA32F, 0);
    fnl_host host = host_resolve(NULL);
    return file_save(&host, "broken.png", "no picture", 10) == FNL_OK ? 0 : -1;
}

static int tear_down(void **state) {
    UNUSED(state);
    const char *names[] = {"a.png", "b.png", "narrow.png", "a.exr", "clear.png", "infinite.exr", "broken.png", "out", "err", "d.png"};
    for (uint32_t i = 0; i < COUNT_OF(names); i++) unlink(names[i]);
    return rmdir(folder); /* fails when anything else was left */
}

static void test_equal_and_different(void **state) {
    UNUSED(state);
    assert_int_equal(run("a.png a.png"), 0);
    assert_non_null(strstr(out, "max    0 "));
    assert_non_null(strstr(out, "psnr   inf dB"));
    assert_non_null(strstr(out, "ssim   1.000000000"));
    assert_int_equal(run("a.png b.png"), 0); /* no limits */
    assert_non_null(strstr(out, "(3.00/255) at 7, 5"));
    assert_non_null(strstr(out, "1 of 512 differ"));
    assert_null(strstr(out, "over"));
    assert_string_equal(err, "");
    assert_int_equal(run("a.png a.exr --max-diff 1e-7"), 0);
}

static void test_limits(void **state) {
    UNUSED(state);
    assert_int_equal(run("a.png b.png --max-diff 3/255"), 0);
    assert_int_equal(run("a.png b.png --max-diff 2/255"), 1);
    assert_non_null(strstr(out, "over   max"));
    assert_null(strstr(out, "over   mean"));
    assert_int_equal(run("a.png b.png --mean-diff=0.00001"), 0);
    assert_int_equal(run("a.png b.png --mean-diff 0.000001"), 1);
    assert_non_null(strstr(out, "over   mean"));
    assert_int_equal(run("--psnr 60 a.png b.png"), 0);
    assert_int_equal(run("a.png b.png --psnr 90"), 1);
    assert_non_null(strstr(out, "--psnr is 90"));
    assert_int_equal(run("a.png b.png --ssim 0.9"), 0);
    assert_int_equal(run("a.png b.png --ssim 1"), 1);
    assert_int_equal(run("a.png a.png --ssim 1 --psnr inf --max-diff 0 --mean-diff 0"), 0);
}

static void test_json(void **state) {
    UNUSED(state);
    assert_int_equal(run("a.png b.png --json --max-diff 2/255 --ssim 0"), 1);
    json_t *root = json_loads(out, 0, NULL);
    assert_non_null(root);
    const char *first, *over;
    double greatest, psnr;
    int x, y, differing;
    assert_int_equal(json_unpack(root, "{s:[s], s:F, s:[ii], s:F, s:i, s:[s!]}", "files", &first, "max", &greatest, "max_at",
                                 &x, &y, "psnr", &psnr, "differing_pixels", &differing, "over", &over),
                     0);
    assert_string_equal(first, "a.png");
    assert_string_equal(over, "max-diff");
    assert_true(greatest > 0.0117 && greatest < 0.0118 && x == 7 && y == 5 && psnr > 60 && differing == 1);
    json_decref(root);
    assert_int_equal(run("a.png a.png --json"), 0);
    root = json_loads(out, 0, NULL);
    assert_string_equal(json_string_value(json_object_get(root, "psnr")), "Infinity");
    assert_true(json_is_false(json_object_get(root, "alpha_differs")));
    assert_int_equal(json_array_size(json_object_get(root, "over")), 0);
    json_decref(root);
    assert_int_equal(run("a.exr infinite.exr --json"), 0);
    root = json_loads(out, 0, NULL);
    assert_string_equal(json_string_value(json_object_get(root, "psnr")), "-Infinity");
    assert_string_equal(json_string_value(json_object_get(root, "max")), "Infinity");
    json_decref(root);
}

/* Where only alpha differs, SSIM and FLIP are those of equal pictures, and the report says why. */
static void test_alpha_that_does_not_count(void **state) {
    UNUSED(state);
    assert_int_equal(run("a.png clear.png"), 0);
    assert_non_null(strstr(out, "ssim   1.000000000"));
    assert_non_null(strstr(out, "note   alpha differs; ssim and flip do not count it"));
    assert_int_equal(run("a.exr clear.png"), 0);
    assert_non_null(strstr(out, "note   alpha differs; ssim does not count it"));
    assert_int_equal(run("a.png b.png"), 0);
    assert_null(strstr(out, "note"));
    assert_int_equal(run("clear.png a.png --json"), 0);
    json_t *root = json_loads(out, 0, NULL);
    assert_true(json_is_true(json_object_get(root, "alpha_differs")));
    json_decref(root);
}

static void save_grey(const char *name, float left, float right) {
    float pixels[8 * 2 * 4];
    for (uint32_t i = 0; i < COUNT_OF(pixels); i++) pixels[i] = i % 4 == 3 ? 1 : i / 4 % 8 < 4 ? left : right;
    fnl_image image = {8, 2, FNL_PIXEL_FORMAT_RGBA32F, pixels};
    assert_int_equal(fnl_image_save(NULL, name, &image), FNL_OK);
}

static void test_leak_and_flip(void **state) {
    UNUSED(state);
    save_grey("lit.exr", 6, 2);
    save_grey("rays.exr", 6, 0);
    save_grey("maps.exr", 5.25f, 0.25f);
    assert_int_equal(run("maps.exr rays.exr --lit lit.exr --leak 0.125"), 0);
    assert_non_null(strstr(out, "leak   0.125\n")); /* (0.75 + 0.25) / (6 + 2) */
    assert_null(strstr(out, "flip"));
    assert_int_equal(run("maps.exr rays.exr --lit lit.exr --leak 0.124"), 1);
    assert_non_null(strstr(out, "over   leak"));
    assert_int_equal(run("rays.exr rays.exr --lit lit.exr --leak 0 --json"), 0);
    assert_non_null(strstr(out, "\"leak\": 0.0"));
    assert_int_equal(run("a.png b.png --flip 0.1"), 0);
    assert_non_null(strstr(out, "flip   0.00"));
    assert_int_equal(run("a.png b.png --flip 0.00001 --json"), 1);
    assert_non_null(strstr(out, "\"flip\": 0.00"));
    assert_int_equal(run("a.png a.png --flip 0"), 0);
    static const char *const names[] = {"lit.exr", "rays.exr", "maps.exr"};
    for (uint32_t i = 0; i < COUNT_OF(names); i++) unlink(names[i]);
}

static void test_difference_picture(void **state) {
    UNUSED(state);
    assert_int_equal(run("a.png b.png -o d.png --max-diff 0"), 1); /* written for a failure above all */
    fnl_image picture;
    assert_int_equal(fnl_image_load(NULL, "d.png", &picture), FNL_OK);
    for (uint32_t i = 0; i < 32 * 16; i++)
        assert_int_equal(((uint8_t *)picture.pixels)[i * 4 + 1], i == 5 * 32 + 7 ? 255 : 0);
    fnl_image_free(NULL, &picture);
    assert_int_equal(run("a.png b.png -o none/d.png"), 2);
    assert_non_null(strstr(err, "none/d.png"));
}

static void test_errors_name_what_is_wrong(void **state) {
    UNUSED(state);
    static const char *const cases[][2] = {
        {"a.png missing.png", "missing.png"},          {"broken.png a.png", "broken.png"},
        {"a.png narrow.png", "narrow.png is 16 x 16"}, {"a.png", "two pictures"},
        {"a.png a.png a.png", "two pictures"},         {"a.png b.png --max-diff much", "--max-diff: 'much'"},
        {"a.png b.png --max-diff 2/", "'2/'"},         {"a.png b.png --max-diff 2/0", "'2/0'"},
        {"a.png b.png --psnr nan", "'nan'"},           {"a.png b.png --max-diff", "max-diff"},
        {"a.png a.png --lit narrow.png", "narrow.png is 16 x 16"}, {"a.png b.png --lit a.png", "a.png holds none"},
        {"a.png b.png --leak 1", "--leak needs --lit"}, {"a.exr a.exr --flip 1", "a.exr holds linear light"},
        {"a.png b.png --max-memory much", "--max-memory: 'much'"},
        {"a.png b.png --max-memory 2047", "a.png: the picture of 32 x 16 pixels needs 2048 bytes of memory, over the limit of 2047"},
        {"a.png b.png --max-memory 4095", "b.png: the picture of 32 x 16 pixels needs 2048 bytes of memory, over the limit of 2047"},
        {"a.exr a.exr --max-memory 8K", "a.exr: the picture of 32 x 16 pixels needs 8192 bytes of memory, over the limit of 0"},
        {"a.png b.png --frobnicate", "frobnicate"},    {"a.png b.png -o d.jpg", "d.jpg"},
    };
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        assert_int_equal(run(cases[i][0]), 2);
        if (!strstr(err, cases[i][1])) fail_msg("'%s' is not in '%s'", cases[i][1], err);
        assert_string_equal(out, "");
    }
    assert_int_equal(run("a.png a.png --max-memory 4K"), 0);
    assert_int_equal(run("a.exr a.exr --max-memory 16K"), 0);
    assert_int_equal(run("--help"), 0);
    assert_non_null(strstr(out, "Examples:"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_equal_and_different),
        cmocka_unit_test(test_limits),
        cmocka_unit_test(test_json),
        cmocka_unit_test(test_alpha_that_does_not_count),
        cmocka_unit_test(test_leak_and_flip),
        cmocka_unit_test(test_difference_picture),
        cmocka_unit_test(test_errors_name_what_is_wrong),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
