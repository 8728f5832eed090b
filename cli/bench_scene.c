/* SPDX-License-Identifier: MIT */
/* The scene of a case, lit as asked, and the cameras that look at it. */
#include "bench.h"
#include "loading.h"
#include "views.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool bench_scene_load(const fnl_host *host, const struct bench_settings *settings, const char *name, int64_t lights, fnl_scene **out) {
    char source[2048];
    const uint32_t scattered = loading_lights(name, lights, false, source, sizeof source);
    fnl_result result = fnl_scene_load(host, source, &settings->loading, out);
    if (result == FNL_OK && !loading_select_variant(*out, settings->variant, NULL)) result = FNL_ERROR_INVALID;
    if (result == FNL_OK && scattered > 0) result = fnl_scene_scatter_lights(*out, scattered, 1);
    fnl_environment_params environment = fnl_environment_params_default();
    environment.max_memory = settings->loading.max_memory;
    environment.source = settings->environment;
    if (result == FNL_OK && settings->environment) result = fnl_scene_set_environment(*out, &environment);
    if (result != FNL_OK) fnl_scene_destroy(out);
    return result == FNL_OK;
}

bool bench_scene_path(const fnl_scene *scene, const struct bench_settings *settings, const char *name, float aspect,
                      struct bench_path *out) {
    fnl_camera camera = fnl_camera_default();
    bool found;
    if (name)
        found = views_find_camera(scene, "--camera", name, &camera);
    else if (fnl_scene_count(scene, FNL_ENTITY_CAMERA))
        found = fnl_scene_query_camera(scene, 0, &camera) == FNL_OK;
    else
        found = fnl_scene_query_framing_camera(scene, aspect, &camera) == FNL_OK;
    return found && bench_path_create(out, settings->camera_path, scene, &camera, settings->frames, aspect);
}

bool bench_scene_check(const struct bench_settings *settings, const char *name, const char *camera, uint32_t *lights) {
    fnl_scene *scene = NULL;
    fnl_scene_info info = {0};
    struct bench_path path = {0};
    fnl_host host = fnl_host_default();
    bool good = bench_scene_load(&host, settings, name, -1, &scene) && bench_scene_path(scene, settings, camera, 1, &path) &&
                fnl_scene_query_info(scene, &info) == FNL_OK;
    *lights = info.light_count - info.light_kind_counts[FNL_LIGHT_DIRECTIONAL];
    bench_path_destroy(&path);
    fnl_scene_destroy(&scene);
    return good;
}

uint32_t bench_scene_lights(const char *name, uint32_t own, int64_t asked) {
    return asked < 0 ? own : (loading_is_builtin(name) ? 0 : own) + (uint32_t)asked;
}
