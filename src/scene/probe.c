/* SPDX-License-Identifier: MIT */
/* Probes of a scene: the public calls. */
#include "scene/scene.h"

fnl_probe_params fnl_probe_params_default(void) {
    return (fnl_probe_params){.half_size = {1, 1, 1},
                              .rotation = quat_identity(),
                              .wall = 0.05f,
                              .face_size = 128,
                              .shadows = true,
                              .blend = 0.05f,
                              .intensity = 1,
                              .mask = 255};
}

fnl_result scene_check_probe(const struct call *call, const fnl_probe_params *p) {
    TRY(check_pointer(call, "params", p));
    const double infinite = (double)FLT_MAX;
    const float *half = &p->half_size.x, *capture = &p->capture.x;
    const float length = sqrtf(p->rotation.x * p->rotation.x + p->rotation.y * p->rotation.y + p->rotation.z * p->rotation.z +
                               p->rotation.w * p->rotation.w);
    TRY(check_floats(call, "centre", &p->centre.x, 3, -infinite, infinite, " m"));
    for (int i = 0; i < 3; i++) TRY(check_above(call, "half_size", (double)half[i], 0, infinite, " m"));
    if (!(fabsf(length - 1) < 1e-3f)) return misuse(call, "rotation has the length %g, must be a unit quaternion", (double)length);
    for (int i = 0; i < 3; i++) TRY(check_range(call, "capture", (double)capture[i], -(double)half[i], (double)half[i], " m (inside the box)"));
    TRY(check_above(call, "wall", (double)p->wall, 0, infinite, " m"));
    TRY(check_count(call, "face_size", p->face_size, 8, 2048));
    TRY(check_range(call, "softness", (double)p->softness, 0, 16, " levels/m"));
    TRY(check_range(call, "blend", (double)p->blend, 0, infinite, " m"));
    TRY(check_count(call, "mask", p->mask, 0, 255));
    return check_range(call, "intensity", (double)p->intensity, 0, infinite, "");
}

bool scene_has_reflections(const fnl_scene *scene) {
    for (uint32_t i = 0; i < scene->probes.count; i++)
        if (!scene->probes.data[i].removed && scene->probes.data[i].params.reflection) return true;
    return false;
}

uint32_t scene_add_probe(fnl_scene *scene, const fnl_probe_params *params) {
    struct scene_probe probe = {.params = *params, .generation = scene_take_generation(scene), .version = ++scene->probe_version};
    probe.params.rotation = quat_normalize(params->rotation);
    place_from_vec3(params->centre, scene->origin, probe.place);
    scene_use_light_masks(scene, params->mask != 255);
    const uint32_t index = scene_take_place(scene, SCENE_PROBES, &scene->probes);
    if (index != SCENE_NONE) scene->probes.data[index] = probe;
    return index;
}

void scene_remove_probe(fnl_scene *scene, uint32_t index) {
    scene->probes.data[index].removed = true;
    scene_leave_hole(scene, SCENE_PROBES, index);
    scene->probe_version++;
}

fnl_result fnl_scene_add_probe(fnl_scene *scene, const fnl_probe_params *params, fnl_probe_id *out) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_pointer(CALL(&scene->host), "out", out));
    *out = (fnl_probe_id){0};
    TRY(scene_check_probe(CALL(&scene->host), params));
    uint32_t index = scene_add_probe(scene, params);
    if (index == SCENE_NONE) return FNL_ERROR_MEMORY;
    *out = (fnl_probe_id){index, scene->probes.data[index].generation};
    return FNL_OK;
}

static fnl_result check_probe_id(const struct call *call, const fnl_scene *scene, fnl_probe_id id) {
    const struct scene_probe *probe = id.index < scene->probes.count ? &scene->probes.data[id.index] : NULL;
    bool alive = probe && id.generation && probe->generation == id.generation && !probe->removed;
    return check_id(call, "probe", alive, id.index, id.generation, "a probe");
}

fnl_result fnl_scene_set_probe(fnl_scene *scene, fnl_probe_id id, const fnl_probe_params *params) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_probe_id(CALL(&scene->host), scene, id));
    TRY(scene_check_probe(CALL(&scene->host), params));
    struct scene_probe *probe = &scene->probes.data[id.index];
    if (memcmp(&params->centre, &probe->params.centre, sizeof params->centre) != 0) place_from_vec3(params->centre, scene->origin, probe->place);
    probe->params = *params;
    probe->params.rotation = quat_normalize(params->rotation);
    probe->version = ++scene->probe_version;
    scene_use_light_masks(scene, params->mask != 255);
    return FNL_OK;
}

fnl_result fnl_scene_remove_probe(fnl_scene *scene, fnl_probe_id id) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_probe_id(CALL(&scene->host), scene, id));
    scene_remove_probe(scene, id.index);
    return FNL_OK;
}

fnl_result fnl_scene_query_probe(const fnl_scene *scene, uint32_t index, fnl_probe_params *out) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_pointer(CALL(&scene->host), "out", out));
    TRY(check_index(CALL(&scene->host), "index", index, scene_entity_count(scene, FNL_ENTITY_PROBE), "probes"));
    *out = scene->probes.data[scene_entity_slot(scene, FNL_ENTITY_PROBE, index)].params;
    return FNL_OK;
}
