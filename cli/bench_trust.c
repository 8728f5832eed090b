/* SPDX-License-Identifier: MIT */
/* How far times can be trusted: pure functions of samples. */
#include "bench.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define UNSTEADY 1.5     /* p95 over p5 */
#define BUSY 0.1         /* of the processors, kept busy by other programs */
#define NARROW 0.03      /* of the median: half of the width of its interval */
#define CONFIDENCE 0.95
enum { MORE = BENCH_FRAMES_FACTOR };

static int compare_doubles(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Between the two nearest ranks. */
static double quantile(const double *sorted, uint32_t count, double part) {
    double place = part * (count - 1), low = floor(place);
    uint32_t i = (uint32_t)low;
    return i + 1 < count ? sorted[i] + (sorted[i + 1] - sorted[i]) * (place - low) : sorted[count - 1];
}

/*
 * Samples that lie outside of the median's interval on each side. Whatever the distribution, the number of samples below the true median is binomial with
 * 1/2; as many are left out as keep both tails within 1 - CONFIDENCE. None with fewer than six samples.
 */
static uint32_t outside(uint32_t count) {
    double term = pow(0.5, count), tail = 0; /* of 0 successes; beyond 1000 samples by the normal distribution, which is the same then */
    if (count > 1000) return (uint32_t)floor(0.5 * count - 0.98 * sqrt(count) - 0.5);
    for (uint32_t k = 0; k < count; k++) {
        tail += term;
        if (2 * tail > 1 - CONFIDENCE) return k ? k - 1 : 0;
        term *= (double)(count - k) / (k + 1);
    }
    return 0;
}

bool bench_spread_of(const double *times, uint32_t count, struct bench_spread *out) {
    double *sorted = malloc((count + 1) * sizeof *sorted);
    *out = (struct bench_spread){0};
    if (!sorted || count == 0) {
        free(sorted);
        return false;
    }
    memcpy(sorted, times, count * sizeof *sorted);
    qsort(sorted, count, sizeof *sorted, compare_doubles);
    const uint32_t out_low = outside(count);
    *out = (struct bench_spread){.median = quantile(sorted, count, 0.5),
                                 .min = sorted[0],
                                 .p5 = quantile(sorted, count, 0.05),
                                 .p95 = quantile(sorted, count, 0.95),
                                 .low = sorted[out_low],
                                 .high = sorted[count - 1 - out_low]};
    for (uint32_t i = 0; i < count; i++) sorted[i] = fabs(sorted[i] - out->median);
    qsort(sorted, count, sizeof *sorted, compare_doubles);
    out->mad = quantile(sorted, count, 0.5);
    free(sorted);
    return true;
}

bool bench_is_unsteady(const struct bench_spread *spread) { return spread->p95 > UNSTEADY * spread->p5; }
bool bench_is_busy(double others, uint32_t processors) { return others > BUSY * processors; }

uint32_t bench_frames_wanted(const struct bench_spread *spread, uint32_t measured, uint32_t asked, bool busy) {
    if (measured < asked) return asked;
    const bool narrow = spread->high - spread->low <= 2 * NARROW * spread->median;
    if (narrow || measured >= MORE * asked || !(busy || bench_is_unsteady(spread))) return measured;
    return measured + asked < MORE * asked ? measured + asked : MORE * asked;
}
