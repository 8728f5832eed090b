/* SPDX-License-Identifier: MIT */
/** Vectors, matrices and quaternions. Right-handed, +Y up, column-major, column vectors, radians. */
#ifndef FNL_BASE_MATHS_H
#define FNL_BASE_MATHS_H

#include "fanal/base.h"

#include <float.h>
#include <math.h>

typedef fnl_vec2 vec2;
typedef fnl_vec3 vec3;
typedef fnl_vec4 vec4;
typedef fnl_mat4 mat4;
/** Rotation quaternion x, y, z, w, as glTF stores it. */
typedef fnl_vec4 quat;

#define PI 3.14159265358979323846f

/** IEC 61966-2-1, 0 .. 1. */
static inline float decode_srgb(float x) { return x <= 0.04045f ? x / 12.92f : powf((x + 0.055f) / 1.055f, 2.4f); }
/** 0 .. 1 as 0 .. 255, clamped. */
static inline uint8_t encode_byte(float x) { return (uint8_t)((x > 0 ? x < 1 ? x : 1 : 0) * 255 + 0.5f); }
static inline float encode_srgb(float x) { return x <= 0.0031308f ? 12.92f * x : 1.055f * powf(x, 1 / 2.4f) - 0.055f; }

static inline vec2 vec2_make(float x, float y) { return (vec2){x, y}; }
static inline vec3 vec3_make(float x, float y, float z) { return (vec3){x, y, z}; }
static inline vec4 vec4_make(float x, float y, float z, float w) { return (vec4){x, y, z, w}; }

