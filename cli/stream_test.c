/* SPDX-License-Identifier: MIT */
#include "stream.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* The same in floating point, from the equations of BT.709-6, for every 5th value of each channel. */
static void test_conversion(void **state) {
    (void)state;
    for (int r = 0; r <= 255; r += 5)
        for (int g = 0; g <= 255; g += 5)
            for (int b = 0; b <= 255; b += 5) {
                const uint8_t pixel[4] = {(uint8_t)r, (uint8_t)g, (uint8_t)b, (uint8_t)(r ^ g)};
                uint8_t got[3];
                y4m_convert(pixel, 1, 1, Y4M_444, got);
                double y = (0.2126 * r + 0.7152 * g + 0.0722 * b) / 255;
                const double want[3] = {16 + 219 * y, 128 + 224 * (b / 255.0 - y) / 1.8556, 128 + 224 * (r / 255.0 - y) / 1.5748};
                for (int i = 0; i < 3; i++) assert_true(fabs(got[i] - want[i]) <= 0.5 + 1e-9);
            }
}

static void test_known_colours(void **state) {
    (void)state;
    static const uint8_t pixels[] = {0, 0, 0, 255, 255, 255, 255, 0, 255, 0, 0, 255, 0, 0, 255, 255, 128, 128, 128, 255};
    static const uint8_t want[] = {16, 235, 63, 32, 126, 128, 128, 102, 240, 128, 128, 128, 240, 118, 128};
    uint8_t planes[15];
    y4m_convert(pixels, 5, 1, Y4M_444, planes);
    assert_memory_equal(planes, want, sizeof want);
}

/* Each value of 4:2:0 against the mean of 4:4:4 in floating point; rows and columns that are told apart by their colors. */
static void test_chroma_of_squares(void **state) {
    (void)state;
    enum { WIDTH = 6, HEIGHT = 4, COUNT = WIDTH * HEIGHT };
    uint8_t pixels[4 * COUNT], planes[COUNT + COUNT / 2], whole[3 * COUNT];
    for (int i = 0; i < 4 * COUNT; i++) pixels[i] = (uint8_t)(i * 37 + i * i * 11);
    assert_int_equal(y4m_size(WIDTH, HEIGHT, Y4M_420), sizeof planes);
    assert_int_equal(y4m_size(WIDTH, HEIGHT, Y4M_444), sizeof whole);
    y4m_convert(pixels, WIDTH, HEIGHT, Y4M_420, planes);
    y4m_convert(pixels, WIDTH, HEIGHT, Y4M_444, whole);
    assert_memory_equal(planes, whole, COUNT);
    for (int y = 0; y < HEIGHT; y += 2)
        for (int x = 0; x < WIDTH; x += 2) {
            double mean[3] = {0};
            for (int k = 0; k < 4; k++)
                for (int c = 0; c < 3; c++) mean[c] += pixels[4 * ((y + k / 2) * WIDTH + x + k % 2) + c] / (4 * 255.0);
            const double luma = 0.2126 * mean[0] + 0.7152 * mean[1] + 0.0722 * mean[2];
            const int at = y / 2 * (WIDTH / 2) + x / 2;
            assert_true(fabs(planes[COUNT + at] - (128 + 224 * (mean[2] - luma) / 1.8556)) <= 0.5 + 1e-9);
            assert_true(fabs(planes[COUNT + COUNT / 4 + at] - (128 + 224 * (mean[0] - luma) / 1.5748)) <= 0.5 + 1e-9);
        }
}

static void test_headers(void **state) {
    (void)state;
    char text[128];
    y4m_header(text, sizeof text, 33, 17, Y4M_444, 1 / 30.0);
    assert_string_equal(text, "YUV4MPEG2 W33 H17 F30:1 Ip A1:1 C444 XCOLORRANGE=LIMITED\n");
    y4m_header(text, sizeof text, 32, 18, Y4M_420, 1 / 30.0);
    assert_string_equal(text, "YUV4MPEG2 W32 H18 F30:1 Ip A1:1 C420jpeg XCOLORRANGE=LIMITED\n");
    static const struct {
        double time;
        const char *rate;
    } rates[] = {{1001 / 30000.0, " F30000:1001 "}, {0.08, " F25:2 "}, {2, " F1:2 "}, {0, " F30:1 "}, {0.1, " F10:1 "}};
    for (size_t i = 0; i < sizeof rates / sizeof *rates; i++) {
        y4m_header(text, sizeof text, 2, 2, Y4M_420, rates[i].time);
        assert_non_null(strstr(text, rates[i].rate));
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_conversion), cmocka_unit_test(test_known_colours),
                                       cmocka_unit_test(test_chroma_of_squares),
                                       cmocka_unit_test(test_headers)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
