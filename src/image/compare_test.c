/* SPDX-License-Identifier: MIT */
#include "base/base.h"
#include "fanal/image.h"

#include <math.h>
#include <setjmp.h>

#include <cmocka.h>

static fnl_image noise(uint32_t width, uint32_t height, fnl_pixel_format format, uint64_t seed, double amount) {
    fnl_image image = {width, height, format, malloc((size_t)width * height * fnl_pixel_size(format))};
    assert_non_null(image.pixels);
    struct random_state shared = {99}, own = {seed};
    for (size_t i = 0; i < (size_t)width * height * 4; i++) {
        double value = fmin(1, fmax(0, (double)random_float(&shared) + amount * ((double)random_float(&own) - 0.5)));
        if (format == FNL_PIXEL_FORMAT_RGBA8) ((uint8_t *)image.pixels)[i] = (uint8_t)(value * 255 + 0.5);
        if (format == FNL_PIXEL_FORMAT_RGBA16) ((uint16_t *)image.pixels)[i] = (uint16_t)(value * 65535 + 0.5);
        if (format == FNL_PIXEL_FORMAT_RGBA32F) ((float *)image.pixels)[i] = (float)value * 3;
    }
    return image;
}

static double at(const fnl_image *image, uint32_t x, uint32_t y, uint32_t c) {
    size_t i = ((size_t)y * image->width + x) * 4 + c;
    switch (image->format) {
    case FNL_PIXEL_FORMAT_RGBA8:
        return ((const uint8_t *)image->pixels)[i] / 255.0;
    case FNL_PIXEL_FORMAT_RGBA16:
        return ((const uint16_t *)image->pixels)[i] / 65535.0;
    case FNL_PIXEL_FORMAT_RGBA32F:
        return (double)((const float *)image->pixels)[i];
    }
    return NAN;
}

static double luma(const fnl_image *image, uint32_t x, uint32_t y) {
    return 0.2126 * at(image, x, y, 0) + 0.7152 * at(image, x, y, 1) + 0.0722 * at(image, x, y, 2);
}

/* The formula of the paper, window by window: variances and covariance about the means, not by moments. */
static double slow_window(const fnl_image *a, const fnl_image *b, int cx, int cy, double peak) {
    double sum = 0, mean_a = 0, mean_b = 0, variance_a = 0, variance_b = 0, covariance = 0;
    for (int pass = 0; pass < 2; pass++)
        for (int y = MAX(cy - 5, 0); y <= MIN(cy + 5, (int)a->height - 1); y++)
            for (int x = MAX(cx - 5, 0); x <= MIN(cx + 5, (int)a->width - 1); x++) {
                double weight = exp(-((x - cx) * (x - cx) + (y - cy) * (y - cy)) / 4.5);
                double va = luma(a, (uint32_t)x, (uint32_t)y), vb = luma(b, (uint32_t)x, (uint32_t)y);
                if (pass == 0) {
                    sum += weight;
                    mean_a += weight * va;
                    mean_b += weight * vb;
                    continue;
                }
                variance_a += weight / sum * (va - mean_a / sum) * (va - mean_a / sum);
                variance_b += weight / sum * (vb - mean_b / sum) * (vb - mean_b / sum);
                covariance += weight / sum * (va - mean_a / sum) * (vb - mean_b / sum);
            }
    mean_a /= sum;
    mean_b /= sum;
    double c1 = 1e-4 * peak * peak, c2 = 9e-4 * peak * peak;
    return (2 * mean_a * mean_b + c1) * (2 * covariance + c2) /
           ((mean_a * mean_a + mean_b * mean_b + c1) * (variance_a + variance_b + c2));
}

static double slow_ssim(const fnl_image *a, const fnl_image *b, double peak) {
    double sum = 0;
    uint64_t count = 0;
    for (int y = 0; y < (int)a->height; y++)
        for (int x = 0; x < (int)a->width; x++) {
            if (a->width >= 11 && (x < 5 || x >= (int)a->width - 5)) continue;
            if (a->height >= 11 && (y < 5 || y >= (int)a->height - 5)) continue;
            sum += slow_window(a, b, x, y, peak);
            count++;
        }
    return sum / (double)count;
}

static void expect_near(double value, double expected, double tolerance) {
    if (!(fabs(value - expected) <= tolerance)) fail_msg("%.17g is not %.17g", value, expected);
}

