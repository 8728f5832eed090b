/* SPDX-License-Identifier: MIT */
/** Vectors, matrices and where a camera shows things, for what is drawn over the picture and dragged in it. */
#ifndef FNL_CLI_VIEW_MATHS_H
#define FNL_CLI_VIEW_MATHS_H

#include "fanal/camera.h"

#include <math.h>
#include <string.h>

static inline fnl_vec3 maths_add(fnl_vec3 a, fnl_vec3 b, float by) { return (fnl_vec3){a.x + b.x * by, a.y + b.y * by, a.z + b.z * by}; }
static inline fnl_vec3 maths_scale(fnl_vec3 v, float by) { return (fnl_vec3){v.x * by, v.y * by, v.z * by}; }
static inline float maths_dot(fnl_vec3 a, fnl_vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline fnl_vec3 maths_cross(fnl_vec3 a, fnl_vec3 b) { return (fnl_vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
static inline float maths_length(fnl_vec3 v) { return sqrtf(maths_dot(v, v)); }
static inline fnl_vec3 maths_unit(fnl_vec3 v) {
    const float length = maths_length(v);
    return length > 0 ? maths_scale(v, 1 / length) : (fnl_vec3){0, 0, -1};
}
static inline fnl_vec3 maths_axis(int axis) { return (fnl_vec3){axis == 0, axis == 1, axis == 2}; }
/** Two unit vectors at right angles to a unit one and to each other; they follow each other anticlockwise round it. */
static inline void maths_beside(fnl_vec3 axis, fnl_vec3 out[2]) {
    out[0] = maths_unit(maths_cross(fabsf(axis.y) < 0.9f ? (fnl_vec3){0, 1, 0} : (fnl_vec3){0, 0, 1}, axis));
    out[1] = maths_cross(axis, out[0]);
}

static inline fnl_mat4 maths_identity(void) { return (fnl_mat4){{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}; }
static inline fnl_vec3 maths_point(const fnl_mat4 *m, fnl_vec3 p) {
    return (fnl_vec3){m->m[0] * p.x + m->m[4] * p.y + m->m[8] * p.z + m->m[12], m->m[1] * p.x + m->m[5] * p.y + m->m[9] * p.z + m->m[13],
                      m->m[2] * p.x + m->m[6] * p.y + m->m[10] * p.z + m->m[14]};
}
static inline fnl_vec3 maths_direction(const fnl_mat4 *m, fnl_vec3 d) {
    return (fnl_vec3){m->m[0] * d.x + m->m[4] * d.y + m->m[8] * d.z, m->m[1] * d.x + m->m[5] * d.y + m->m[9] * d.z,
                      m->m[2] * d.x + m->m[6] * d.y + m->m[10] * d.z};
}
static inline fnl_vec3 maths_column(const fnl_mat4 *m, int i) { return (fnl_vec3){m->m[4 * i], m->m[4 * i + 1], m->m[4 * i + 2]}; }
static inline fnl_mat4 maths_columns(fnl_vec3 x, fnl_vec3 y, fnl_vec3 z, fnl_vec3 place) {
    return (fnl_mat4){{x.x, x.y, x.z, 0, y.x, y.y, y.z, 0, z.x, z.y, z.z, 0, place.x, place.y, place.z, 1}};
}
/** Of affine matrices. */
static inline fnl_mat4 maths_multiply(const fnl_mat4 *a, const fnl_mat4 *b) {
    return maths_columns(maths_direction(a, maths_column(b, 0)), maths_direction(a, maths_column(b, 1)), maths_direction(a, maths_column(b, 2)),
                         maths_point(a, maths_column(b, 3)));
}
static inline float maths_determinant(const fnl_mat4 *m) { return maths_dot(maths_column(m, 0), maths_cross(maths_column(m, 1), maths_column(m, 2))); }
/** False: it has none. */
static inline bool maths_inverse(const fnl_mat4 *m, fnl_mat4 *out) {
    const fnl_vec3 x = maths_column(m, 0), y = maths_column(m, 1), z = maths_column(m, 2), yz = maths_cross(y, z), zx = maths_cross(z, x), xy = maths_cross(x, y);
    const float by = 1 / maths_dot(x, yz);
    if (!isfinite(by)) return false;
    *out = maths_columns((fnl_vec3){yz.x * by, zx.x * by, xy.x * by}, (fnl_vec3){yz.y * by, zx.y * by, xy.y * by}, (fnl_vec3){yz.z * by, zx.z * by, xy.z * by},
                         (fnl_vec3){0, 0, 0});
    const fnl_vec3 place = maths_direction(out, maths_column(m, 3));
    out->m[12] = -place.x, out->m[13] = -place.y, out->m[14] = -place.z;
    return true;
}
/** Turns about a line through `center` along a unit axis, anticlockwise (Rodrigues' formula). */
static inline fnl_mat4 maths_turn(fnl_vec3 center, fnl_vec3 axis, float angle) {
    const float c = cosf(angle), s = sinf(angle);
    fnl_vec3 columns[3];
    for (int i = 0; i < 3; i++) {
        const fnl_vec3 v = maths_axis(i);
        columns[i] = maths_add(maths_add(maths_scale(v, c), maths_cross(axis, v), s), axis, maths_dot(axis, v) * (1 - c));
    }
    fnl_mat4 m = maths_columns(columns[0], columns[1], columns[2], (fnl_vec3){0, 0, 0});
    const fnl_vec3 moved = maths_direction(&m, center);
    m.m[12] = center.x - moved.x, m.m[13] = center.y - moved.y, m.m[14] = center.z - moved.z;
    return m;
}

/** Translation, rotation about x, then y, then z (radians), scale. */
struct maths_parts {
    fnl_vec3 place, turn, scale;
};
static inline fnl_mat4 maths_compose(const struct maths_parts *p) {
    const fnl_vec3 zero = {0, 0, 0};
    const fnl_mat4 x = maths_turn(zero, maths_axis(0), p->turn.x), y = maths_turn(zero, maths_axis(1), p->turn.y), z = maths_turn(zero, maths_axis(2), p->turn.z),
                   yx = maths_multiply(&y, &x), r = maths_multiply(&z, &yx);
    return maths_columns(maths_scale(maths_column(&r, 0), p->scale.x), maths_scale(maths_column(&r, 1), p->scale.y), maths_scale(maths_column(&r, 2), p->scale.z),
                         p->place);
}
/** False: it shears too, and parts cannot say it. */
static inline bool maths_part(const fnl_mat4 *m, struct maths_parts *out) {
    fnl_vec3 axes[3];
    float *scale[3] = {&out->scale.x, &out->scale.y, &out->scale.z}, largest = 0, worst = 0;
    out->place = maths_column(m, 3);
    for (int i = 0; i < 3; i++) {
        *scale[i] = maths_length(maths_column(m, i));
        if (i == 0 && maths_determinant(m) < 0) *scale[i] = -*scale[i];
        if (!(fabsf(*scale[i]) > 0)) return false;
        axes[i] = maths_scale(maths_column(m, i), 1 / *scale[i]);
    }
    out->turn.y = asinf(fmaxf(-1, fminf(1, 0 - axes[0].z))); /* 0 -: not -0 */
    out->turn.x = atan2f(axes[1].z, axes[2].z);
    out->turn.z = atan2f(axes[0].y, axes[0].x);
    if (fabsf(axes[0].z) > 0.99999f) { /* turned about y by a quarter: x and z are one */
        out->turn.x = 0;
        out->turn.z = atan2f(0 - axes[1].x, axes[1].y);
    }
    const fnl_mat4 again = maths_compose(out);
    for (int i = 0; i < 12; i++) {
        largest = fmaxf(largest, fabsf(m->m[i]));
        worst = fmaxf(worst, fabsf(m->m[i] - again.m[i]));
    }
    return worst <= 1e-3f * largest;
}

/** How a camera shows the world in a picture of this size. */
struct maths_eye {
    fnl_camera camera;
    fnl_vec3 right, up, forward;
    float width, height, pixels; /* per metre: at depth 1, or anywhere where it is orthographic */
};
static inline struct maths_eye maths_eye(const fnl_camera *camera, uint32_t width, uint32_t height) {
    struct maths_eye e = {.camera = *camera, .width = (float)width, .height = (float)height};
    e.forward = maths_unit(maths_add(camera->target, camera->position, -1));
    e.right = maths_unit(maths_cross(e.forward, camera->up));
    e.up = maths_cross(e.right, e.forward);
    e.pixels = e.height / (camera->orthographic ? camera->vertical_extent : 2 * tanf(camera->vertical_fov / 2));
    return e;
}
static inline float maths_depth(const struct maths_eye *e, fnl_vec3 point) { return maths_dot(maths_add(point, e->camera.position, -1), e->forward); }
/** Pixels per metre at a depth. */
static inline float maths_pixels(const struct maths_eye *e, float depth) { return e->camera.orthographic ? e->pixels : e->pixels / depth; }
/** Where a point is shown; false: nowhere, as it is nearer than the camera sees. */
static inline bool maths_project(const struct maths_eye *e, fnl_vec3 point, fnl_vec2 *out) {
    const fnl_vec3 from = maths_add(point, e->camera.position, -1);
    const float depth = maths_dot(from, e->forward), pixels = maths_pixels(e, depth);
    if (depth < e->camera.near_distance) return false;
    *out = (fnl_vec2){e->width * (0.5f + e->camera.shift.x / 2) + maths_dot(from, e->right) * pixels,
                      e->height * (0.5f - e->camera.shift.y / 2) - maths_dot(from, e->up) * pixels};
    return true;
}
/** What a place in the picture looks along. */
static inline void maths_ray(const struct maths_eye *e, fnl_vec2 at, fnl_vec3 *origin, fnl_vec3 *direction) {
    const float x = (at.x - e->width * (0.5f + e->camera.shift.x / 2)) / e->pixels, y = (e->height * (0.5f - e->camera.shift.y / 2) - at.y) / e->pixels;
    const fnl_vec3 across = maths_add(maths_scale(e->right, x), e->up, y);
    *origin = e->camera.orthographic ? maths_add(e->camera.position, across, 1) : e->camera.position;
    *direction = e->camera.orthographic ? e->forward : maths_unit(maths_add(e->forward, across, 1));
}

#endif