static inline vec3 vec3_add(vec3 a, vec3 b) { return (vec3){a.x + b.x, a.y + b.y, a.z + b.z}; }
static inline vec3 vec3_sub(vec3 a, vec3 b) { return (vec3){a.x - b.x, a.y - b.y, a.z - b.z}; }
static inline vec3 vec3_mul(vec3 a, vec3 b) { return (vec3){a.x * b.x, a.y * b.y, a.z * b.z}; }
static inline vec3 vec3_scale(vec3 a, float s) { return (vec3){a.x * s, a.y * s, a.z * s}; }
/** a + b * s */
static inline vec3 vec3_add_scaled(vec3 a, vec3 b, float s) { return (vec3){a.x + b.x * s, a.y + b.y * s, a.z + b.z * s}; }
static inline vec3 vec3_min(vec3 a, vec3 b) { return (vec3){fminf(a.x, b.x), fminf(a.y, b.y), fminf(a.z, b.z)}; }
static inline vec3 vec3_max(vec3 a, vec3 b) { return (vec3){fmaxf(a.x, b.x), fmaxf(a.y, b.y), fmaxf(a.z, b.z)}; }
static inline vec3 vec3_lerp(vec3 a, vec3 b, float t) {
    return (vec3){a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t, a.z + (b.z - a.z) * t};
}
static inline float vec3_dot(vec3 a, vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline vec3 vec3_cross(vec3 a, vec3 b) {
    return (vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static inline float vec3_length(vec3 a) { return sqrtf(vec3_dot(a, a)); }
static inline float vec3_distance(vec3 a, vec3 b) { return vec3_length(vec3_sub(a, b)); }
/** Whether the square of a length is good to all digits: floats have no room for those of vectors beyond 1e19 or below 1e-19. */
static inline bool square_in_range(float square) { return square > 1e-30f && square < 1e30f; }
/** vec3_normalize and quat_normalize of vectors whose square is not. */
vec3 vec3_normalize_extreme(vec3 a);
fnl_vec4 quat_normalize_extreme(fnl_vec4 q);
/** The zero vector stays zero. */
static inline vec3 vec3_normalize(vec3 a) {
    const float square = vec3_dot(a, a);
    return square_in_range(square) ? vec3_scale(a, 1 / sqrtf(square)) : vec3_normalize_extreme(a);
}
static inline bool vec3_finite(vec3 a) { return isfinite(a.x) && isfinite(a.y) && isfinite(a.z); }
/** Any unit vector at right angles to a unit vector. */
static inline vec3 vec3_perpendicular(vec3 n) {
    vec3 other = fabsf(n.x) < 0.9f ? (vec3){1, 0, 0} : (vec3){0, 1, 0};
    return vec3_normalize(vec3_cross(n, other));
}

static inline mat4 mat4_identity(void) { return (mat4){{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}; }
static inline mat4 mat4_mul(mat4 a, mat4 b) {
    mat4 r;
    for (int column = 0; column < 4; column++)
        for (int row = 0; row < 4; row++) {
            float sum = 0;
            for (int k = 0; k < 4; k++) sum += a.m[k * 4 + row] * b.m[column * 4 + k];
            r.m[column * 4 + row] = sum;
        }
    return r;
}
static inline vec4 mat4_mul_vec4(const mat4 *a, vec4 v) {
    const float *m = a->m;
    return (vec4){m[0] * v.x + m[4] * v.y + m[8] * v.z + m[12] * v.w, m[1] * v.x + m[5] * v.y + m[9] * v.z + m[13] * v.w,
                  m[2] * v.x + m[6] * v.y + m[10] * v.z + m[14] * v.w, m[3] * v.x + m[7] * v.y + m[11] * v.z + m[15] * v.w};
}
/** Affine transform of a point. */
static inline vec3 mat4_point(const mat4 *a, vec3 p) {
    const float *m = a->m;
    return (vec3){m[0] * p.x + m[4] * p.y + m[8] * p.z + m[12], m[1] * p.x + m[5] * p.y + m[9] * p.z + m[13],
                  m[2] * p.x + m[6] * p.y + m[10] * p.z + m[14]};
}
static inline vec3 mat4_direction(const mat4 *a, vec3 d) {
    const float *m = a->m;
    return (vec3){m[0] * d.x + m[4] * d.y + m[8] * d.z, m[1] * d.x + m[5] * d.y + m[9] * d.z,
                  m[2] * d.x + m[6] * d.y + m[10] * d.z};
}
static inline mat4 mat4_translation(vec3 t) { return (mat4){{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, t.x, t.y, t.z, 1}}; }
static inline mat4 mat4_scaling(vec3 s) { return (mat4){{s.x, 0, 0, 0, 0, s.y, 0, 0, 0, 0, s.z, 0, 0, 0, 0, 1}}; }

static inline quat quat_identity(void) { return (quat){0, 0, 0, 1}; }
/** Rotation by `angle` radians about a unit axis. */
static inline quat quat_axis_angle(vec3 axis, float angle) {
    float s = sinf(angle * 0.5f);
    return (quat){axis.x * s, axis.y * s, axis.z * s, cosf(angle * 0.5f)};
}
static inline quat quat_normalize(quat q) {
    const float square = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w, length = sqrtf(square);
    return square_in_range(square) ? (quat){q.x / length, q.y / length, q.z / length, q.w / length} : quat_normalize_extreme(q);
}

/** Rotates by `b`, then by `a`. */
static inline quat quat_mul(quat a, quat b) {
    return (quat){a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
                  a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}

/** translation * rotation * scale */
mat4 mat4_from_trs(vec3 translation, quat rotation, vec3 scale);
/** Inverse of any invertible matrix; the identity when it has none (false is returned). */
bool mat4_inverse(const mat4 *matrix, mat4 *out);
/** Determinant of the upper-left 3x3: negative when the matrix mirrors. */
float mat4_determinant3(const mat4 *matrix);
/** World-to-view matrix of a camera at `eye` that looks at `target`: view space looks down -Z. */
mat4 mat4_look_at(vec3 eye, vec3 target, vec3 up);
/** Shortest-path spherical interpolation. */
quat quat_slerp(quat a, quat b, float t);

/**
 * Affine transform in doubles, for positions too distant for floats: the three columns of the linear part, then the
 * translation.
 */
struct affine {
    double m[12];
};
/** 0, 0, 0: for matrices that are relative to no origin. */
extern const double no_origin[3];
struct affine affine_identity(void);
struct affine affine_mul(const struct affine *a, const struct affine *b);
/** translation * rotation * scale; the quaternion is normalized. */
struct affine affine_from_trs(const double translation[3], const double rotation[4], const double scale[3]);
/** Converts the affine part of a matrix whose translation is relative to `origin`, and back. */
struct affine affine_from_mat4(const mat4 *matrix, const double origin[3]);
mat4 mat4_from_affine(const struct affine *affine, const double origin[3]);
/** Converts a place to a point relative to `origin`, and back. */
static inline vec3 vec3_from_place(const double place[3], const double origin[3]) {
    return (vec3){(float)(place[0] - origin[0]), (float)(place[1] - origin[1]), (float)(place[2] - origin[2])};
}
static inline void place_from_vec3(vec3 point, const double origin[3], double place[3]) {
    place[0] = origin[0] + (double)point.x;
    place[1] = origin[1] + (double)point.y;
    place[2] = origin[2] + (double)point.z;
}

/** Axis-aligned box; empty when low > high. */
struct box {
    vec3 low, high;
};
static inline struct box box_empty(void) {
    return (struct box){{FLT_MAX, FLT_MAX, FLT_MAX}, {-FLT_MAX, -FLT_MAX, -FLT_MAX}};
}
static inline bool box_is_empty(const struct box *b) { return b->low.x > b->high.x; }
static inline void box_add_point(struct box *b, vec3 p) {
    b->low = vec3_min(b->low, p);
    b->high = vec3_max(b->high, p);
}
static inline void box_add_box(struct box *b, const struct box *other) {
    b->low = vec3_min(b->low, other->low);
    b->high = vec3_max(b->high, other->high);
}
/** Box of an affinely transformed box. */
struct box box_transform(const struct box *b, const mat4 *matrix);

/** IEEE binary16 of a float, rounded to nearest even, overflow to infinity. */
uint16_t half_from_float(float value);
float half_to_float(uint16_t half);

/** Unit vector to octahedral coordinates in [-1, 1]^2 (Meyer et al. 2010). The zero vector maps to +Z. */
vec2 octahedral_encode(vec3 n);
vec3 octahedral_decode(vec2 e);

/** Where frame `index` of a sequence samples pixels: right of and below their centres, pixels, in [-0.5, 0.5). Halton's sequence in bases 2
    and 3, moved so that frame 0 samples the centres. */
vec2 pixel_jitter(uint32_t index);

#endif
