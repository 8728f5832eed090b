/* SPDX-License-Identifier: MIT */
/* Where the camera is in each frame: a file of points, or a circle around the scene. */
#include "bench.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { POINTS_MAX = 1 << 20 };

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
    fnl_vec3 *eye = &point.camera.position, *target = &point.camera.target;
    int used = 0;
    text += strspn(text, " \t\r\n");
    if (!*text || *text == '#') return true;
    if (sscanf(text, "%lf %f %f %f %f %f %f %n", &point.time, &eye->x, &eye->y, &eye->z, &target->x, &target->y, &target->z,
               &used) != 7 ||
        !used || (text[used] && text[used] != '#'))
        return bad_line(file, line, "not 'seconds eye.x eye.y eye.z target.x target.y target.z'");
    float sum = eye->x + eye->y + eye->z + target->x + target->y + target->z;
    if (!isfinite(point.time) || !isfinite(sum)) return bad_line(file, line, "a number is not finite");
    if (eye->x == target->x && eye->y == target->y && eye->z == target->z)
        return bad_line(file, line, "the target is where the eye is");
    if (path->count && point.time < path->points[path->count - 1].time) return bad_line(file, line, "time runs backwards");
    if (path->count == POINTS_MAX) return bad_line(file, line, "more than 1048576 points");
    return add_point(path, &point) || bad_line(file, line, "memory ran out");
}

static bool load_points(struct bench_path *path, const char *file, const fnl_camera *base) {
    FILE *in = fopen(file, "r");
    char text[1024];
    bool good = in != NULL;
    for (unsigned line = 1; good && fgets(text, sizeof text, in); line++) {
        if (strlen(text) == sizeof text - 1) good = bad_line(file, line, "the line is too long");
        good = good && parse_line(path, file, line, text, base);
    }
    if (in)
        fclose(in);
    else
        fprintf(stderr, "fanal: error: --camera-path: %s: cannot be opened\n", file);
    if (good && path->count == 0) {
        fprintf(stderr, "fanal: error: --camera-path: %s: there is no point in it\n", file);
        good = false;
    }
    return good;
}

/* A circle at the distance and height from which a camera sees the whole scene. */
static bool make_orbit(struct bench_path *path, const fnl_scene *scene, uint32_t count, float aspect) {
    fnl_camera framing;
    fnl_scene_info info;
    if (fnl_scene_query_framing_camera(scene, aspect, &framing) != FNL_OK || fnl_scene_query_info(scene, &info) != FNL_OK)
        return false;
    fnl_vec3 center = framing.target;
    float x = framing.position.x - center.x, z = framing.position.z - center.z;
    float radius = hypotf(x, z), start = atan2f(z, x);
    for (uint32_t i = 0; i < count; i++) {
        float angle = start + 6.2831853f * (float)i / (float)count;
        struct bench_point point = {i / 30.0, framing};
        point.camera.position.x = center.x + radius * cosf(angle);
        point.camera.position.z = center.z + radius * sinf(angle);
        if (!add_point(path, &point)) return false;
    }
    return true;
}

bool bench_path_create(struct bench_path *path, const char *source, const fnl_scene *scene, const fnl_camera *base,
                       uint32_t orbit_count, float aspect) {
    *path = (struct bench_path){0};
    bool good = !source                        ? add_point(path, &(struct bench_point){.camera = *base})
                : strcmp(source, "orbit") == 0 ? make_orbit(path, scene, orbit_count, aspect)
                                               : load_points(path, source, base);
    if (!good) bench_path_destroy(path);
    return good;
}

void bench_path_destroy(struct bench_path *path) {
    free(path->points);
    *path = (struct bench_path){0};
}
