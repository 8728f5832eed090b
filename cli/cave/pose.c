/* SPDX-License-Identifier: MIT */
#include "cave/pose.h"

#include <math.h>

struct cave_vector cave_subtract(struct cave_vector a, struct cave_vector b) { return (struct cave_vector){a.x - b.x, a.y - b.y, a.z - b.z}; }

struct cave_vector cave_add_scaled(struct cave_vector a, struct cave_vector b, double factor) {
    return (struct cave_vector){a.x + b.x * factor, a.y + b.y * factor, a.z + b.z * factor};
}

double cave_dot(struct cave_vector a, struct cave_vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

struct cave_vector cave_cross(struct cave_vector a, struct cave_vector b) {
    return (struct cave_vector){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

double cave_length(struct cave_vector v) { return sqrt(cave_dot(v, v)); }

struct cave_quaternion cave_quaternion_product(struct cave_quaternion a, struct cave_quaternion b) {
    return (struct cave_quaternion){a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
                                    a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}

struct cave_vector cave_rotate(struct cave_quaternion q, struct cave_vector v) {
    const struct cave_vector axis = {q.x, q.y, q.z}, twice = cave_cross(axis, cave_add_scaled(cave_cross(axis, v), v, q.w));
    return cave_add_scaled(v, twice, 2);
}

struct cave_quaternion cave_turn(double angle) { return (struct cave_quaternion){0, sin(angle / 2), 0, cos(angle / 2)}; }

struct cave_pose cave_mix(const struct cave_pose *a, const struct cave_pose *b, double part) {
    const struct cave_quaternion p = a->rotation;
    struct cave_quaternion q = b->rotation;
    double cosine = p.x * q.x + p.y * q.y + p.z * q.z + p.w * q.w;
    if (cosine < 0) {
        q = (struct cave_quaternion){-q.x, -q.y, -q.z, -q.w};
        cosine = -cosine;
    }
    double first = 1 - part, second = part;
    if (cosine < 0.9999) {
        const double angle = acos(cosine);
        first = sin((1 - part) * angle) / sin(angle);
        second = sin(part * angle) / sin(angle);
    }
    struct cave_quaternion r = {p.x * first + q.x * second, p.y * first + q.y * second, p.z * first + q.z * second, p.w * first + q.w * second};
    const double length = sqrt(r.x * r.x + r.y * r.y + r.z * r.z + r.w * r.w);
    r = (struct cave_quaternion){r.x / length, r.y / length, r.z / length, r.w / length};
    return (struct cave_pose){cave_add_scaled(a->position, cave_subtract(b->position, a->position), part), r};
}

struct cave_vector cave_placed(const struct cave_place *place, struct cave_vector v) {
    return cave_add_scaled(place->pose.position, cave_rotate(place->pose.rotation, v), place->scale);
}

/* The rotation that takes X, Y and Z to three unit vectors that stand upright on one another. */
static fnl_vec4 rotation_of(struct cave_vector x, struct cave_vector y, struct cave_vector z) {
    const double squares[4] = {1 + x.x - y.y - z.z, 1 - x.x + y.y - z.z, 1 - x.x - y.y + z.z, 1 + x.x + y.y + z.z};
    int largest = 0; /* four times the square of x, y, z or w: dividing by it loses least */
    for (int i = 1; i < 4; i++)
        if (squares[i] > squares[largest]) largest = i;
    const double four = 2 * sqrt(squares[largest]), m = four / 4;
    const double a = (y.z - z.y) / four, b = (z.x - x.z) / four, c = (x.y - y.x) / four; /* products with w */
    const double d = (x.y + y.x) / four, e = (x.z + z.x) / four, f = (y.z + z.y) / four; /* x y, x z, y z */
    const double all[4][4] = {{m, d, e, a}, {d, m, f, b}, {e, f, m, c}, {a, b, c, m}}, *q = all[largest];
    return (fnl_vec4){(float)q[0], (float)q[1], (float)q[2], (float)q[3]};
}

bool cave_look_through(struct cave_vector lower_left, struct cave_vector lower_right, struct cave_vector upper_left, struct cave_vector eye, fnl_eye *out,
                       double *out_distance) {
    struct cave_vector right = cave_subtract(lower_right, lower_left), up = cave_subtract(upper_left, lower_left);
    const double width = cave_length(right), height = cave_length(up);
    right = (struct cave_vector){right.x / width, right.y / width, right.z / width};
    up = (struct cave_vector){up.x / height, up.y / height, up.z / height};
    const struct cave_vector normal = cave_cross(right, up), corner = cave_subtract(lower_left, eye);
    const double distance = -cave_dot(normal, corner), left = cave_dot(right, corner), down = cave_dot(up, corner);
    if (out_distance) *out_distance = distance;
    const double farthest = fmax(fmax(fabs(left), fabs(left + width)), fmax(fabs(down), fabs(down + height)));
    if (!(distance > 0) || farthest > 573 * distance) return false;
    *out = (fnl_eye){{{(float)eye.x, (float)eye.y, (float)eye.z}, rotation_of(right, up, normal)},
                     (float)(left / distance),
                     (float)((left + width) / distance),
                     (float)(down / distance),
                     (float)((down + height) / distance)};
    return true;
}
