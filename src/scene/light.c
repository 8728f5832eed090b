/* SPDX-License-Identifier: MIT */
/* The public calls of fanal/light.h, and what the parameters of a light say about its volume. */
#include "base/check.h"
#include "scene/light_kinds.h"
#include "scene/scene.h"

float fnl_light_range(const fnl_light_params *light, float min_roughness, float threshold) {
    if (check_handle(__func__, "params", light) != FNL_OK) return 0;
    if (fnl_light_kind_find(light->kind) && light_kinds[light->kind].range) return light_kinds[light->kind].range(light);
    if (isfinite(light->range)) return light->range;
    float alpha = fmaxf(min_roughness * min_roughness, 0.001f), gain = fmaxf(1, 0.25f / (alpha * alpha));
    float brightest = fmaxf(light->color[0], fmaxf(light->color[1], light->color[2]));
    return fminf(sqrtf(light->intensity * brightest * gain / threshold), 1e18f); /* its square must be finite */
}

float light_effective_range(const struct scene_light *light) {
    return light_is_unlimited(light) ? light->reach : fnl_light_range(&light->params, 1, 1);
}

vec3 light_up(vec3 direction, vec3 up) {
    vec3 across = vec3_add_scaled(up, direction, -vec3_dot(up, direction));
    if (!(vec3_length(across) > 1e-4f * vec3_length(up))) across = vec3_perpendicular(direction);
    across = vec3_normalize(across);
    return vec3_normalize(vec3_add_scaled(across, direction, -vec3_dot(across, direction)));
}

/* ---- adding, changing, removing ---- */

static void set_defaults(fnl_light_params *light, const fnl_light_member *member) {
    void *value = light_value(light, member);
    if (member->unit == FNL_LIGHT_UNIT_SWITCH)
        *(bool *)value = member->defaults[0] > 0;
    else
        memcpy(value, member->defaults, light_member_size(member));
}

fnl_light_params fnl_light_params_default(void) {
    fnl_light_params light = {
        .kind = FNL_LIGHT_POINT,
        .direction = {0, 0, -1},
        .color = {1, 1, 1},
        .intensity = 1,
        .range = INFINITY,
        .up = {0, 1, 0},
        .casts_shadows = true,
        .contact_scale = 1,
        .mask = 255,
    };
    for (int k = 0; k < FNL_LIGHT_KIND_COUNT; k++)
        for (uint32_t i = 0; i < light_kinds[k].info.member_count; i++) set_defaults(&light, &light_kinds[k].info.members[i]);
    return light;
}

static fnl_result check_profile(const struct call *call, const fnl_scene *scene, const fnl_light_params *params) {
    const fnl_light_profile_id id = params->profile;
    if (!id.generation) return FNL_OK;
    if (!light_is_profiled(params)) return misuse(call, "profile is set, but only points and spots can have one");
    const bool alive = id.index < scene->profiles.count && scene->profiles.data[id.index].generation == id.generation;
    TRY(check_id(call, "profile", alive, id.index, id.generation, "a light profile"));
    return check_finite(call, "up", params->up);
}

/* "length", "wedge_angles[0]", "box_size.x" */
static void name_value(const fnl_light_member *member, uint32_t i, char name[64]) {
    if (member->count == 1)
        snprintf(name, 64, "%s", member->name);
    else if (member->count == 2)
        snprintf(name, 64, "%s[%u]", member->name, i);
    else
        snprintf(name, 64, "%s.%c", member->name, "xyz"[i]);
}

static fnl_result check_member(const struct call *call, const fnl_light_params *params, const fnl_light_member *member) {
    static const char *const units[FNL_LIGHT_UNIT_COUNT] = {" metres", " radians", ""};
    char unit[64], name[64];
    double high = (double)member->high;
    if (member->unit == FNL_LIGHT_UNIT_SWITCH) return FNL_OK;
    snprintf(unit, sizeof unit, "%s", units[member->unit]);
    if (member->at_most) {
        const float *most = light_value_of(params, light_member_find(&light_kinds[params->kind].info, member->at_most));
        high = (double)*most;
        snprintf(unit, sizeof unit, "%s (%s)", units[member->unit], member->at_most);
    }
    for (uint32_t i = 0; i < member->count; i++) {
        const float *values = light_value_of(params, member);
        name_value(member, i, name);
        TRY((member->above_low ? check_above : check_range)(call, name, (double)values[i], (double)member->low, high, unit));
    }
    return FNL_OK;
}

