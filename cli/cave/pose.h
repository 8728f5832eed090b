/* SPDX-License-Identifier: MIT */
/** Places and directions in double precision, and what an eye sees through a wall. */
#ifndef FNL_CLI_CAVE_POSE_H
#define FNL_CLI_CAVE_POSE_H

#include "fanal/fanal.h"

struct cave_vector {
    double x, y, z;
};
struct cave_quaternion {
    double x, y, z, w;
};
/** Without rotation +X is right, +Y up and -Z ahead. */
struct cave_pose {
    struct cave_vector position; /* metres */
    struct cave_quaternion rotation;
};
/** Of one space in another: x becomes position + rotation * (scale * x). */
struct cave_place {
    struct cave_pose pose;
    double scale;
};

struct cave_vector cave_subtract(struct cave_vector a, struct cave_vector b);
struct cave_vector cave_add_scaled(struct cave_vector a, struct cave_vector b, double factor);
double cave_dot(struct cave_vector a, struct cave_vector b);
struct cave_vector cave_cross(struct cave_vector a, struct cave_vector b);
double cave_length(struct cave_vector v);
struct cave_quaternion cave_quaternion_product(struct cave_quaternion a, struct cave_quaternion b);
struct cave_vector cave_rotate(struct cave_quaternion q, struct cave_vector v);
/** About +Y, radians. */
struct cave_quaternion cave_turn(double angle);
/** Between two poses, part 0 .. 1: places along a line, rotations along the shorter arc. */
struct cave_pose cave_mix(const struct cave_pose *a, const struct cave_pose *b, double part);
/** A point of the placed space in the outer one. */
struct cave_vector cave_placed(const struct cave_place *place, struct cave_vector v);

/**
 * What an eye sees through a wall with these three corners: an fnl_eye that looks along the wall's normal, whatever the head does, with the edges of
 * the wall as those of its picture (R. Kooima, Generalized perspective projection, 2009). `out_distance` (or NULL): metres from the eye to the wall's
 * plane, above 0 in front of it. False where the wall cannot be seen from there: on the plane or behind it, or at an angle beyond 89.9 degrees.
 */
bool cave_look_through(struct cave_vector lower_left, struct cave_vector lower_right, struct cave_vector upper_left, struct cave_vector eye, fnl_eye *out,
                       double *out_distance);

#endif
