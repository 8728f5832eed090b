/* SPDX-License-Identifier: MIT */
#include "stereo.h"

#include "print.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *stereo_kind_name(int index) {
    static const char *const names[] = {"side-by-side", "top-bottom", "anaglyph", "layers", "left", "right"};
    return index >= 0 && index < STEREO_RIGHT ? names[index] : NULL;
}

const char *stereo_problem(const struct stereo_options *o) {
    if (o->kind == STEREO_NONE && (o->hmd || !isnan(o->ipd))) return "--ipd and --hmd belong to --stereo KIND";
    return NULL;
}

/* Real-Time Rendering, 4th ed., chapter 21: where eyes of people are. */
static void lint(const struct stereo *s) {
    const float ipd = headset_ipd(&s->headset);
    if (ipd < 0.052f || ipd > 0.078f)
        fprintf(stderr, "fanal: warning: the eyes are %g mm apart, those of people 52 to 78 mm: the world looks %s than it is\n", (double)ipd * 1000,
                ipd < 0.052f ? "larger" : "smaller");
}

bool stereo_open(const struct stereo_options *options, bool quiet, struct stereo *out) {
    *out = (struct stereo){.options = *options};
    if (options->hmd && !headset_load(options->hmd, &out->headset)) return false;
    if (!options->hmd) {
        for (int i = 0; i < HEADSET_EYES; i++) out->headset.eyes[i].eye.pose.rotation.w = 1;
        headset_set_ipd(&out->headset, STEREO_IPD);
    }
    if (!isnan(options->ipd)) headset_set_ipd(&out->headset, options->ipd);
    if (!quiet) lint(out);
    return true;
}

void stereo_close(struct stereo *stereo) { headset_free(&stereo->headset); }

void stereo_size(const struct stereo *s, uint32_t *width, uint32_t *height) {
    const struct headset_eye *l = &s->headset.eyes[0], *r = &s->headset.eyes[1];
    if (!l->width) return;
    *width = l->width > r->width ? l->width : r->width;
    *height = l->height > r->height ? l->height : r->height;
}

uint32_t stereo_view_count(const struct stereo *s) { return s->options.kind == STEREO_LEFT || s->options.kind == STEREO_RIGHT ? 1 : HEADSET_EYES; }

/* ---- poses ---- */

