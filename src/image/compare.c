/* SPDX-License-Identifier: MIT */
/* How far two pictures are apart, row by row: memory grows with the width alone. */
#include "image/image.h"

#include <float.h>
#include <math.h>

/* SSIM as in Wang, Bovik, Sheikh, Simoncelli, "Image quality assessment: from error visibility to structural
   similarity", IEEE Transactions on Image Processing 13(4), 2004: window, constants. */
#define WINDOW 11
#define RADIUS (WINDOW / 2)
#define SIGMA 1.5
#define K1 0.01
#define K2 0.03

/* Windowed at each pixel: means of a, b, a^2, b^2 and ab. */
enum { MOMENTS = 5 };

/* Pixels are taken in units of 1 / `unit`: integers as 16-bit ones, so that a difference of N/255 is exactly that. */
struct comparison {
    const fnl_image *a, *b;
    bool integer; /* both are */
    double unit, peak;
};

static void load_row(const struct comparison *comparison, const fnl_image *image, uint32_t y, double *row) {
    size_t count = (size_t)image->width * 4, start = y * count;
    double scale = comparison->integer ? 1 : 65535;
    switch (image->format) {
    case FNL_PIXEL_FORMAT_RGBA8:
        for (size_t i = 0; i < count; i++) row[i] = ((const uint8_t *)image->pixels)[start + i] * 257.0 / scale;
        break;
    case FNL_PIXEL_FORMAT_RGBA16:
        for (size_t i = 0; i < count; i++) row[i] = ((const uint16_t *)image->pixels)[start + i] / scale;
        break;
    case FNL_PIXEL_FORMAT_RGBA32F:
        for (size_t i = 0; i < count; i++) row[i] = ((const float *)image->pixels)[start + i];
        break;
    }
}

/* Equal infinities and NaN on both sides are no difference; NaN on one side is an infinite one. */
static double distance(double a, double b) {
    if (a == b || (isnan(a) && isnan(b))) return 0;
    return isnan(a) || isnan(b) ? (double)INFINITY : fabs(a - b);
}

static double greatest_finite(const fnl_image *image, double least) {
    if (image->format != FNL_PIXEL_FORMAT_RGBA32F) return least;
    const float *values = image->pixels;
    for (size_t i = (size_t)image->width * image->height * 4; i > 0; i--, values++)
        if (isfinite(*values) && *values > least) least = *values;
    return least;
}

static fnl_result begin(const struct call *call, const fnl_image *a, const fnl_image *b, struct comparison *out) {
    TRY(image_check(call, "a", a));
    TRY(image_check(call, "b", b));
    if (a->width != b->width || a->height != b->height)
        return misuse(call, "pictures of different sizes cannot be compared: %u x %u and %u x %u", a->width, a->height,
                      b->width, b->height);
    *out = (struct comparison){.a = a, .b = b};
    out->integer = a->format != FNL_PIXEL_FORMAT_RGBA32F && b->format != FNL_PIXEL_FORMAT_RGBA32F;
    out->unit = out->integer ? 65535 : 1;
    out->peak = greatest_finite(b, greatest_finite(a, 1));
    return FNL_OK;
}

/* ---- structural similarity ---- */

/*
 * Only whole windows count, as in the paper; along an axis shorter than a window every pixel counts, with its window
 * cut at the border and its weights brought back to a sum of 1.
 */
struct axis {
    uint32_t length, first, count;
};

static struct axis axis_make(uint32_t length) {
    return length < WINDOW ? (struct axis){length, 0, length} : (struct axis){length, RADIUS, length - WINDOW + 1};
}

/* The taps of one window on an axis; `low` is the first position. */
static uint32_t window_weights(const struct axis *axis, uint32_t center, uint32_t *low, double weights[WINDOW]) {
    *low = center < RADIUS ? 0 : center - RADIUS;
    uint32_t high = MIN(center + RADIUS, axis->length - 1), count = high - *low + 1;
    double sum = 0;
    for (uint32_t i = 0; i < count; i++) {
        double d = (double)*low + i - center;
        sum += weights[i] = exp(-d * d / (2 * SIGMA * SIGMA));
    }
    for (uint32_t i = 0; i < count; i++) weights[i] /= sum;
    return count;
}

struct ssim {
    struct axis x, y;
    double *luma[2]; /* one row of each picture */
    double *moments; /* one row of each moment */
    double *ring;    /* WINDOW rows of each moment, filtered along x */
    double *sums;    /* one row of each moment, filtered along both */
    double c1, c2, total;
};

static size_t ssim_doubles(uint32_t width) { return (size_t)width * (2 + MOMENTS + WINDOW * MOMENTS + MOMENTS); }

