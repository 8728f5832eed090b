/* SPDX-License-Identifier: MIT */
/* Where the camera is in each frame: a file of points, or a circle round the scene. */
#include "arguments.h"
#include "bench.h"
#include "origin.h"
#include "print.h"

#include "input.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { POINTS_MAX = 1 << 20 };
static const double CIRCLE_STEP = 1 / 30.0; /* seconds */

static bool add_point(struct bench_path *path, const struct bench_point *point) {
    if ((path->count & (path->count - 1)) == 0) { /* full at every power of two */
        struct bench_point *bigger = realloc(path->points, (path->count ? 2 * path->count : 1) * sizeof *bigger);
        if (!bigger) return false;
        path->points = bigger;
    }
    path->points[path->count++] = *point;
    return true;
}

static bool bad_line(const char *file, unsigned line, const char *problem) {
    fprintf(stderr, "fanal: error: --camera-path: %s:%u: %s\n", file, line, problem);
    return false;
}

static bool parse_line(struct bench_path *path, const char *file, unsigned line, const char *text, const fnl_camera *base) {
    struct bench_point point = {.camera = *base};
    double *eye = point.eye, *target = point.target, numbers[7];
    text += strspn(text, " \t\r\n");
    if (!*text || *text == '#') return true;
    const uint32_t count = argument_take_row(&text, numbers, 7);
    text += strspn(text, " \t\r\n");
    if (count != 7 || (*text && *text != '#')) return bad_line(file, line, "not 'seconds eye.x eye.y eye.z target.x target.y target.z'");
    point.time = numbers[0];
    memcpy(eye, &numbers[1], sizeof point.eye);
    memcpy(target, &numbers[4], sizeof point.target);
    for (int i = 1; i < 7; i++)
        if (!isfinite((float)numbers[i])) return bad_line(file, line, "a number is too large");
    if (eye[0] == target[0] && eye[1] == target[1] && eye[2] == target[2])
        return bad_line(file, line, "the target is where the eye is");
    if (path->count && point.time < path->points[path->count - 1].time) return bad_line(file, line, "time runs backwards");
    if (path->count == POINTS_MAX) return bad_line(file, line, "more than 1048576 points");
    return add_point(path, &point) || bad_line(file, line, "memory ran out");
}

static bool load_points(struct bench_path *path, const char *file, const fnl_camera *base) {
    FILE *in = input_open(file, 1 << 30);
    char text[1024];
    bool good = in != NULL;
    for (unsigned line = 1; good && fgets(text, sizeof text, in); line++) {
        if (strlen(text) == sizeof text - 1) good = bad_line(file, line, "the line is too long");
        good = good && parse_line(path, file, line, text, base);
    }
    if (in) fclose(in);
    if (good && path->count == 0) {
        fprintf(stderr, "fanal: error: --camera-path: %s: there is no point in it\n", file);
        good = false;
    }
    return good;
}

/* Adds a point for a camera that is relative to the scene's current origin. */
static bool add_camera(struct bench_path *path, const fnl_scene *scene, double time, const fnl_camera *camera) {
    struct bench_point point = {.time = time, .camera = *camera};
    origin_place(scene, camera->position, point.eye);
    origin_place(scene, camera->target, point.target);
    return add_point(path, &point);
}

/*
 * A circle round the scene at the distance of the camera that frames it. The orbit keeps that camera's height and goes with the x axis towards
 * the z axis; on the turntable the camera is level, and the scene seems to turn that way, so the camera goes the other.
 */
static bool make_circle(struct bench_path *path, const fnl_scene *scene, bool turntable, uint32_t count, float aspect) {
    fnl_camera framing;
    if (fnl_scene_query_framing_camera(scene, aspect, &framing) != FNL_OK) return false;
    fnl_vec3 center = framing.target;
    float x = framing.position.x - center.x, y = framing.position.y - center.y, z = framing.position.z - center.z;
    float radius = hypotf(x, z), start = atan2f(z, x), turn = turntable ? -6.2831853f : 6.2831853f;
    if (turntable) {
        radius = hypotf(radius, y);
        framing.position.y = center.y;
    }
    for (uint32_t i = 0; i < count; i++) {
        float angle = start + turn * (float)i / (float)count;
        framing.position.x = center.x + radius * cosf(angle);
        framing.position.z = center.z + radius * sinf(angle);
        if (!add_camera(path, scene, i * CIRCLE_STEP, &framing)) return false;
    }
    return true;
}

/* "orbit", "orbit:N": whether it is that, and N. */
static bool circle_named(const char *source, const char *name, uint32_t *count) {
    size_t length = strlen(name);
    if (strncmp(source, name, length) != 0) return false;
    if (!source[length]) return true;
    const char *at = source + length + 1;
    uint64_t number;
    if (source[length] != ':' || !argument_take_count(&at, &number) || *at || number < 1 || number > POINTS_MAX) return false;
    *count = (uint32_t)number;
    return true;
}

bool bench_path_is_circle(const char *source, uint32_t *count) {
    return circle_named(source, "orbit", count) || circle_named(source, "turntable", count);
}

bool bench_path_create(struct bench_path *path, const char *source, const fnl_scene *scene, const fnl_camera *base,
                        uint32_t orbit_count, float aspect) {
    *path = (struct bench_path){0};
    bool good = !source ? add_camera(path, scene, 0, base)
                : bench_path_is_circle(source, &orbit_count)
                    ? make_circle(path, scene, *source == 't', orbit_count, aspect)
                    : load_points(path, source, base);
    if (!good) bench_path_destroy(path);
    return good;
}

bool bench_path_camera(const struct bench_path *path, fnl_scene *scene, uint32_t index, fnl_camera *out) {
    const struct bench_point *point = &path->points[index % path->count];
    if (!origin_follow(scene, point->eye)) return false;
    *out = point->camera;
    out->position = origin_position(scene, point->eye);
    out->target = origin_position(scene, point->target);
    return true;
}

void bench_path_destroy(struct bench_path *path) {
    free(path->points);
    *path = (struct bench_path){0};
}
