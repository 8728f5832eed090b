/* SPDX-License-Identifier: MIT */
/** Scenes, frames and comparisons that the tests of deferred attribute interpolation share. */
#ifndef FNL_TESTS_DAIS_CASES_H
#define FNL_TESTS_DAIS_CASES_H

#include "tests/triangle_soup.h"

/* ---- scenes ---- */

static const struct soup crossing = {60, 2, 30, .lines = false}, confetti = {60, 60, 0.5f, .flat = true}, paper = {60, 60, 0.5f, .plain = true};

static inline fnl_frame wide_frame(int view) {
    fnl_frame frame = soup_frame(FNL_OUTPUT_RADIANCE, view);
    frame.shading = FNL_SHADING_DAIS;
    return frame;
}

struct closeness {
    uint32_t beyond, shown;
    double worst;
};

/* Pixels of `a` that show something and differ in `b` by more than `allowed`. */
static inline struct closeness compare(const fnl_image *a, const fnl_image *b, double allowed) {
    struct closeness c = {0};
    for (uint32_t y = 0; y < a->height; y++)
        for (uint32_t x = 0; x < a->width; x++) {
            const float *p = test_pixel(a, x, y), *q = test_pixel(b, x, y);
            double error = 0;
            for (int k = 0; k < 3; k++) error = fmax(error, fabs((double)p[k] - (double)q[k]));
            c.shown += p[0] > 0 || p[1] > 0 || p[2] > 0;
            c.beyond += !(error <= allowed);
            c.worst = fmax(c.worst, error);
        }
    return c;
}

static inline fnl_image shoot(fnl_renderer *renderer, const fnl_frame *frame) {
    test_render_frame(renderer, frame);
    return test_read(renderer, FNL_OUTPUT_RADIANCE);
}

static inline uint32_t sample_counts(uint32_t i) {
    static const uint32_t counts[] = {1, 4, 8, 2};
    return counts[i];
}

static inline bool has_samples(uint32_t samples) {
    fnl_device_info info;
    assert_int_equal(fnl_device_query_info(test_device, &info), FNL_OK);
    return info.msaa_counts & samples;
}

#endif
