/* SPDX-License-Identifier: MIT */
#ifndef FNL_CLI_XR_MATHS_H
#define FNL_CLI_XR_MATHS_H

#include "fanal/stereo.h"

#include <math.h>

static inline fnl_vec4 quat_mul(fnl_vec4 a, fnl_vec4 b) {
    return (fnl_vec4){a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
                      a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}

static inline fnl_vec4 quat_inverse(fnl_vec4 q) { return (fnl_vec4){-q.x, -q.y, -q.z, q.w}; }

static inline fnl_vec3 quat_turn(fnl_vec4 q, fnl_vec3 v) {
    const fnl_vec4 r = quat_mul(quat_mul(q, (fnl_vec4){v.x, v.y, v.z, 0}), quat_inverse(q));
    return (fnl_vec3){r.x, r.y, r.z};
}

static inline fnl_vec4 quat_yaw(float angle) { return (fnl_vec4){0, sinf(angle / 2), 0, cosf(angle / 2)}; }

static inline fnl_vec3 add3(fnl_vec3 a, fnl_vec3 b) { return (fnl_vec3){a.x + b.x, a.y + b.y, a.z + b.z}; }
static inline fnl_vec3 sub3(fnl_vec3 a, fnl_vec3 b) { return (fnl_vec3){a.x - b.x, a.y - b.y, a.z - b.z}; }
static inline fnl_vec3 scale3(fnl_vec3 a, float s) { return (fnl_vec3){a.x * s, a.y * s, a.z * s}; }
static inline float dot3(fnl_vec3 a, fnl_vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

static inline fnl_rigid_pose pose_mul(const fnl_rigid_pose *a, const fnl_rigid_pose *b) {
    return (fnl_rigid_pose){add3(a->position, quat_turn(a->rotation, b->position)), quat_mul(a->rotation, b->rotation)};
}

/** The angle about +Y of where a rotation looks; 0 looks at -Z. */
static inline float yaw_of(fnl_vec4 rotation) {
    const fnl_vec3 ahead = quat_turn(rotation, (fnl_vec3){0, 0, -1});
    return atan2f(-ahead.x, -ahead.z);
}

/** The angle between two rotations, radians. */
static inline float angle_between(fnl_vec4 a, fnl_vec4 b) {
    const fnl_vec4 d = quat_mul(quat_inverse(a), b);
    return 2 * asinf(fminf(1, sqrtf(d.x * d.x + d.y * d.y + d.z * d.z)));
}

#endif
