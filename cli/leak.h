/* SPDX-License-Identifier: MIT */
/** How much light is on the wrong side of shadows. */
#ifndef FNL_CLI_LEAK_H
#define FNL_CLI_LEAK_H

#include "fanal/image.h"

/**
 * Sum of the differences of luminance between A and B, as a part of the luminance of `lit`, the same without shadows. Where each pixel gets light
 * from one light, this is the sum of L |Va - Vb| over that of L. 0 where A and B are equal; INFINITY where a value is NaN, or there is no light.
 * All three are FNL_PIXEL_FORMAT_RGBA32F, linear, and of one size.
 */
double leak_compare(const fnl_image *a, const fnl_image *b, const fnl_image *lit);

#endif
