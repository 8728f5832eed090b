/* SPDX-License-Identifier: MIT */
#include "flip.h"

#include "base/base.h"

#include <math.h>
#include <setjmp.h>

#include <cmocka.h>

enum { WIDTH = 17, HEIGHT = 13, COUNT = WIDTH * HEIGHT };
static uint8_t first[COUNT * 4], second[COUNT * 4];
static const fnl_image a = {WIDTH, HEIGHT, FNL_PIXEL_FORMAT_RGBA8, first},
                       b = {WIDTH, HEIGHT, FNL_PIXEL_FORMAT_RGBA8, second};

static void fill(uint8_t *pixels, uint8_t red, uint8_t green, uint8_t blue) {
    for (int i = 0; i < COUNT; i++) {
        pixels[i * 4] = red;
        pixels[i * 4 + 1] = green;
        pixels[i * 4 + 2] = blue;
        pixels[i * 4 + 3] = 255;
    }
}

static double flip(double pixels_per_degree) { return flip_compare(&a, &b, pixels_per_degree, NULL); }

static double linear(uint8_t byte) {
    double x = byte / 255.0;
    return x <= 0.04045 ? x / 12.92 : pow((x + 0.055) / 1.055, 2.4);
}

static double root(double t) { return t > 216.0 / 24389 ? cbrt(t) : (24389.0 / 27 * t + 16) / 116; }

static void test_plain_colours(void **state) {
    UNUSED(state);
    fill(first, 12, 200, 70);
    fill(second, 12, 200, 70);
    assert_true(flip(FLIP_PIXELS_PER_DEGREE) == 0);
    second[3] = 0; /* alpha does not count */
    assert_true(flip(FLIP_PIXELS_PER_DEGREE) == 0);
    fill(first, 0, 255, 0); /* nothing that a screen shows is farther apart */
    fill(second, 0, 0, 255);
    assert_float_equal(flip(FLIP_PIXELS_PER_DEGREE), 1, 1e-4);
    /* Black and white are 100 apart; green and blue are in CIELAB (87.735, -86.183, 83.179) and (32.297, 79.188, -107.860). */
    fill(first, 0, 0, 0);
    fill(second, 255, 255, 255);
    const double greatest =
        (87.735 - 32.297) + hypot(-86.183 * 0.87735 - 79.188 * 0.32297, 83.179 * 0.87735 + 107.860 * 0.32297);
    const double most = pow(greatest, 0.7), error = pow(100, 0.7);
    assert_float_equal(flip(FLIP_PIXELS_PER_DEGREE), 0.95 + 0.05 * (error - 0.4 * most) / (0.6 * most), 1e-4);
    fill(first, 128, 128, 128); /* a small difference is in the steep part */
    fill(second, 133, 133, 133);
    assert_float_equal(flip(FLIP_PIXELS_PER_DEGREE),
                       0.95 * pow(116 * (root(linear(133)) - root(linear(128))), 0.7) / (0.4 * most), 1e-4);
}

/* ---- a slow copy, with kernels of two dimensions, as the paper writes it ---- */

static void opponent_at(const uint8_t *pixels, int x, int y, double out[3]) {
    x = CLAMP(x, 0, WIDTH - 1);
    y = CLAMP(y, 0, HEIGHT - 1);
    const uint8_t *p = pixels + (y * WIDTH + x) * 4;
    double r = linear(p[0]), g = linear(p[1]), bl = linear(p[2]);
    double X = (0.4124564 * r + 0.3575761 * g + 0.1804375 * bl) / 0.95047,
           Y = 0.2126729 * r + 0.7151522 * g + 0.0721750 * bl,
           Z = (0.0193339 * r + 0.1191920 * g + 0.9503041 * bl) / 1.08883;
    out[0] = 116 * Y - 16;
    out[1] = 500 * (X - Y);
    out[2] = 200 * (Y - Z);
}

static double sensitivity(int channel, double distance2) {
    const double pi2 = 9.869604401089358, pi = 3.141592653589793;
    if (channel < 2) return exp(-pi2 * distance2 / (channel ? 0.0053 : 0.0047));
    return 34.1 * sqrt(pi / 0.04) * exp(-pi2 * distance2 / 0.04) + 13.5 * sqrt(pi / 0.025) * exp(-pi2 * distance2 / 0.025);
}