static fnl_result check_light(const struct call *call, const fnl_scene *scene, const fnl_light_params *params) {
    const double infinite = (double)FLT_MAX;
    TRY(check_enum(call, "kind", (int)params->kind, FNL_LIGHT_KIND_COUNT, "fnl_light_kind"));
    const fnl_light_kind_info *kind = &light_kinds[params->kind].info;
    TRY(check_enum(call, "shadow_update", (int)params->shadow_update, FNL_SHADOW_UPDATE_COUNT, "fnl_shadow_update"));
    TRY(check_finite(call, "position", params->position));
    TRY(check_finite(call, "direction", params->direction));
    TRY(check_profile(call, scene, params));
    if (light_has_direction(params) && !(vec3_length(params->direction) > 0)) return misuse(call, "direction is 0, 0, 0, must have a length");
    TRY(check_count(call, "mask", params->mask, 0, 255));
    TRY(check_range(call, "contact_scale", (double)params->contact_scale, 0, 1000, ""));
    TRY(check_floats(call, "color", params->color, 3, 0, infinite, ""));
    TRY(check_range(call, "intensity", (double)params->intensity, 0, infinite, kind->parallel ? " lux" : " candela"));
    if (kind->has_range) TRY(check_above(call, "range", (double)params->range, 0, (double)INFINITY, " metres"));
    if (kind->has_source_angle) TRY(check_range(call, "source_angle", (double)params->source_angle, 0, 1, " radians"));
    if (kind->has_source_radius) TRY(check_range(call, "source_radius", (double)params->source_radius, 0, infinite, " metres"));
    if (kind->has_up) TRY(check_finite(call, "up", params->up));
    for (uint32_t i = kind->member_count; i-- > 0;) TRY(check_member(call, params, &kind->members[i])); /* a limit before what it limits */
    return FNL_OK;
}

/* With direction and up as unit vectors at right angles. */
static fnl_light_params aligned(const fnl_light_params *params) {
    fnl_light_params light = *params;
    light.direction = vec3_normalize(params->direction);
    light.up = light_up(light.direction, params->up);
    return light;
}

fnl_result fnl_scene_add_light(fnl_scene *scene, const fnl_light_params *params, fnl_light_id *out) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_pointer(CALL(&scene->host), "out", out));
    *out = (fnl_light_id){0};
    TRY(check_pointer(CALL(&scene->host), "params", params));
    TRY(check_light(CALL(&scene->host), scene, params));
    const fnl_light_params light = aligned(params);
    TRY(scene_reserve_lights(scene, 1));
    uint32_t index = scene_add_light(scene, &light, SCENE_NONE);
    *out = (fnl_light_id){index, scene->lights.data[index].generation};
    return FNL_OK;
}

static fnl_result check_light_id(const struct call *call, const fnl_scene *scene, fnl_light_id id) {
    const struct scene_light *light = id.index < scene->lights.count ? &scene->lights.data[id.index] : NULL;
    bool alive = light && id.generation && light->generation == id.generation && !light->removed;
    return check_id(call, "light", alive, id.index, id.generation, "a light");
}

/* Compares only the parts of a pose that a light of this kind has. */
static bool poses_differ(const fnl_light_params *a, const fnl_light_params *b) {
    bool position = light_kinds[a->kind].info.has_position && memcmp(&a->position, &b->position, sizeof a->position) != 0;
    bool direction = (light_has_direction(a) || light_is_profiled(b)) && memcmp(&a->direction, &b->direction, sizeof a->direction) != 0;
    bool up = (light_has_up(a) || light_is_profiled(b)) && memcmp(&a->up, &b->up, sizeof a->up) != 0;
    return position || direction || up;
}

