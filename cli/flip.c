/* SPDX-License-Identifier: MIT */
#include "flip.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

/* ---- colours ---- */

struct color {
    double x, y, z; /* of whatever space */
};

/* From linear sRGB to XYZ (IEC 61966-2-1), where white is the sum of each row; and back. */
static const double to_xyz[3][3] = {
    {0.4124564, 0.3575761, 0.1804375}, {0.2126729, 0.7151522, 0.0721750}, {0.0193339, 0.1191920, 0.9503041}};
static const double from_xyz[3][3] = {
    {3.2404542, -1.5371385, -0.4985314}, {-0.9692660, 1.8760108, 0.0415560}, {0.0556434, -0.2040259, 1.0572252}};

static struct color transform(const double m[3][3], struct color c) {
    return (struct color){m[0][0] * c.x + m[0][1] * c.y + m[0][2] * c.z, m[1][0] * c.x + m[1][1] * c.y + m[1][2] * c.z,
                          m[2][0] * c.x + m[2][1] * c.y + m[2][2] * c.z};
}

static double white(int i) { return to_xyz[i][0] + to_xyz[i][1] + to_xyz[i][2]; }

/* XYZ as parts of white. */
static struct color relative_xyz(struct color rgb) {
    struct color c = transform(to_xyz, rgb);
    return (struct color){c.x / white(0), c.y / white(1), c.z / white(2)};
}

/* The linear opponent space YCxCz, in which contrast sensitivity was measured. */
static struct color opponent(struct color rgb) {
    struct color c = relative_xyz(rgb);
    return (struct color){116 * c.y - 16, 500 * (c.x - c.y), 200 * (c.y - c.z)};
}

static double clamp01(double x) { return x > 0 ? x < 1 ? x : 1 : 0; }

/* Back to linear sRGB, within what a screen can show. */
static struct color displayed(struct color o) {
    double y = (o.x + 16) / 116;
    struct color xyz = {(y + o.y / 500) * white(0), y * white(1), (y - o.z / 200) * white(2)},
                 rgb = transform(from_xyz, xyz);
    return (struct color){clamp01(rgb.x), clamp01(rgb.y), clamp01(rgb.z)};
}

static double lab_curve(double t) {
    const double d = 6 / 29.0;
    return t > d * d * d ? cbrt(t) : t / (3 * d * d) + 4 / 29.0;
}

/* CIELAB, in which dark colours are made less colourful (Hunt's effect). */
static struct color hunt_lab(struct color rgb) {
    struct color c = relative_xyz(rgb);
    double fx = lab_curve(c.x), fy = lab_curve(c.y), fz = lab_curve(c.z), lightness = 116 * fy - 16;
    return (struct color){lightness, 0.01 * lightness * 500 * (fx - fy), 0.01 * lightness * 200 * (fy - fz)};
}

/* HyAB: for large distances, which lightness and hue add up to. */
static double distance(struct color a, struct color b) { return fabs(a.x - b.x) + hypot(a.y - b.y, a.z - b.z); }

/* Distances, of which the greatest is known, from 0 to 1: the lower 0.4 of the range, which people tell apart well, take 0.95 of it. */
static double color_error(struct color a, struct color b, double greatest) {
    const double exponent = 0.7, part = 0.4, share = 0.95;
    double most = pow(greatest, exponent), error = pow(distance(a, b), exponent);
    if (error < part * most) return share / (part * most) * error;
    return share + (error - part * most) / (most - part * most) * (1 - share);
}

/* ---- filters ---- */

enum { RADIUS_MAX = 512 };

struct kernel {
    int radius;
    double weights[2 * RADIUS_MAX + 1];
};

/* exp(-factor x^2), x in units of `step`; not normalised. */
static void make_gaussian(struct kernel *k, int radius, double step, double factor) {
    k->radius = radius;
    for (int i = -radius; i <= radius; i++) k->weights[i + radius] = exp(-factor * i * step * i * step);
}

static double sum_of(const struct kernel *k) {
    double sum = 0;
    for (int i = 0; i <= 2 * k->radius; i++) sum += k->weights[i];
    return sum;
}