static void ssim_init(struct ssim *ssim, uint32_t width, uint32_t height, double range, double *memory) {
    *ssim = (struct ssim){.x = axis_make(width), .y = axis_make(height)};
    ssim->luma[0] = memory;
    ssim->luma[1] = ssim->luma[0] + width;
    ssim->moments = ssim->luma[1] + width;
    ssim->ring = ssim->moments + (size_t)width * MOMENTS;
    ssim->sums = ssim->ring + (size_t)width * WINDOW * MOMENTS;
    ssim->c1 = K1 * range * K1 * range;
    ssim->c2 = K2 * range * K2 * range;
}

static void filter_row(const struct axis *axis, const double *row, double *out) {
    double weights[WINDOW];
    uint32_t low, taps = 0;
    for (uint32_t i = 0; i < axis->count; i++) {
        if (i == 0 || axis->length < WINDOW) /* whole windows are all alike */
            taps = window_weights(axis, axis->first + i, &low, weights);
        else
            low = i;
        double sum = 0;
        for (uint32_t tap = 0; tap < taps; tap++) sum += weights[tap] * row[low + tap];
        out[i] = sum;
    }
}

/* Adds the windows around one row, whose rows are in the ring. */
static void add_center(struct ssim *ssim, uint32_t center) {
    double weights[WINDOW], total = 0;
    uint32_t low, taps = window_weights(&ssim->y, center, &low, weights);
    size_t count = ssim->x.count, row_size = count * MOMENTS;
    memset(ssim->sums, 0, row_size * sizeof(double));
    for (uint32_t tap = 0; tap < taps; tap++) {
        const double *row = ssim->ring + (low + tap) % WINDOW * row_size;
        for (size_t i = 0; i < row_size; i++) ssim->sums[i] += weights[tap] * row[i];
    }
    const double *a = ssim->sums, *b = a + count, *aa = b + count, *bb = aa + count, *ab = bb + count;
    for (size_t i = 0; i < count; i++) {
        double variance_a = aa[i] - a[i] * a[i], variance_b = bb[i] - b[i] * b[i], covariance = ab[i] - a[i] * b[i];
        double value = (2 * a[i] * b[i] + ssim->c1) * (2 * covariance + ssim->c2) /
                       ((a[i] * a[i] + b[i] * b[i] + ssim->c1) * (variance_a + variance_b + ssim->c2));
        if (isfinite(value)) total += value; /* a window with an infinite difference in it counts as 0 */
    }
    ssim->total += total;
}

/* Takes the luma rows of row y, and adds the windows that are complete with it. */
static void ssim_add_row(struct ssim *ssim, uint32_t y) {
    size_t width = ssim->x.length;
    const double *a = ssim->luma[0], *b = ssim->luma[1];
    double *m = ssim->moments;
    for (size_t x = 0; x < width; x++) {
        m[x] = a[x];
        m[width + x] = b[x];
        m[2 * width + x] = a[x] * a[x];
        m[3 * width + x] = b[x] * b[x];
        m[4 * width + x] = a[x] * b[x];
    }
    double *ring = ssim->ring + y % WINDOW * (size_t)ssim->x.count * MOMENTS;
    for (size_t k = 0; k < MOMENTS; k++) filter_row(&ssim->x, m + k * width, ring + k * ssim->x.count);
    if (ssim->y.length >= WINDOW && y >= WINDOW - 1) add_center(ssim, y - RADIUS);
    if (ssim->y.length < WINDOW && y == ssim->y.length - 1)
        for (uint32_t center = 0; center < ssim->y.length; center++) add_center(ssim, center);
}

/* Luma by the weights of Rec. ITU-R BT.709. What is equal but not finite is left out of both; an infinite difference
   becomes NaN, which reaches exactly the windows that hold it. */
static void luma_of_pixel(const double *a, const double *b, double *luma_a, double *luma_b) {
    static const double weights[3] = {0.2126, 0.7152, 0.0722};
    *luma_a = *luma_b = 0;
    for (int c = 0; c < 3; c++) {
        if (isfinite(a[c]) && isfinite(b[c])) {
            *luma_a += weights[c] * a[c];
            *luma_b += weights[c] * b[c];
        } else if (distance(a[c], b[c]) != 0) {
            *luma_a = NAN;
        }
    }
}

/* ---- the whole ---- */

