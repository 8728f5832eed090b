/* SPDX-License-Identifier: MIT */
/** Vectors of doubles. */
#ifndef FNL_RAY_DVEC_H
#define FNL_RAY_DVEC_H

#include "base/maths.h"

typedef struct dvec3 {
    double x, y, z;
} dvec3;

static inline dvec3 dvec3_make(double x, double y, double z) { return (dvec3){x, y, z}; }
static inline dvec3 dvec3_from(vec3 v) { return (dvec3){(double)v.x, (double)v.y, (double)v.z}; }
static inline dvec3 dvec3_add(dvec3 a, dvec3 b) { return (dvec3){a.x + b.x, a.y + b.y, a.z + b.z}; }
static inline dvec3 dvec3_sub(dvec3 a, dvec3 b) { return (dvec3){a.x - b.x, a.y - b.y, a.z - b.z}; }
static inline dvec3 dvec3_mul(dvec3 a, dvec3 b) { return (dvec3){a.x * b.x, a.y * b.y, a.z * b.z}; }
static inline dvec3 dvec3_scale(dvec3 a, double s) { return (dvec3){a.x * s, a.y * s, a.z * s}; }
/** a + b * s */
static inline dvec3 dvec3_add_scaled(dvec3 a, dvec3 b, double s) {
    return (dvec3){a.x + b.x * s, a.y + b.y * s, a.z + b.z * s};
}
static inline dvec3 dvec3_lerp(dvec3 a, dvec3 b, double t) { return dvec3_add_scaled(a, dvec3_sub(b, a), t); }
static inline double dvec3_dot(dvec3 a, dvec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline dvec3 dvec3_cross(dvec3 a, dvec3 b) {
    return (dvec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static inline double dvec3_length(dvec3 a) { return sqrt(dvec3_dot(a, a)); }
static inline double dvec3_max(dvec3 a) { return fmax(a.x, fmax(a.y, a.z)); }
/** Of the greatest component, whatever its sign. */
static inline double dvec3_reach(dvec3 a) { return fmax(fabs(a.x), fmax(fabs(a.y), fabs(a.z))); }
/** Rec. 709 weights. */
static inline double dvec3_luminance(dvec3 c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }
/** The zero vector stays zero. */
static inline dvec3 dvec3_normalize(dvec3 a) {
    double length = dvec3_length(a);
    return length > 0 ? dvec3_scale(a, 1 / length) : a;
}
/** `v` in the axes `side`, `up` and `along`, to the world. */
static inline dvec3 dvec3_combine(dvec3 side, dvec3 up, dvec3 along, dvec3 v) {
    return dvec3_add_scaled(dvec3_add_scaled(dvec3_scale(side, v.x), up, v.y), along, v.z);
}
/** Two unit vectors at right angles to a unit vector and to one another (Duff et al., "Building an Orthonormal Basis, Revisited", 2017). */
static inline void dvec3_basis(dvec3 n, dvec3 *side, dvec3 *up) {
    double sign = copysign(1, n.z), a = -1 / (sign + n.z), b = n.x * n.y * a;
    *side = (dvec3){1 + sign * n.x * n.x * a, sign * b, -sign * n.x};
    *up = (dvec3){b, sign + n.y * n.y * a, -n.y};
}
static inline double clamp01(double x) { return fmin(fmax(x, 0), 1); }

#define DPI 3.14159265358979323846

#endif
