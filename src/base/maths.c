/* SPDX-License-Identifier: MIT */
#include "base/maths.h"

#include "base/base.h"

vec3 vec3_normalize_extreme(vec3 a) {
    const double x = (double)a.x, y = (double)a.y, z = (double)a.z, length = sqrt(x * x + y * y + z * z);
    return length > 0 && length < INFINITY ? (vec3){(float)(x / length), (float)(y / length), (float)(z / length)} : (vec3){0, 0, 0};
}

quat quat_normalize_extreme(quat q) {
    const double x = (double)q.x, y = (double)q.y, z = (double)q.z, w = (double)q.w, length = sqrt(x * x + y * y + z * z + w * w);
    return length > 0 && length < INFINITY ? (quat){(float)(x / length), (float)(y / length), (float)(z / length), (float)(w / length)} : quat_identity();
}

mat4 mat4_from_trs(vec3 t, quat q, vec3 s) {
    float xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z, xy = q.x * q.y, xz = q.x * q.z, yz = q.y * q.z;
    float wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
    return (mat4){{(1 - 2 * (yy + zz)) * s.x, 2 * (xy + wz) * s.x, 2 * (xz - wy) * s.x, 0, 2 * (xy - wz) * s.y,
                   (1 - 2 * (xx + zz)) * s.y, 2 * (yz + wx) * s.y, 0, 2 * (xz + wy) * s.z, 2 * (yz - wx) * s.z,
                   (1 - 2 * (xx + yy)) * s.z, 0, t.x, t.y, t.z, 1}};
}

const double no_origin[3] = {0, 0, 0};

struct affine affine_identity(void) { return (struct affine){{1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}}; }

struct affine affine_mul(const struct affine *a, const struct affine *b) {
    struct affine r;
    for (int column = 0; column < 4; column++)
        for (int row = 0; row < 3; row++) {
            const double *v = b->m + 3 * column;
            const double sum = a->m[row] * v[0] + a->m[3 + row] * v[1] + a->m[6 + row] * v[2];
            r.m[3 * column + row] = column < 3 ? sum : sum + a->m[9 + row];
        }
    return r;
}

struct affine affine_from_trs(const double t[3], const double rotation[4], const double s[3]) {
    double q[4] = {0, 0, 0, 1}, square = 0;
    for (int i = 0; i < 4; i++) square += rotation[i] * rotation[i];
    for (int i = 0; i < 4 && square > 0; i++) q[i] = rotation[i] / sqrt(square);
    const double xx = q[0] * q[0], yy = q[1] * q[1], zz = q[2] * q[2], xy = q[0] * q[1], xz = q[0] * q[2], yz = q[1] * q[2];
    const double wx = q[3] * q[0], wy = q[3] * q[1], wz = q[3] * q[2];
    return (struct affine){{(1 - 2 * (yy + zz)) * s[0], 2 * (xy + wz) * s[0], 2 * (xz - wy) * s[0], 2 * (xy - wz) * s[1],
                            (1 - 2 * (xx + zz)) * s[1], 2 * (yz + wx) * s[1], 2 * (xz + wy) * s[2], 2 * (yz - wx) * s[2],
                            (1 - 2 * (xx + yy)) * s[2], t[0], t[1], t[2]}};
}

struct affine affine_from_mat4(const mat4 *matrix, const double origin[3]) {
    struct affine r;
    for (int column = 0; column < 4; column++)
        for (int row = 0; row < 3; row++) r.m[3 * column + row] = (double)matrix->m[4 * column + row];
    for (int row = 0; row < 3; row++) r.m[9 + row] += origin[row];
    return r;
}

mat4 mat4_from_affine(const struct affine *a, const double origin[3]) {
    mat4 r = mat4_identity();
    for (int column = 0; column < 4; column++)
        for (int row = 0; row < 3; row++) r.m[4 * column + row] = (float)a->m[3 * column + row];
    for (int row = 0; row < 3; row++) r.m[12 + row] = (float)(a->m[9 + row] - origin[row]);
    return r;
}

bool mat4_inverse(const mat4 *matrix, mat4 *out) {
    /* Gauss-Jordan with row pivoting, in double so that far-away cameras keep their precision. */
    double a[4][8];
    for (int row = 0; row < 4; row++)
        for (int column = 0; column < 4; column++) {
            a[row][column] = (double)matrix->m[column * 4 + row];
            a[row][column + 4] = row == column;
        }
    for (int column = 0; column < 4; column++) {
        int pivot = column;
        for (int row = column + 1; row < 4; row++)
            if (fabs(a[row][column]) > fabs(a[pivot][column])) pivot = row;
        if (!(fabs(a[pivot][column]) > 0)) {
            *out = mat4_identity();
            return false;
        }
        for (int k = 0; k < 8; k++) {
            double swap = a[pivot][k];
            a[pivot][k] = a[column][k];
            a[column][k] = swap;
        }
        double scale = 1 / a[column][column];
        for (int k = 0; k < 8; k++) a[column][k] *= scale;
        for (int row = 0; row < 4; row++) {
            if (row == column) continue;
            double factor = a[row][column];
            for (int k = 0; k < 8; k++) a[row][k] -= factor * a[column][k];
        }
    }
    for (int row = 0; row < 4; row++)
        for (int column = 0; column < 4; column++) out->m[column * 4 + row] = (float)a[row][column + 4];
    return true;
}