static void test_metrics_are_the_slow_formulas(void **state) {
    UNUSED(state);
    static const uint32_t sizes[][2] = {{1, 1}, {3, 5}, {10, 30}, {30, 10}, {11, 11}, {12, 27}, {67, 41}};
    for (uint32_t s = 0; s < COUNT_OF(sizes); s++)
        for (int format_a = 0; format_a < 3; format_a++)
            for (int format_b = 0; format_b < 3; format_b++) {
                fnl_image a = noise(sizes[s][0], sizes[s][1], (fnl_pixel_format)format_a, 1, 0);
                fnl_image b = noise(sizes[s][0], sizes[s][1], (fnl_pixel_format)format_b, 2, 0.3);
                double greatest = 0, sum = 0, squares = 0, peak = 1;
                uint32_t greatest_x = 0, greatest_y = 0;
                uint64_t differing = 0;
                for (uint32_t y = 0; y < a.height; y++)
                    for (uint32_t x = 0; x < a.width; x++) {
                        bool differs = false;
                        for (uint32_t c = 0; c < 4; c++) {
                            double d = fabs(at(&a, x, y, c) - at(&b, x, y, c));
                            peak = fmax(peak, fmax(at(&a, x, y, c), at(&b, x, y, c)));
                            sum += d;
                            squares += d * d;
                            differs |= d > 0;
                            if (d > greatest + 1e-12) {
                                greatest = d;
                                greatest_x = x;
                                greatest_y = y;
                            }
                        }
                        differing += differs;
                    }
                double samples = (double)a.width * a.height * 4, rmse = sqrt(squares / samples);
                fnl_image_difference d;
                assert_int_equal(fnl_image_compare(NULL, &a, &b, &d), FNL_OK);
                expect_near(d.max, greatest, 1e-12);
                expect_near(d.mean, sum / samples, 1e-12);
                expect_near(d.rmse, rmse, 1e-12);
                expect_near(d.psnr, 20 * log10(peak / rmse), 1e-9);
                expect_near(d.ssim, slow_ssim(&a, &b, peak), 1e-9);
                assert_int_equal(d.max_x, greatest_x);
                assert_int_equal(d.max_y, greatest_y);
                assert_int_equal(d.differing_pixels, differing);
                free(a.pixels);
                free(b.pixels);
            }
}

static void test_equal_pictures(void **state) {
    UNUSED(state);
    for (int format = 0; format < 3; format++) {
        fnl_image a = noise(33, 17, (fnl_pixel_format)format, 1, 0.1), b = noise(33, 17, (fnl_pixel_format)format, 1, 0.1);
        fnl_image_difference d;
        assert_int_equal(fnl_image_compare(NULL, &a, &b, &d), FNL_OK);
        assert_true(d.max == 0 && d.mean == 0 && d.rmse == 0 && isinf(d.psnr) && d.psnr > 0 && d.ssim == 1);
        assert_int_equal(d.differing_pixels, 0);
        free(a.pixels);
        free(b.pixels);
    }
}

/* A picture against its inverse about the middle: the structure is turned over, so that SSIM falls below zero. */
static void test_inverted_picture_has_negative_ssim(void **state) {
    UNUSED(state);
    fnl_image a = noise(32, 32, FNL_PIXEL_FORMAT_RGBA8, 1, 0), b = noise(32, 32, FNL_PIXEL_FORMAT_RGBA8, 1, 0);
    for (size_t i = 0; i < 32 * 32 * 4; i++) ((uint8_t *)b.pixels)[i] = (uint8_t)(255 - ((uint8_t *)a.pixels)[i]);
    fnl_image_difference d;
    assert_int_equal(fnl_image_compare(NULL, &a, &b, &d), FNL_OK);
    assert_true(d.ssim < -0.8);
    free(a.pixels);
    free(b.pixels);
}

/* A limit of N/255 must hold for a difference of N, at every level and across 8 and 16 bits. */
static void test_integer_differences_are_exact(void **state) {
    UNUSED(state);
    for (uint32_t low = 0; low < 253; low++) {
        uint8_t a8[4] = {(uint8_t)low, 0, 0, 255}, b8[4] = {(uint8_t)(low + 2), 0, 0, 255};
        uint16_t b16[4] = {(uint16_t)(b8[0] * 257), 0, 0, 65535};
        fnl_image a = {1, 1, FNL_PIXEL_FORMAT_RGBA8, a8}, b = {1, 1, FNL_PIXEL_FORMAT_RGBA8, b8};
        fnl_image c = {1, 1, FNL_PIXEL_FORMAT_RGBA16, b16};
        fnl_image_difference d;
        assert_int_equal(fnl_image_compare(NULL, &a, &b, &d), FNL_OK);
        assert_true(d.max == 2 / 255.0);
        assert_int_equal(fnl_image_compare(NULL, &a, &c, &d), FNL_OK);
        assert_true(d.max == 2 / 255.0);
        assert_int_equal(fnl_image_compare(NULL, &b, &c, &d), FNL_OK);
        assert_true(d.max == 0);
    }
}

