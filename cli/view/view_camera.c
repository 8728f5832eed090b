/* SPDX-License-Identifier: MIT */
#include "view/view.h"

#include <math.h>

static fnl_vec3 add(fnl_vec3 a, fnl_vec3 b, float by) { return (fnl_vec3){a.x + b.x * by, a.y + b.y * by, a.z + b.z * by}; }
static float dot(fnl_vec3 a, fnl_vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static fnl_vec3 cross(fnl_vec3 a, fnl_vec3 b) { return (fnl_vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
static fnl_vec3 scale(fnl_vec3 v, float by) { return (fnl_vec3){v.x * by, v.y * by, v.z * by}; }
static fnl_vec3 normalize(fnl_vec3 v) {
    const float length = sqrtf(dot(v, v));
    return length > 0 ? scale(v, 1 / length) : (fnl_vec3){0, 0, -1};
}

/* Turns `v` about a unit axis, anticlockwise (Rodrigues' formula). */
static fnl_vec3 turn(fnl_vec3 v, fnl_vec3 axis, float angle) {
    const float c = cosf(angle), s = sinf(angle);
    return add(add(scale(v, c), cross(axis, v), s), axis, dot(axis, v) * (1 - c));
}

struct axes {
    fnl_vec3 right, up, forward;
    float distance;
};
static struct axes axes_of(const fnl_camera *c) {
    struct axes a;
    const fnl_vec3 to = add(c->target, c->position, -1);
    a.distance = sqrtf(dot(to, to));
    a.forward = normalize(to);
    a.right = normalize(cross(a.forward, c->up));
    a.up = cross(a.right, a.forward);
    return a;
}

/* The direction from a place, turned; it never passes the poles. */
static fnl_vec3 turned(const fnl_camera *c, fnl_vec3 direction, float right, float down) {
    const fnl_vec3 up = normalize(c->up);
    const float height = asinf(fmaxf(-1, fminf(1, dot(normalize(direction), up)))), most = 1.55f;
    const float wanted = fmaxf(-most, fminf(most, height + down));
    const fnl_vec3 side = normalize(cross(normalize(direction), up));
    return turn(turn(direction, side, wanted - height), up, -right);
}

void view_camera_orbit(struct view_camera *camera, float right, float down) {
    fnl_camera *c = &camera->now;
    const fnl_vec3 out = add(c->position, c->target, -1);
    c->position = add(c->target, turned(c, out, right, down), 1);
}

void view_camera_look(struct view_camera *camera, float right, float down) {
    fnl_camera *c = &camera->now;
    const fnl_vec3 to = add(c->target, c->position, -1);
    c->target = add(c->position, turned(c, to, right, -down), 1);
}

void view_camera_pan(struct view_camera *camera, float right, float down) {
    fnl_camera *c = &camera->now;
    const struct axes a = axes_of(c);
    const float height = c->orthographic ? c->vertical_extent : 2 * a.distance * tanf(c->vertical_fov / 2);
    const fnl_vec3 by = add(scale(a.right, -right * height), a.up, down * height);
    c->position = add(c->position, by, 1);
    c->target = add(c->target, by, 1);
}

void view_camera_dolly(struct view_camera *camera, float steps) {
    fnl_camera *c = &camera->now;
    const struct axes a = axes_of(c);
    const float most = 1e9f; /* meters: further away nothing is to be seen, and a frame would be refused */
    steps = fminf(fmaxf(steps, -200), 200);
    const float factor = powf(0.88f, steps);
    if (c->orthographic) {
        c->vertical_extent = fminf(fmaxf(c->vertical_extent * factor, 1e-4f), most);
        return;
    }
    /* Close to the target it is pushed along: one can always go on. */
    const float least = fmaxf(camera->size * 1e-3f, 2 * c->near_distance), distance = fminf(fmaxf(a.distance * factor, least), fmaxf(a.distance, most));
    c->position = add(c->target, a.forward, -distance);
    if (distance == least && steps > 0) view_camera_fly(camera, (fnl_vec3){0, 0, steps * least});
}

void view_camera_walk(struct view_camera *camera, fnl_vec3 metres) {
    fnl_camera *c = &camera->now;
    const struct axes a = axes_of(c);
    const fnl_vec3 up = normalize(c->up), ahead = normalize(cross(up, a.right));
    const fnl_vec3 by = add(add(scale(a.right, metres.x), up, metres.y), ahead, metres.z);
    c->position = add(c->position, by, 1);
    c->target = add(c->target, by, 1);
}

void view_camera_fly(struct view_camera *camera, fnl_vec3 metres) {
    fnl_camera *c = &camera->now;
    const struct axes a = axes_of(c);
    const fnl_vec3 by = add(add(scale(a.right, metres.x), a.up, metres.y), a.forward, metres.z);
    c->position = add(c->position, by, 1);
    c->target = add(c->target, by, 1);
}