fnl_result fnl_image_compare(const fnl_host *host, const fnl_image *a, const fnl_image *b, fnl_image_difference *out) {
    fnl_host resolved = host_resolve(host);
    TRY(check_pointer(CALL(&resolved), "out", out));
    *out = (fnl_image_difference){0};
    struct comparison comparison;
    TRY(begin(CALL(&resolved), a, b, &comparison));
    size_t row_doubles = (size_t)a->width * 4, size = (row_doubles * 2 + ssim_doubles(a->width)) * sizeof(double);
    double *rows = host_allocate(&resolved, size);
    if (!rows) return FNL_ERROR_MEMORY;
    struct ssim ssim;
    ssim_init(&ssim, a->width, a->height, comparison.peak * comparison.unit, rows + row_doubles * 2);

    fnl_image_difference difference = {0};
    double sum = 0, square_sum = 0;
    for (uint32_t y = 0; y < a->height; y++) {
        double *row_a = rows, *row_b = rows + row_doubles, row_sum = 0, row_square_sum = 0;
        load_row(&comparison, a, y, row_a);
        load_row(&comparison, b, y, row_b);
        for (uint32_t x = 0; x < a->width; x++) {
            const double *pixel_a = row_a + (size_t)x * 4, *pixel_b = row_b + (size_t)x * 4;
            bool differs = false;
            for (int c = 0; c < 4; c++) {
                double d = distance(pixel_a[c], pixel_b[c]);
                if (d == 0) continue;
                differs = true;
                d /= comparison.unit;
                row_sum += d;
                row_square_sum += d * d;
                if (d > difference.max) {
                    difference.max = d;
                    difference.max_x = x;
                    difference.max_y = y;
                }
            }
            difference.differing_pixels += differs;
            luma_of_pixel(pixel_a, pixel_b, &ssim.luma[0][x], &ssim.luma[1][x]);
        }
        sum += row_sum;
        square_sum += row_square_sum;
        ssim_add_row(&ssim, y);
    }
    host_free(&resolved, rows, size);
    double samples = (double)a->width * a->height * 4;
    difference.mean = sum / samples;
    difference.rmse = sqrt(square_sum / samples);
    difference.psnr = difference.rmse == 0 ? (double)INFINITY : 20 * log10(comparison.peak / difference.rmse);
    difference.ssim = ssim.total / ((double)ssim.x.count * ssim.y.count);
    *out = difference;
    return FNL_OK;
}

/* ---- the picture of the differences ---- */

/* The distance that is shown for channel c: alpha, having no place of its own, shows in all three. */
static double shown_distance(const double *a, const double *b, int c) {
    return fmax(distance(a[c], b[c]), distance(a[3], b[3]));
}

static double greatest_shown(const struct comparison *comparison, double *row_a, double *row_b) {
    double greatest = 0;
    for (uint32_t y = 0; y < comparison->a->height; y++) {
        load_row(comparison, comparison->a, y, row_a);
        load_row(comparison, comparison->b, y, row_b);
        for (size_t i = 0; i < (size_t)comparison->a->width * 4; i++) {
            double d = distance(row_a[i], row_b[i]);
            if (d > greatest && isfinite(d)) greatest = d;
        }
    }
    return greatest;
}

fnl_result fnl_image_difference_picture(const fnl_host *host, const fnl_image *a, const fnl_image *b, float gain,
                                        fnl_image *out) {
    fnl_host resolved = host_resolve(host);
    TRY(check_pointer(CALL(&resolved), "out", out));
    *out = (fnl_image){0};
    TRY(check_range(CALL(&resolved), "gain", (double)gain, 0, (double)FLT_MAX, ""));
    struct comparison comparison;
    TRY(begin(CALL(&resolved), a, b, &comparison));
    size_t row_doubles = (size_t)a->width * 4, rows_size = row_doubles * 2 * sizeof(double);
    fnl_image picture = {.width = a->width, .height = a->height, .format = FNL_PIXEL_FORMAT_RGBA8};
    double *rows = host_allocate(&resolved, rows_size);
    uint8_t *pixel = picture.pixels = host_allocate(&resolved, (size_t)a->width * a->height * 4);
    if (!rows || !pixel) {
        host_free(&resolved, rows, rows_size);
        fnl_image_free(&resolved, &picture);
        return FNL_ERROR_MEMORY;
    }
    double *row_a = rows, *row_b = rows + row_doubles;
    double scale = gain / comparison.unit;
    if (gain == 0) {
        double greatest = greatest_shown(&comparison, row_a, row_b);
        scale = greatest > 0 ? 1 / greatest : 0;
    }
    for (uint32_t y = 0; y < a->height; y++) {
        load_row(&comparison, a, y, row_a);
        load_row(&comparison, b, y, row_b);
        for (size_t x = 0; x < a->width; x++, pixel += 4) {
            for (int c = 0; c < 3; c++) {
                double d = shown_distance(row_a + x * 4, row_b + x * 4, c);
                pixel[c] = isfinite(d) ? (uint8_t)(fmin(d * scale, 1) * 255 + 0.5) : 255;
            }
            pixel[3] = 255;
        }
    }
    host_free(&resolved, rows, rows_size);
    *out = picture;
    return FNL_OK;
}
