/* SPDX-License-Identifier: MIT */
#include "leak.h"

#include <math.h>

static double luminance(const float *rgb) { return 0.2126 * (double)rgb[0] + 0.7152 * (double)rgb[1] + 0.0722 * (double)rgb[2]; }

double leak_compare(const fnl_image *a, const fnl_image *b, const fnl_image *lit) {
    const float *left = a->pixels, *right = b->pixels, *whole = lit->pixels;
    double wrong = 0, all = 0;
    for (size_t i = 0; i < (size_t)a->width * a->height; i++) {
        wrong += fabs(luminance(left + i * 4) - luminance(right + i * 4));
        all += luminance(whole + i * 4);
    }
    if (isnan(wrong) || isnan(all)) return INFINITY;
    return wrong == 0 ? 0 : all > 0 ? wrong / all : (double)INFINITY;
}