static void scale(struct kernel *k, double factor) {
    for (int i = 0; i <= 2 * k->radius; i++) k->weights[i] *= factor;
}

/* Positive weights get a sum of 1, negative ones of -1. */
static void balance(struct kernel *k) {
    double above = 0, below = 0;
    for (int i = 0; i <= 2 * k->radius; i++) *(k->weights[i] > 0 ? &above : &below) += fabs(k->weights[i]);
    for (int i = 0; i <= 2 * k->radius; i++) k->weights[i] /= k->weights[i] > 0 ? above : below;
}

struct size {
    uint32_t width, height;
};

static uint32_t clamped(int64_t i, uint32_t count) { return i < 0 ? 0 : i < count ? (uint32_t)i : count - 1; }

/* Along x, then along y; beyond the border its pixels go on. `row` has room for a row and 2 RADIUS_MAX more. */
static void filter(struct size s, const float *in, const struct kernel *across, const struct kernel *down, double *row,
                   float *between, float *out) {
    for (uint32_t y = 0; y < s.height; y++) {
        const float *from = in + (size_t)y * s.width;
        for (int64_t x = -across->radius; x < (int64_t)s.width + across->radius; x++)
            row[x + across->radius] = (double)from[clamped(x, s.width)];
        for (uint32_t x = 0; x < s.width; x++) {
            double sum = 0;
            for (int i = 0; i <= 2 * across->radius; i++) sum += across->weights[i] * row[x + (uint32_t)i];
            between[(size_t)y * s.width + x] = (float)sum;
        }
    }
    for (uint32_t y = 0; y < s.height; y++) {
        memset(row, 0, s.width * sizeof *row);
        for (int i = -down->radius; i <= down->radius; i++) {
            const float *from = between + (size_t)clamped((int64_t)y + i, s.height) * s.width;
            const double weight = down->weights[i + down->radius];
            for (uint32_t x = 0; x < s.width; x++) row[x] += weight * (double)from[x];
        }
        for (uint32_t x = 0; x < s.width; x++) out[(size_t)y * s.width + x] = (float)row[x];
    }
}

/* ---- one picture ---- */

enum { PLANES = 8 };

/* What is known of each picture: its colours as they are seen, and how strong edges and points are. */
struct seen {
    float *planes[PLANES]; /* 0..2: opponent, then Lab; 3, 4: edges, points; the rest is for work */
    double *row;           /* for work */
};

static double channel(const fnl_image *image, size_t i) {
    double x = image->format == FNL_PIXEL_FORMAT_RGBA8 ? ((const uint8_t *)image->pixels)[i] / 255.0
                                                       : ((const uint16_t *)image->pixels)[i] / 65535.0;
    return x <= 0.04045 ? x / 12.92 : pow((x + 0.055) / 1.055, 2.4);
}

static void find_features(struct size s, struct seen *seen, double pixels_per_degree) {
    const double sigma = 0.5 * 0.082 * pixels_per_degree; /* of details that are 0.082 degrees wide */
    const size_t count = (size_t)s.width * s.height;
    struct kernel smooth, first, second;
    make_gaussian(&smooth, (int)ceil(3 * sigma), 1, 1 / (2 * sigma * sigma));
    first = second = smooth;
    scale(&smooth, 1 / sum_of(&smooth));
    for (int i = -first.radius; i <= first.radius; i++) {
        first.weights[i + first.radius] *= -i;
        second.weights[i + first.radius] *= i * i / (sigma * sigma) - 1;
    }
    balance(&first);
    balance(&second);
    float *light = seen->planes[5], *across = seen->planes[6], *between = seen->planes[7];
    for (size_t i = 0; i < count; i++) light[i] = (seen->planes[0][i] + 16) / 116;
    for (int k = 0; k < 2; k++) { /* edges, points */
        const struct kernel *derivative = k ? &second : &first;
        float *out = seen->planes[3 + k];
        filter(s, light, derivative, &smooth, seen->row, between, across);
        filter(s, light, &smooth, derivative, seen->row, between, out);
        for (size_t i = 0; i < count; i++) out[i] = hypotf(across[i], out[i]);
    }
}