static void lab_at(const uint8_t *pixels, int x, int y, double density, double out[3]) {
    const int radius = (int)ceil(3 * sqrt(0.04 / (2 * 9.869604401089358)) * density);
    double seen[3];
    for (int c = 0; c < 3; c++) {
        double sum = 0, all = 0;
        for (int j = -radius; j <= radius; j++)
            for (int i = -radius; i <= radius; i++) {
                double o[3], weight = sensitivity(c, (i * i + j * j) / (density * density));
                opponent_at(pixels, x + i, y + j, o);
                sum += weight * o[c];
                all += weight;
            }
        seen[c] = sum / all;
    }
    double Y = (seen[0] + 16) / 116, X = Y + seen[1] / 500, Z = Y - seen[2] / 200;
    const double xyz[3] = {X * 0.95047, Y, Z * 1.08883};
    static const double back[3][3] = {
        {3.2404542, -1.5371385, -0.4985314}, {-0.9692660, 1.8760108, 0.0415560}, {0.0556434, -0.2040259, 1.0572252}};
    double rgb[3];
    for (int c = 0; c < 3; c++) rgb[c] = CLAMP(back[c][0] * xyz[0] + back[c][1] * xyz[1] + back[c][2] * xyz[2], 0.0, 1.0);
    double fx = root((0.4124564 * rgb[0] + 0.3575761 * rgb[1] + 0.1804375 * rgb[2]) / 0.95047),
           fy = root(0.2126729 * rgb[0] + 0.7151522 * rgb[1] + 0.0721750 * rgb[2]),
           fz = root((0.0193339 * rgb[0] + 0.1191920 * rgb[1] + 0.9503041 * rgb[2]) / 1.08883);
    out[0] = 116 * fy - 16;
    out[1] = 5 * out[0] * (fx - fy);
    out[2] = 2 * out[0] * (fy - fz);
}

/* Edge or point: the first or second derivative, across and down. */
static double feature_at(const uint8_t *pixels, int x, int y, double density, bool point) {
    const double sigma = 0.041 * density;
    const int radius = (int)ceil(3 * sigma);
    double sums[2][2] = {{0}}, weights[2] = {0}; /* [direction][sign] */
    for (int j = -radius; j <= radius; j++)
        for (int i = -radius; i <= radius; i++) {
            double o[3], bell = exp(-(i * i + j * j) / (2 * sigma * sigma));
            opponent_at(pixels, x + i, y + j, o);
            for (int d = 0; d < 2; d++) {
                int at = d ? j : i;
                double weight = bell * (point ? at * at / (sigma * sigma) - 1 : -at);
                sums[d][weight > 0] += fabs(weight) * (o[0] + 16) / 116;
                if (d == 0) weights[weight > 0] += fabs(weight);
            }
        }
    return hypot(sums[0][1] / weights[1] - sums[0][0] / weights[0], sums[1][1] / weights[1] - sums[1][0] / weights[0]);
}

static double slow_at(int x, int y, double density) {
    double la[3], lb[3];
    lab_at(first, x, y, density, la);
    lab_at(second, x, y, density, lb);
    const double most = pow(203.254, 0.7), error = pow(fabs(la[0] - lb[0]) + hypot(la[1] - lb[1], la[2] - lb[2]), 0.7);
    double color = error < 0.4 * most ? 0.95 * error / (0.4 * most) : 0.95 + 0.05 * (error - 0.4 * most) / (0.6 * most);
    double edge = fabs(feature_at(first, x, y, density, false) - feature_at(second, x, y, density, false)),
           point = fabs(feature_at(first, x, y, density, true) - feature_at(second, x, y, density, true));
    return pow(color, 1 - sqrt(fmax(edge, point) / 1.4142135623730951));
}

static void test_pixels_equal_a_slow_copy(void **state) {
    UNUSED(state);
    struct random_state random = {5};
    float map[COUNT];
    for (int i = 0; i < COUNT * 4; i++) {
        first[i] = (uint8_t)random_bits(&random);
        second[i] = (uint8_t)(random_float(&random) < 0.5f ? first[i] : random_bits(&random));
    }
    static const double densities[] = {12, 25};
    for (uint32_t k = 0; k < COUNT_OF(densities); k++) {
        double mean = flip_compare(&a, &b, densities[k], map), sum = 0;
        for (int i = 0; i < COUNT; i++) {
            double wanted = slow_at(i % WIDTH, i / WIDTH, densities[k]);
            sum += wanted / COUNT;
            if (fabs((double)map[i] - wanted) > 2e-4)
                fail_msg("at %d, %d: %g, must be %g", i % WIDTH, i / WIDTH, (double)map[i], wanted);
        }
        assert_float_equal(mean, sum, 1e-4);
        assert_true(mean > 0.1);
        assert_float_equal(flip_compare(&b, &a, densities[k], NULL), mean, 1e-12);
    }
}

/* The smaller a detail is, the less it matters; 16 bits are as good as 8. */
static void test_details(void **state) {
    UNUSED(state);
    fill(first, 90, 90, 90);
    fill(second, 90, 90, 90);
    for (int i = 0; i < COUNT; i++)
        second[i * 4 + 1] = (i % WIDTH + i / WIDTH) % 2 ? 60 : 111; /* whose mean is 90 in linear light */
    double near = flip(20), far = flip(80);
    if (!(near > far && far > 0 && far < 0.05)) fail_msg("from near %g, from far %g", near, far);
    static uint16_t wide[COUNT * 4];
    for (int i = 0; i < COUNT * 4; i++) wide[i] = (uint16_t)(second[i] * 257);
    const fnl_image c = {WIDTH, HEIGHT, FNL_PIXEL_FORMAT_RGBA16, wide};
    assert_float_equal(flip_compare(&a, &c, 20, NULL), near, 1e-9);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_plain_colours),
        cmocka_unit_test(test_pixels_equal_a_slow_copy),
        cmocka_unit_test(test_details),
    };
    return cmocka_run_group_tests_name("flip", tests, NULL, NULL);
}