static fnl_vec3 minus(fnl_vec3 a, fnl_vec3 b) { return (fnl_vec3){a.x - b.x, a.y - b.y, a.z - b.z}; }
static fnl_vec3 cross(fnl_vec3 a, fnl_vec3 b) { return (fnl_vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
static float dot(fnl_vec3 a, fnl_vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static fnl_vec3 unit(fnl_vec3 a) {
    const float length = sqrtf(dot(a, a)), scale = length > 0 ? 1 / length : 0;
    return (fnl_vec3){a.x * scale, a.y * scale, a.z * scale};
}

static fnl_vec4 turn_from_axes(fnl_vec3 x, fnl_vec3 y, fnl_vec3 z) {
    fnl_vec4 q;
    if (x.x + y.y + z.z > 0) {
        const float s = 2 * sqrtf(1 + x.x + y.y + z.z);
        q = (fnl_vec4){(y.z - z.y) / s, (z.x - x.z) / s, (x.y - y.x) / s, s / 4};
    } else if (x.x > y.y && x.x > z.z) {
        const float s = 2 * sqrtf(1 + x.x - y.y - z.z);
        q = (fnl_vec4){s / 4, (y.x + x.y) / s, (z.x + x.z) / s, (y.z - z.y) / s};
    } else if (y.y > z.z) {
        const float s = 2 * sqrtf(1 + y.y - x.x - z.z);
        q = (fnl_vec4){(y.x + x.y) / s, s / 4, (z.y + y.z) / s, (z.x - x.z) / s};
    } else {
        const float s = 2 * sqrtf(1 + z.z - x.x - y.y);
        q = (fnl_vec4){(z.x + x.z) / s, (z.y + y.z) / s, s / 4, (x.y - y.x) / s};
    }
    const float length = sqrtf(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
    return (fnl_vec4){q.x / length, q.y / length, q.z / length, q.w / length};
}

static fnl_vec4 turn_after(fnl_vec4 a, fnl_vec4 b) {
    return (fnl_vec4){a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
                      a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}

/* The pose of a camera; of one that sees nothing, because its target is its position, an upright one. */
static fnl_rigid_pose pose_of(const fnl_camera *camera, fnl_vec3 axes[3]) {
    const fnl_vec3 back = unit(minus(camera->position, camera->target)), right = unit(cross(camera->up, back)), up = cross(back, right);
    axes[0] = right;
    axes[1] = up;
    axes[2] = back;
    return (fnl_rigid_pose){camera->position, dot(right, right) > 0 ? turn_from_axes(right, up, back) : (fnl_vec4){0, 0, 0, 1}};
}

static fnl_rigid_pose head_at(const struct stereo *s, const fnl_camera *camera, double time) {
    fnl_vec3 a[3];
    fnl_rigid_pose base = pose_of(camera, a);
    if (s->headset.pose_count == 0) return base;
    const fnl_rigid_pose own = headset_pose_at(&s->headset, time);
    const fnl_vec3 p = own.position;
    base.position = (fnl_vec3){base.position.x + a[0].x * p.x + a[1].x * p.y + a[2].x * p.z, base.position.y + a[0].y * p.x + a[1].y * p.y + a[2].y * p.z,
                               base.position.z + a[0].z * p.x + a[1].z * p.y + a[2].z * p.z};
    base.rotation = turn_after(base.rotation, own.rotation);
    return base;
}

const fnl_vec3 *stereo_gaze(const struct stereo *s, const fnl_camera *camera, double time, fnl_vec3 *out) {
    if (!s->headset.has_gaze) return NULL;
    const fnl_rigid_pose head = head_at(s, camera, time);
    const fnl_vec3 p = headset_gaze_at(&s->headset, time), q = {head.rotation.x, head.rotation.y, head.rotation.z}, t = cross(q, p), u = cross(q, t);
    *out = (fnl_vec3){head.position.x + p.x + 2 * (head.rotation.w * t.x + u.x), head.position.y + p.y + 2 * (head.rotation.w * t.y + u.y),
                      head.position.z + p.z + 2 * (head.rotation.w * t.z + u.z)};
    return out;
}

/* The camera's own field of view. */
static void take_field(const fnl_camera *camera, uint32_t width, uint32_t height, fnl_eye *eye) {
    const float y = tanf(camera->vertical_fov / 2), x = y * camera->pixel_aspect * (float)width / (float)height;
    eye->left = x * (-1 - camera->shift.x);
    eye->right = x * (1 - camera->shift.x);
    eye->down = y * (-1 - camera->shift.y);
    eye->up = y * (1 - camera->shift.y);
}

bool stereo_cameras(const struct stereo *s, const fnl_camera *camera, double time, uint32_t width, uint32_t height, fnl_camera out[HEADSET_EYES]) {
    const fnl_rigid_pose head = head_at(s, camera, time);
    fnl_camera eyes[HEADSET_EYES];
    if (camera->orthographic) {
        fputs("fanal: error: --stereo: the camera is orthographic, and eyes see in perspective\n", stderr);
        return false;
    }
    for (int i = 0; i < HEADSET_EYES; i++) {
        fnl_eye eye = s->headset.eyes[i].eye;
        if (!s->options.hmd) take_field(camera, width, height, &eye);
        if (fnl_eye_query_camera(NULL, &eye, &head, width, height, camera->near_distance, &eyes[i]) != FNL_OK) return false;
    }
    const bool second = s->options.kind == STEREO_RIGHT;
    out[0] = eyes[second];
    out[1] = eyes[1];
    return true;
}

/* ---- pictures ---- */

bool stereo_joins(enum stereo_kind kind) { return kind == STEREO_SIDE_BY_SIDE || kind == STEREO_TOP_BOTTOM || kind == STEREO_ANAGLYPH; }

static size_t pixel_bytes(const fnl_image *picture) { return fnl_pixel_size(picture->format); }

static bool put_beside(fnl_image *picture) {
    const size_t row = picture->width * pixel_bytes(picture), eye = row * (picture->height / 2), size = 2 * eye;
    char *from = malloc(size ? size : 1), *to = picture->pixels;
    if (!from) {
        fputs("fanal: error: --stereo: memory ran out\n", stderr);
        return false;
    }
    memcpy(from, to, size);
    for (size_t y = 0; y < picture->height / 2; y++)
        for (size_t i = 0; i < 2; i++) memcpy(to + (2 * y + i) * row, from + i * eye + y * row, row);
    free(from);
    picture->width *= 2;
    picture->height /= 2;
    return true;
}

static void put_over(fnl_image *picture) {
    const size_t count = (size_t)picture->width * (picture->height / 2), value = pixel_bytes(picture) / 4;
    char *left = picture->pixels;
    const char *right = left + count * 4 * value;
    for (size_t i = 0; i < count; i++) memcpy(left + (4 * i + 1) * value, right + (4 * i + 1) * value, 2 * value);
    picture->height /= 2;
}

bool stereo_join(enum stereo_kind kind, bool color, fnl_image *picture) {
    if (!picture->pixels) return true;
    if (kind == STEREO_SIDE_BY_SIDE) return put_beside(picture);
    if (kind == STEREO_ANAGLYPH && color) put_over(picture);
    if (kind == STEREO_ANAGLYPH && !color) picture->height /= 2;
    return true;
}
