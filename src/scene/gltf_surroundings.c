/* SPDX-License-Identifier: MIT */
/*
 * FNL_surroundings of the shown scene: ambient light, background, environment and probes, which glTF has no words for (docs/embedding.md). fnl_scene_save
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
    params.max_memory = g->memory_left;
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

static void load_probe(struct gltf *g, json_t *object, const struct at *at) {
    fnl_probe_params p = fnl_probe_params_default();
    uint64_t face_size = p.face_size, mask = p.mask;
    float priority = 0;
    fnl_probe_id id;
    double centre[3] = {0, 0, 0};
    gltf_doubles(g, object, at, "centre", 3, -FLT_MAX, FLT_MAX, centre);
    p.centre = vec3_from_place(centre, g->scene->origin);
    gltf_floats(g, object, at, "halfSize", 3, FLT_MIN, FLT_MAX, &p.half_size.x);
    gltf_rotation(g, object, at, "rotation", &p.rotation);
    gltf_floats(g, object, at, "capture", 3, -FLT_MAX, FLT_MAX, &p.capture.x);
    gltf_float(g, object, at, "wall", false, FLT_MIN, FLT_MAX, &p.wall);
    gltf_uint(g, object, at, "faceSize", false, 8, 2048, &face_size);
    gltf_float(g, object, at, "softness", false, 0, 16, &p.softness);
    gltf_float(g, object, at, "blend", false, 0, FLT_MAX, &p.blend);
    gltf_float(g, object, at, "intensity", false, 0, FLT_MAX, &p.intensity);
    if (gltf_float(g, object, at, "priority", false, -2e9f, 2e9f, &priority)) p.priority = (int32_t)priority;
    gltf_uint(g, object, at, "mask", false, 0, 255, &mask);
    p.mask = (uint32_t)mask;
    p.face_size = (uint32_t)face_size;
    p.shadows = gltf_bool(g, object, at, "shadows", p.shadows);
    p.reflection = gltf_bool(g, object, at, "reflection", p.reflection);
    const fnl_result result = fnl_scene_add_probe(g->scene, &p, &id); /* says what is wrong */
    if (result == FNL_ERROR_MEMORY) gltf_fail_memory(g);
    if (result != FNL_OK) gltf_warn(g, at, "is no probe; it is left out");
    else memcpy(g->scene->probes.data[id.index].place, centre, sizeof centre);
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
    json_t *probes = gltf_array(g, extension, &place.extension, "probes", false);
    const struct at *probes_at = AT_KEY(&place.extension, "probes");
    for (uint32_t i = 0; i < gltf_count(probes) && g->result == FNL_OK; i++) {
        json_t *probe = gltf_element(g, probes, probes_at, i);
        if (probe) load_probe(g, probe, AT_INDEX(probes_at, i));
    }
}
