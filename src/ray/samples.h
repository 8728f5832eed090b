/* SPDX-License-Identifier: MIT */
/** Numbers in [0, 1) for the samples of a pixel: those of all samples together fill each range evenly, and depend on nothing else. */
#ifndef FNL_RAY_SAMPLES_H
#define FNL_RAY_SAMPLES_H

#include "base/base.h"

/** Numbers of one sample of one pixel. */
struct ray_samples {
    struct random_state random; /* numbers that need no order */
    uint64_t pixel;             /* scrambles all that the pixel draws */
    uint32_t index;             /* of the sample, below 2^20 */
    uint32_t place, drawn;      /* what the next numbers are for: ray_samples_next(), and draws since */
};

enum { RAY_DRAW_MAX = 3 };

struct ray_samples ray_samples_make(uint64_t seed, uint32_t x, uint32_t y, uint32_t index);
/** The next surface on the path: its draws are those of the same surface in other samples, however many there were before. */
void ray_samples_next(struct ray_samples *samples);
/**
 * 1 to RAY_DRAW_MAX numbers: a point of Sobol's sequence, in an order and with digits scrambled by pixel and place (A. Owen 1995, by the hash of B. Burley,
 * "Practical Hash-based Owen Scrambling", JCGT 2020, after S. Laine and T. Karras 2011). The first 2^k samples of a pixel are well spread for any k.
 */
void ray_samples_draw(struct ray_samples *samples, int count, double *out);

#endif
