/* SPDX-License-Identifier: MIT */
/*
 * FNL_surroundings of the shown scene: ambient light, background and environment, which glTF has no words for (docs/embedding.md). fnl_scene_save
 * writes it.
 */
#include "image/image.h"
#include "scene/gltf.h"

#define NAME "FNL_surroundings"

static void load_panorama(struct gltf *g, json_t *object, const struct at *at, fnl_environment_params *params) {
    const uint32_t index = gltf_index(g, object, at, "bufferView", true, g->view_count);
    fnl_image image = {0};
    if (index == SCENE_NONE) return;
    if (!g->views[index].valid || !g->views[index].data) {
        gltf_warn(g, AT_KEY(at, "bufferView"), "has no data; the environment is left out");
        return;
    }
    struct gltf_quiet_host quiet;
    gltf_quiet_host_init(&quiet, g->host);
    struct image_file_info info;
    fnl_result result = image_peek(&quiet.host, g->views[index].data, (size_t)g->views[index].size, "the picture", &info);
    if (result == FNL_OK && !gltf_take_memory(g, at, 2ull * info.width * info.height * 16)) return;
    if (result == FNL_OK) result = image_decode(&quiet.host, g->views[index].data, (size_t)g->views[index].size, "the picture", false, &image);
    params->image = &image;
    if (result == FNL_ERROR_MEMORY) gltf_fail_memory(g);
    if (result != FNL_OK) gltf_warn(g, AT_KEY(at, "bufferView"), "%s; the environment is left out", quiet.line);
    if (result == FNL_OK) result = fnl_scene_set_environment(g->scene, params); /* says what is wrong */
    if (result == FNL_ERROR_MEMORY) gltf_fail_memory(g);
    fnl_image_free(&quiet.host, &image);
}

static void load_environment(struct gltf *g, json_t *object, const struct at *at) {
    fnl_environment_params params = fnl_environment_params_default();
    gltf_float(g, object, at, "rotation", false, -FLT_MAX, FLT_MAX, &params.rotation);
    gltf_float(g, object, at, "intensity", false, 0, 1e6f, &params.intensity);
    params.background = gltf_bool(g, object, at, "visible", true);
    params.lights = gltf_bool(g, object, at, "lights", true);
    params.compressed = gltf_bool(g, object, at, "compressed", false);
    params.source = gltf_string(g, object, at, "source", false);
    if (!params.source) {
        load_panorama(g, object, at, &params);
    } else if (strncmp(params.source, "builtin:", 8) != 0) {
        gltf_warn(g, AT_KEY(at, "source"), "is no 'builtin:NAME'; it is ignored");
    } else {
        const fnl_result result = fnl_scene_set_environment(g->scene, &params); /* says what is wrong */
        if (result == FNL_ERROR_MEMORY) gltf_fail_memory(g);
        if (result != FNL_OK) gltf_warn(g, AT_KEY(at, "source"), "is no environment; it is ignored");
    }
}

void gltf_load_surroundings(struct gltf *g) {
    json_t *scenes = json_object_get(g->root, "scenes"); /* gltf_load_scenes has complained of what is wrong there */
    const json_t *value = json_object_get(g->root, "scene");
    const size_t shown = json_is_integer(value) && json_integer_value(value) < gltf_count(scenes) ? (size_t)json_integer_value(value) : 0;
    json_t *object = json_array_get(scenes, shown);
    const struct at *scenes_at = AT_KEY(&g->top, "scenes"), *at = AT_INDEX(scenes_at, shown);
    struct gltf_extension_place place;
    json_t *extension = json_is_object(object) ? gltf_extension(object, at, NAME, &place) : NULL;
    if (!extension) return;
    gltf_floats(g, extension, &place.extension, "ambientSky", 3, 0, FLT_MAX, &g->scene->ambient_sky.x);
    gltf_floats(g, extension, &place.extension, "ambientGround", 3, 0, FLT_MAX, &g->scene->ambient_ground.x);
    gltf_floats(g, extension, &place.extension, "background", 3, 0, FLT_MAX, &g->scene->background.x);
    json_t *environment = gltf_object(g, extension, &place.extension, "environment", false);
    if (environment) load_environment(g, environment, AT_KEY(&place.extension, "environment"));
}