static void test_what_is_not_finite(void **state) {
    UNUSED(state);
    enum { WIDTH = 40, HEIGHT = 30 };
    fnl_image a = noise(WIDTH, HEIGHT, FNL_PIXEL_FORMAT_RGBA32F, 1, 0),
              b = noise(WIDTH, HEIGHT, FNL_PIXEL_FORMAT_RGBA32F, 1, 0);
    float *pa = a.pixels, *pb = b.pixels;
    size_t middle = (15 * WIDTH + 20) * 4;
    fnl_image_difference d;

    pa[middle] = pb[middle] = NAN;
    pa[middle + 5] = pb[middle + 5] = INFINITY;
    pa[middle + 9] = pb[middle + 9] = -INFINITY;
    assert_int_equal(fnl_image_compare(NULL, &a, &b, &d), FNL_OK);
    assert_true(d.max == 0 && isinf(d.psnr) && d.psnr > 0 && d.ssim == 1 && d.differing_pixels == 0);

    /* One-sided: infinite. Exactly the 11 x 11 windows that hold the pixel count as 0. */
    float one_sided[][2] = {{NAN, 1}, {INFINITY, 1}, {INFINITY, -INFINITY}, {NAN, INFINITY}};
    for (uint32_t i = 0; i < COUNT_OF(one_sided); i++) {
        pa[middle] = one_sided[i][0];
        pb[middle] = one_sided[i][1];
        assert_int_equal(fnl_image_compare(NULL, &a, &b, &d), FNL_OK);
        assert_true(isinf(d.max) && isinf(d.mean) && isinf(d.rmse) && d.psnr < 0 && isinf(d.psnr));
        assert_int_equal(d.max_x, 20);
        assert_int_equal(d.max_y, 15);
        assert_int_equal(d.differing_pixels, 1);
        expect_near(d.ssim, 1 - 121.0 / ((WIDTH - 10) * (HEIGHT - 10)), 1e-12);
        fnl_image picture;
        assert_int_equal(fnl_image_difference_picture(NULL, &a, &b, 0, &picture), FNL_OK);
        assert_int_equal(((uint8_t *)picture.pixels)[middle], 255);
        assert_int_equal(((uint8_t *)picture.pixels)[middle + 1], 0);
        fnl_image_free(NULL, &picture);
    }
    free(a.pixels);
    free(b.pixels);
}

static void test_difference_picture(void **state) {
    UNUSED(state);
    uint8_t a8[] = {10, 20, 30, 255, 0, 0, 0, 255, 9, 9, 9, 100}, b8[] = {10, 30, 10, 255, 40, 0, 0, 255, 9, 9, 9, 110};
    fnl_image a = {3, 1, FNL_PIXEL_FORMAT_RGBA8, a8}, b = {3, 1, FNL_PIXEL_FORMAT_RGBA8, b8}, picture;
    assert_int_equal(fnl_image_difference_picture(NULL, &a, &b, 2, &picture), FNL_OK);
    const uint8_t twice[] = {0, 20, 40, 255, 80, 0, 0, 255, 20, 20, 20, 255};
    assert_memory_equal(picture.pixels, twice, sizeof twice);
    fnl_image_free(NULL, &picture);
    assert_int_equal(fnl_image_difference_picture(NULL, &a, &b, 0, &picture), FNL_OK);
    const uint8_t stretched[] = {0, 64, 128, 255, 255, 0, 0, 255, 64, 64, 64, 255};
    assert_memory_equal(picture.pixels, stretched, sizeof stretched);
    fnl_image_free(NULL, &picture);
    assert_int_equal(fnl_image_difference_picture(NULL, &a, &b, 100, &picture), FNL_OK);
    assert_int_equal(((uint8_t *)picture.pixels)[1], 255);
    fnl_image_free(NULL, &picture);
}

static void say_nothing(void *user, fnl_log_level level, const char *line) {
    UNUSED(level);
    snprintf(user, 200, "%s", line);
}

static void test_misuse_is_refused(void **state) {
    UNUSED(state);
    char line[200] = "";
    fnl_host host = {.user = line, .log = say_nothing};
    uint8_t pixels[16] = {0};
    fnl_image a = {2, 2, FNL_PIXEL_FORMAT_RGBA8, pixels}, b = {4, 1, FNL_PIXEL_FORMAT_RGBA8, pixels}, none = {0}, picture;
    fnl_image_difference d;
    assert_int_equal(fnl_image_compare(&host, &a, &b, &d), FNL_ERROR_INVALID);
    assert_non_null(strstr(line, "2 x 2 and 4 x 1"));
    assert_int_equal(fnl_image_compare(&host, &a, &none, &d), FNL_ERROR_INVALID);
    assert_int_equal(fnl_image_compare(&host, &a, &a, NULL), FNL_ERROR_INVALID);
    assert_int_equal(fnl_image_difference_picture(&host, &a, &b, 1, &picture), FNL_ERROR_INVALID);
    assert_int_equal(fnl_image_difference_picture(&host, &a, &a, -1, &picture), FNL_ERROR_INVALID);
    assert_null(picture.pixels);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_metrics_are_the_slow_formulas),
        cmocka_unit_test(test_equal_pictures),
        cmocka_unit_test(test_inverted_picture_has_negative_ssim),
        cmocka_unit_test(test_integer_differences_are_exact),
        cmocka_unit_test(test_what_is_not_finite),
        cmocka_unit_test(test_difference_picture),
        cmocka_unit_test(test_misuse_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
