/* SPDX-License-Identifier: MIT */
/* Colors of other primaries as Rec. 709 (ITU-R BT.709-6). */
#include "image/codec.h"

#include <math.h>

static const float rec709[8] = {0.64f, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f, 0.3127f, 0.329f};

static bool invert(const double m[9], double out[9]) {
    for (int i = 0; i < 9; i++) {
        const int a = (i % 3 + 1) % 3, b = (i % 3 + 2) % 3, c = (i / 3 + 1) % 3, d = (i / 3 + 2) % 3;
        out[i] = m[3 * a + c] * m[3 * b + d] - m[3 * a + d] * m[3 * b + c];
    }
    const double determinant = m[0] * out[0] + m[1] * out[3] + m[2] * out[6];
    for (int i = 0; i < 9; i++) out[i] /= determinant;
    return isfinite(out[0]) && fabs(determinant) > 1e-9;
}

static void multiply(const double a[9], const double b[9], double out[9]) {
    for (int i = 0; i < 9; i++) out[i] = a[i / 3 * 3] * b[i % 3] + a[i / 3 * 3 + 1] * b[3 + i % 3] + a[i / 3 * 3 + 2] * b[6 + i % 3];
}

static void apply(const double m[9], const double v[3], double out[3]) {
    for (int i = 0; i < 3; i++) out[i] = m[3 * i] * v[0] + m[3 * i + 1] * v[1] + m[3 * i + 2] * v[2];
}

/* XYZ of x and y, at Y = 1. */
static void xyz_of(const float xy[2], double out[3]) {
    out[0] = (double)xy[0] / (double)xy[1];
    out[1] = 1;
    out[2] = (1 - (double)xy[0] - (double)xy[1]) / (double)xy[1];
}

/* From linear RGB to XYZ, white at Y = 1. */
static bool to_xyz(const float primaries[8], double out[9]) {
    double columns[9], inverse[9], white[3], part[3];
    for (int i = 0; i < 3; i++) {
        const double x = (double)primaries[2 * i], y = (double)primaries[2 * i + 1];
        columns[i] = x;
        columns[3 + i] = y;
        columns[6 + i] = 1 - x - y;
    }
    xyz_of(primaries + 6, white);
    if (!invert(columns, inverse)) return false;
    apply(inverse, white, part);
    for (int i = 0; i < 9; i++) out[i] = columns[i] * part[i % 3];
    return isfinite(out[0] + out[4] + out[8]);
}

/* One white as another: Bradford's cones (Lam 1985). */
static void adapt(const float from[2], const float to[2], double out[9]) {
    static const double cones[9] = {0.8951, 0.2664, -0.1614, -0.7502, 1.7135, 0.0367, 0.0389, -0.0685, 1.0296};
    double back[9], scaled[9], xyz[2][3], lms[2][3];
    xyz_of(from, xyz[0]);
    xyz_of(to, xyz[1]);
    for (int i = 0; i < 2; i++) apply(cones, xyz[i], lms[i]);
    for (int i = 0; i < 9; i++) scaled[i] = cones[i] * lms[1][i / 3] / lms[0][i / 3];
    (void)invert(cones, back);
    multiply(back, scaled, out);
}

enum primaries primaries_matrix(const float primaries[8], float out[9]) {
    double source[9], target[9], white[9], back[9], all[9];
    bool same = true, unknown = true; /* some programs write zeros */
    for (int i = 0; i < 8; i++) {
        if (!isfinite(primaries[i])) return PRIMARIES_BAD;
        same &= fabsf(primaries[i] - rec709[i]) < 1e-3f;
        unknown &= primaries[i] == 0;
    }
    if (same || unknown) return PRIMARIES_REC709;
    if (!(primaries[7] > 0) || !to_xyz(primaries, source) || !to_xyz(rec709, target) || !invert(target, back)) return PRIMARIES_BAD;
    adapt(primaries + 6, rec709 + 6, white);
    multiply(white, source, all);
    multiply(back, all, target);
    for (int i = 0; i < 9; i++) {
        out[i] = (float)target[i];
        if (!isfinite(out[i])) return PRIMARIES_BAD;
    }
    return PRIMARIES_OTHER;
}

void primaries_convert(const float matrix[9], float *pixels, size_t count) {
    for (size_t i = 0; i < count; i++, pixels += 4) {
        const float c[3] = {pixels[0], pixels[1], pixels[2]};
        for (int k = 0; k < 3; k++) pixels[k] = matrix[3 * k] * c[0] + matrix[3 * k + 1] * c[1] + matrix[3 * k + 2] * c[2];
    }
}
