/* SPDX-License-Identifier: MIT */
#include "views.h"

#include "arguments.h"
#include "print.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The faces of a cube in the order of cube maps: right, left, up, down, back, front, each as it is seen from inside. */
static void add_cube(const fnl_camera *from, fnl_camera *out) {
    static const fnl_vec3 forward[6] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    static const fnl_vec3 up[6] = {{0, 1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}, {0, 1, 0}, {0, 1, 0}};
    for (int i = 0; i < 6; i++) {
        float reach = 1; /* far from the origin a target one metre away would round the direction */
        for (int k = 0; k < 3; k++) {
            float side = (&from->position.x)[k];
            reach += 0.1f * (side < 0 ? -side : side);
        }
        out[i] = *from;
        out[i].target = (fnl_vec3){from->position.x + forward[i].x * reach, from->position.y + forward[i].y * reach,
                                   from->position.z + forward[i].z * reach};
        out[i].up = up[i];
        out[i].vertical_fov = 1.57079632679489662f;
        out[i].orthographic = false;
        out[i].shift = (fnl_vec2){0, 0};
    }
}

bool views_are_cube(const char *text) { return strcmp(text, "cube") == 0; }

static bool query_name(const fnl_scene *scene, uint32_t camera, const char **name) {
    fnl_entity_info info;
    if (fnl_scene_query_entity(scene, FNL_ENTITY_CAMERA, camera, &info) != FNL_OK) return false;
    *name = info.name;
    return true;
}

static void say_there_is_none(const fnl_scene *scene, const char *option, const char *wanted, uint32_t count) {
    enum { LISTED = 20 };
    fprintf(stderr, "fanal: error: %s: the scene has no camera '%s'; it has %s", option, wanted, count ? "" : "no cameras");
    const char *name;
    for (uint32_t i = 0; i < count && i < LISTED && query_name(scene, i, &name); i++)
        fprintf(stderr, *name ? "%s%u ('%s')" : "%s%u", i ? ", " : "", i, name);
    fputs(count > LISTED ? ", …\n" : "\n", stderr);
}

bool views_find_camera(const fnl_scene *scene, const char *option, const char *name, fnl_camera *out) {
    const uint32_t count = fnl_scene_count(scene, FNL_ENTITY_CAMERA);
    const char *at = name;
    uint64_t number;
    if (argument_take_count(&at, &number) && !*at && number < count) return fnl_scene_query_camera(scene, (uint32_t)number, out) == FNL_OK;
    const char *known;
    for (uint32_t i = 0; *name && i < count && query_name(scene, i, &known); i++)
        if (strcmp(known, name) == 0) return fnl_scene_query_camera(scene, i, out) == FNL_OK;
    say_there_is_none(scene, option, name, count);
    return false;
}

static bool too_many(unsigned long count) {
    if (count <= FNL_VIEWS_MAX) return false;
    fprintf(stderr, "fanal: error: --views: %lu cameras are too many for one frame, which has %d at most\n", count, FNL_VIEWS_MAX);
    return true;
}

bool views_choose(const char *text, const fnl_scene *scene, const fnl_camera *from, fnl_camera out[FNL_VIEWS_MAX], uint32_t *out_count) {
    *out_count = 0;
    if (views_are_cube(text)) {
        add_cube(from, out);
        *out_count = 6;
        return true;
    }
    if (strcmp(text, "all") == 0) {
        uint32_t count = fnl_scene_count(scene, FNL_ENTITY_CAMERA);
        if (count == 0) fputs("fanal: error: --views: the scene has no cameras\n", stderr);
        if (count == 0 || too_many(count)) return false;
        for (; *out_count < count; ++*out_count)
            if (fnl_scene_query_camera(scene, *out_count, &out[*out_count]) != FNL_OK) return false;
        return true;
    }
    unsigned long count = 1;
    for (const char *c = text; *c; c++) count += *c == ',';
    if (too_many(count)) return false;
    char *copy = strdup(text), *rest = copy;
    bool good = copy;
    for (char *name; good && (name = strsep(&rest, ",")); ++*out_count) good = views_find_camera(scene, "--views", name, &out[*out_count]);
    free(copy);
    return good;
}