fnl_result fnl_scene_set_lights(fnl_scene *scene, const fnl_light_id *lights, const fnl_light_params *params, uint32_t count) {
    TRY(check_handle(__func__, "scene", scene));
    if (count == 0) return FNL_OK;
    TRY(check_pointer(CALL(&scene->host), "lights", lights));
    TRY(check_pointer(CALL(&scene->host), "params", params));
    uint32_t moved = 0; /* between the local and the directional ones */
    for (uint32_t i = 0; i < count; i++) {
        const struct call *call = CALL_ELEMENT(&scene->host, i, count);
        TRY(check_light_id(call, scene, lights[i]));
        TRY(check_light(call, scene, &params[i]));
        fnl_light_kind before = scene->lights.data[lights[i].index].params.kind;
        moved += (before == FNL_LIGHT_DIRECTIONAL) != (params[i].kind == FNL_LIGHT_DIRECTIONAL);
    }
    TRY(scene_reserve_lights(scene, moved));
    for (uint32_t i = 0; i < count; i++) {
        struct scene_light *light = &scene->lights.data[lights[i].index];
        if (light->node != SCENE_NONE && poses_differ(&params[i], &light->params)) light->node = SCENE_NONE;
        if (memcmp(&params[i].position, &light->params.position, sizeof params->position) != 0 || light->node != SCENE_NONE)
            place_from_vec3(params[i].position, scene->origin, light->place); /* otherwise `place` is more precise */
        light->params = aligned(&params[i]);
    }
    scene_lights_edited(scene, lights, count);
    return FNL_OK;
}

fnl_result fnl_scene_refresh_shadows(fnl_scene *scene, const fnl_light_id *lights, uint32_t count) {
    TRY(check_handle(__func__, "scene", scene));
    if (count == 0) return FNL_OK;
    TRY(check_pointer(CALL(&scene->host), "lights", lights));
    for (uint32_t i = 0; i < count; i++) TRY(check_light_id(CALL_ELEMENT(&scene->host, i, count), scene, lights[i]));
    for (uint32_t i = 0; i < count; i++) scene->lights.data[lights[i].index].shadow_request = scene->shadow_requests;
    scene->shadow_requests++;
    return FNL_OK;
}

fnl_result fnl_scene_add_light_profile(fnl_scene *scene, const char *name, const void *data, size_t size, fnl_light_profile_id *out, float *candela) {
    TRY(check_handle(__func__, "scene", scene));
    const struct call *call = CALL(&scene->host);
    TRY(check_pointer(call, "out", out));
    *out = (fnl_light_profile_id){0};
    TRY(check_pointer(call, "name", name));
    struct file_view file = {0};
    if (!data) TRY(file_load(&scene->host, name, &file));
    fnl_result result = scene_add_profile(scene, &scene->host, name, data ? data : file.data, data ? size : file.size, out);
    file_free(&scene->host, &file);
    if (result == FNL_OK && candela) *candela = scene->profiles.data[out->index].candela;
    return result;
}

fnl_result fnl_scene_remove_light(fnl_scene *scene, fnl_light_id light) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_light_id(CALL(&scene->host), scene, light));
    if (!array_reserve(&scene->host, &scene->free_lights, scene->lights.count)) return FNL_ERROR_MEMORY;
    scene_remove_light(scene, light.index);
    scene_drop_parts(scene);
    return FNL_OK;
}

fnl_result fnl_scene_set_light_hull(fnl_scene *scene, fnl_light_id light, const fnl_vec3 *points, uint32_t count) {
    TRY(check_handle(__func__, "scene", scene));
    const struct call *call = CALL(&scene->host);
    TRY(check_light_id(call, scene, light));
    if (!points && count) return misuse(call, "points is NULL, but count is %u; NULL and 0 remove the hull", count);
    struct scene_light *target = &scene->lights.data[light.index];
    if (!points) {
        light_hull_free(scene, target);
        scene_light_changed(scene, light.index);
        return FNL_OK;
    }
    TRY(check_count(call, "count", count, 4, LIGHT_HULL_POINTS_MAX));
    for (uint32_t i = 0; i < count; i++) TRY(check_finite(call, "points", points[i]));
    struct light_hull *hull;
    TRY(light_hull_create(&scene->host, points, count, &hull));
    place_from_vec3(hull->center, scene->origin, hull->place);
    light_hull_free(scene, target);
    target->hull = hull;
    scene->hull_plane_count += hull->plane_count;
    scene_light_changed(scene, light.index);
    return FNL_OK;
}

fnl_result fnl_scene_set_light_cutoff(fnl_scene *scene, float min_roughness, float threshold) {
    TRY(check_handle(__func__, "scene", scene));
    const struct call *call = CALL(&scene->host);
    TRY(check_range(call, "min_roughness", (double)min_roughness, 0, 1, ""));
    TRY(check_range(call, "threshold", (double)threshold, 0, (double)FLT_MAX, " lux"));
    scene->cutoff_roughness = min_roughness;
    scene->cutoff_illuminance = threshold;
    scene_lights_changed(scene);
    return FNL_OK;
}