/* What the eye makes of the details: contrast sensitivity as sums of Gaussians (a, b), for lightness, red-green and blue-yellow. */
static void blur(struct size s, struct seen *seen, double pixels_per_degree) {
    static const double functions[3][2][2] = {{{1, 0.0047}, {0, 1}}, {{1, 0.0053}, {0, 1}}, {{34.1, 0.04}, {13.5, 0.025}}};
    const size_t count = (size_t)s.width * s.height;
    const int radius = (int)ceil(3 * sqrt(0.04 / (2 * PI * PI)) * pixels_per_degree);
    float *one = seen->planes[5], *other = seen->planes[6], *between = seen->planes[7];
    for (int c = 0; c < 3; c++) {
        double weights[2] = {0};
        for (int k = 0; k < 2; k++) {
            const double a = functions[c][k][0], b = functions[c][k][1];
            struct kernel gaussian;
            if (a == 0) continue;
            make_gaussian(&gaussian, radius, 1 / pixels_per_degree, PI * PI / b);
            double sum = sum_of(&gaussian);
            weights[k] = a * sqrt(PI / b) * sum * sum;
            scale(&gaussian, 1 / sum);
            filter(s, seen->planes[c], &gaussian, &gaussian, seen->row, between, k ? other : one);
        }
        const double all = weights[0] + weights[1];
        for (size_t i = 0; i < count; i++)
            seen->planes[c][i] =
                (float)((weights[0] * (double)one[i] + (weights[1] > 0 ? weights[1] * (double)other[i] : 0)) / all);
    }
}

static void look(const fnl_image *image, double pixels_per_degree, struct seen *seen) {
    const struct size s = {image->width, image->height};
    const size_t count = (size_t)s.width * s.height;
    for (size_t i = 0; i < count; i++) {
        struct color o =
            opponent((struct color){channel(image, i * 4), channel(image, i * 4 + 1), channel(image, i * 4 + 2)});
        seen->planes[0][i] = (float)o.x;
        seen->planes[1][i] = (float)o.y;
        seen->planes[2][i] = (float)o.z;
    }
    find_features(s, seen, pixels_per_degree);
    blur(s, seen, pixels_per_degree);
    for (size_t i = 0; i < count; i++) {
        const struct color o = {(double)seen->planes[0][i], (double)seen->planes[1][i], (double)seen->planes[2][i]};
        struct color lab = hunt_lab(displayed(o));
        seen->planes[0][i] = (float)lab.x;
        seen->planes[1][i] = (float)lab.y;
        seen->planes[2][i] = (float)lab.z;
    }
}

/* ---- two pictures ---- */

double flip_compare(const fnl_image *a, const fnl_image *b, double pixels_per_degree, float *map) {
    const size_t count = (size_t)a->width * a->height;
    struct seen seen[2];
    float *memory = malloc(2 * PLANES * count * sizeof *memory);
    double *row = malloc((a->width + 2 * (size_t)RADIUS_MAX) * sizeof *row);
    if (!memory || !row) {
        free(memory);
        free(row);
        return -1;
    }
    for (int k = 0; k < 2; k++) {
        seen[k].row = row;
        for (int i = 0; i < PLANES; i++) seen[k].planes[i] = memory + (size_t)(k * PLANES + i) * count;
        look(k ? b : a, pixels_per_degree, &seen[k]);
    }
    const double greatest = distance(hunt_lab((struct color){0, 1, 0}),
                                     hunt_lab((struct color){0, 0, 1})); /* of what screens show: green and blue */
    double sum = 0;
    for (size_t i = 0; i < count; i++) {
        struct color colors[2];
        for (int k = 0; k < 2; k++)
            colors[k] =
                (struct color){(double)seen[k].planes[0][i], (double)seen[k].planes[1][i], (double)seen[k].planes[2][i]};
        double edge = fabs((double)seen[0].planes[3][i] - (double)seen[1].planes[3][i]),
               point = fabs((double)seen[0].planes[4][i] - (double)seen[1].planes[4][i]);
        double feature = sqrt(clamp01(fmax(edge, point) / sqrt(2))),
               error = pow(color_error(colors[0], colors[1], greatest), 1 - feature);
        sum += error;
        if (map) map[i] = (float)error;
    }
    free(memory);
    free(row);
    return sum / (double)count;
}