float mat4_determinant3(const mat4 *a) {
    const float *m = a->m;
    return m[0] * (m[5] * m[10] - m[9] * m[6]) - m[4] * (m[1] * m[10] - m[9] * m[2]) + m[8] * (m[1] * m[6] - m[5] * m[2]);
}

mat4 mat4_look_at(vec3 eye, vec3 target, vec3 up) {
    vec3 back = vec3_normalize(vec3_sub(eye, target));
    if (vec3_dot(back, back) == 0) back = (vec3){0, 0, 1};
    vec3 right = vec3_cross(up, back);
    if (vec3_dot(right, right) < 1e-12f) right = vec3_perpendicular(back);
    right = vec3_normalize(right);
    vec3 above = vec3_cross(back, right);
    return (mat4){{right.x, above.x, back.x, 0, right.y, above.y, back.y, 0, right.z, above.z, back.z, 0,
                   -vec3_dot(right, eye), -vec3_dot(above, eye), -vec3_dot(back, eye), 1}};
}

quat quat_slerp(quat a, quat b, float t) {
    float d = a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w, sign = d < 0 ? -1.0f : 1.0f;
    d *= sign;
    float wa = 1 - t, wb = t;
    if (d < 0.9995f) {
        float angle = acosf(d), s = sinf(angle);
        wa = sinf(wa * angle) / s;
        wb = sinf(wb * angle) / s;
    }
    wb *= sign;
    return quat_normalize((quat){a.x * wa + b.x * wb, a.y * wa + b.y * wb, a.z * wa + b.z * wb, a.w * wa + b.w * wb});
}

struct box box_transform(const struct box *b, const mat4 *matrix) {
    if (box_is_empty(b)) return *b;
    struct box r = box_empty();
    for (int corner = 0; corner < 8; corner++) {
        vec3 p = {corner & 1 ? b->high.x : b->low.x, corner & 2 ? b->high.y : b->low.y, corner & 4 ? b->high.z : b->low.z};
        box_add_point(&r, mat4_point(matrix, p));
    }
    return r;
}

uint16_t half_from_float(float value) {
    uint32_t bits;
    memcpy(&bits, &value, 4);
    uint32_t sign = bits >> 16 & 0x8000u, magnitude = bits & 0x7fffffffu;
    if (magnitude > 0x7f800000u) return (uint16_t)(sign | 0x7e00u);
    if (magnitude >= 0x477ff000u) return (uint16_t)(sign | 0x7c00u); /* rounds to 65536 or more */
    if (magnitude < 0x38800000u) {                                   /* subnormal: let the float adder round */
        float shifted;
        memcpy(&shifted, &magnitude, 4);
        shifted += 0.5f;
        uint32_t out;
        memcpy(&out, &shifted, 4);
        return (uint16_t)(sign | (out - 0x3f000000u));
    }
    uint32_t odd = magnitude >> 13 & 1;
    return (uint16_t)(sign | ((magnitude - 0x38000000u + 0xfffu + odd) >> 13));
}

float half_to_float(uint16_t half) {
    uint32_t sign = (uint32_t)(half & 0x8000u) << 16, exponent = half >> 10 & 31, mantissa = half & 1023;
    uint32_t bits;
    if (exponent == 31) {
        bits = sign | 0x7f800000u | mantissa << 13;
    } else if (exponent == 0) {
        float value = (float)mantissa * 0x1p-24f;
        memcpy(&bits, &value, 4);
        bits |= sign;
    } else {
        bits = sign | (exponent + 112) << 23 | mantissa << 13;
    }
    float value;
    memcpy(&value, &bits, 4);
    return value;
}

vec2 octahedral_encode(vec3 n) {
    float sum = fabsf(n.x) + fabsf(n.y) + fabsf(n.z);
    if (!(sum > 0)) return (vec2){0, 0};
    float x = n.x / sum, y = n.y / sum;
    if (n.z < 0) {
        float folded = (1 - fabsf(y)) * (x < 0 ? -1.0f : 1.0f);
        y = (1 - fabsf(x)) * (y < 0 ? -1.0f : 1.0f);
        x = folded;
    }
    return (vec2){x, y};
}

vec3 octahedral_decode(vec2 e) {
    vec3 n = {e.x, e.y, 1 - fabsf(e.x) - fabsf(e.y)};
    if (n.z < 0) {
        float x = n.x;
        n.x = (1 - fabsf(n.y)) * (x < 0 ? -1.0f : 1.0f);
        n.y = (1 - fabsf(x)) * (n.y < 0 ? -1.0f : 1.0f);
    }
    return vec3_normalize(n);
}

/* ---- places in a pixel ---- */

static float radical_inverse(uint32_t index, uint32_t base) {
    double value = 0, digit = 1.0 / base;
    for (; index; index /= base, digit /= base) value += digit * (index % base);
    return (float)value;
}

vec2 pixel_jitter(uint32_t index) {
    /* The first point is (1/2, 1/3): y is turned by 1/6, and stays in the unit square. */
    uint32_t i = index % 4096 + 1;
    float y = radical_inverse(i, 3) + 1 / 6.0f;
    return (vec2){radical_inverse(i, 2) - 0.5f, (y < 1 ? y : y - 1) - 0.5f};
}
