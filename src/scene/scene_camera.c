/* SPDX-License-Identifier: MIT */
/* The cameras of a scene, and the one that frames it. */
#include "scene/scene.h"

fnl_result fnl_scene_query_camera(const fnl_scene *scene, uint32_t index, fnl_camera *out) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_pointer(CALL(&scene->host), "out", out));
    TRY(check_index(CALL(&scene->host), "index", index, scene->cameras.count, "cameras"));
    const struct scene_camera *camera = &scene->cameras.data[index];
    *out = camera->camera;
    if (camera->node == SCENE_NONE) return FNL_OK;
    const float *m = scene->nodes.data[camera->node].world.m;
    vec3 up = vec3_normalize(vec3_make(m[4], m[5], m[6])), forward = vec3_normalize(vec3_make(-m[8], -m[9], -m[10]));
    out->position = vec3_make(m[12], m[13], m[14]);
    if (vec3_dot(forward, forward) == 0) forward = vec3_make(0, 0, -1);
    if (vec3_dot(up, up) == 0) up = vec3_make(0, 1, 0);
    /* Far from the origin a target one metre away would round the direction. */
    out->target = vec3_add_scaled(out->position, forward, fmaxf(1, 0.1f * vec3_length(out->position)));
    out->up = up;
    return FNL_OK;
}

/* The field's name in the struct that holds the camera, such as "camera.up". */
static const char *in(const char *prefix, const char *field, char text[64]) {
    snprintf(text, 64, "%s%s", prefix, field);
    return text;
}

fnl_result camera_check(const struct call *call, const char *prefix, const fnl_camera *camera) {
    const double infinite = (double)FLT_MAX;
    char name[64];
    TRY(check_finite(call, in(prefix, "position", name), camera->position));
    TRY(check_finite(call, in(prefix, "target", name), camera->target));
    if (!(vec3_distance(camera->position, camera->target) > 0))
        return misuse(call, "%starget is the position, must be another point", prefix);
    TRY(check_finite(call, in(prefix, "up", name), camera->up));
    TRY(check_above(call, in(prefix, "near_distance", name), (double)camera->near_distance, 0, infinite, " metres"));
    TRY(check_range(call, in(prefix, "shift.x", name), (double)camera->shift.x, -infinite, infinite, ""));
    TRY(check_range(call, in(prefix, "shift.y", name), (double)camera->shift.y, -infinite, infinite, ""));
    TRY(check_above(call, in(prefix, "pixel_aspect", name), (double)camera->pixel_aspect, 0, infinite, ""));
    if (!camera->orthographic) {
        if (camera->vertical_fov > 0 && camera->vertical_fov < PI) return FNL_OK;
        return misuse(call, "%svertical_fov is %g, must be above 0 and below pi radians", prefix, (double)camera->vertical_fov);
    }
    TRY(check_above(call, in(prefix, "vertical_extent", name), (double)camera->vertical_extent, 0, infinite, " metres"));
    return check_above(call, in(prefix, "far_distance", name), (double)camera->far_distance, (double)camera->near_distance,
                       infinite, " metres (near_distance)");
}

fnl_result fnl_scene_add_camera(fnl_scene *scene, const char *name, const fnl_camera *camera) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_pointer(CALL(&scene->host), "camera", camera));
    TRY(camera_check(CALL(&scene->host), "", camera));
    if (!(vec3_length(camera->up) > 0)) return misuse(CALL(&scene->host), "up is 0, 0, 0, must have a length");
    struct scene_camera added = {
        .name = arena_string(&scene->arena, name ? name : ""), .node = SCENE_NONE, .camera = *camera};
    if (!added.name || !array_push(&scene->host, &scene->cameras, added)) return FNL_ERROR_MEMORY;
    return FNL_OK;
}

/** What there is to see: the geometry, else the lights, else a metre around the origin. */
static struct box box_to_frame(const fnl_scene *scene) {
    struct box bounds = scene_bounds(scene);
    if (!box_is_empty(&bounds)) return bounds;
    for (uint32_t i = 0; i < scene->lights.count; i++) {
        const struct scene_light *light = &scene->lights.data[i];
        if (!light->removed && light->params.kind != FNL_LIGHT_DIRECTIONAL) box_add_point(&bounds, light->params.position);
    }
    if (box_is_empty(&bounds)) bounds = (struct box){{-0.5f, -0.5f, -0.5f}, {0.5f, 0.5f, 0.5f}};
    return bounds;
}

/* Without the overflow of squares. */
static float length_of(vec3 v) { return (float)sqrt((double)v.x * v.x + (double)v.y * v.y + (double)v.z * v.z); }

fnl_result fnl_scene_query_framing_camera(const fnl_scene *scene, float aspect, fnl_camera *out) {
    TRY(check_handle(__func__, "scene", scene));
    TRY(check_pointer(CALL(&scene->host), "out", out));
    TRY(check_above(CALL(&scene->host), "aspect", (double)aspect, 0, (double)FLT_MAX, ""));
    struct box bounds = box_to_frame(scene);
    const vec3 most = vec3_make(1e36f, 1e36f, 1e36f); /* so that what follows stays finite */
    bounds.low = vec3_min(vec3_max(bounds.low, vec3_scale(most, -1)), most);
    bounds.high = vec3_min(vec3_max(bounds.high, vec3_scale(most, -1)), most);
    vec3 center = vec3_scale(vec3_add(bounds.low, bounds.high), 0.5f);
    vec3 half = vec3_scale(vec3_sub(bounds.high, bounds.low), 0.5f);
    float radius = fmaxf(length_of(half), 1e-4f + 1e-4f * length_of(center));

    /* From the front, a little to the right and above: the usual three-quarter view. */
    fnl_camera camera = fnl_camera_default();
    vec3 back = vec3_normalize(vec3_make(0.45f, 0.35f, 1));
    vec3 right = vec3_normalize(vec3_cross(camera.up, back)), above = vec3_cross(back, right);
    float tan_y = tanf(camera.vertical_fov * 0.5f), tan_x = tan_y * aspect;
    const float margin = 1.05f;
    float distance = 0.1f * radius;
    for (int corner = 0; corner < 8; corner++) {
        vec3 p = vec3_make(corner & 1 ? half.x : -half.x, corner & 2 ? half.y : -half.y, corner & 4 ? half.z : -half.z);
        float depth = vec3_dot(p, back), x = fabsf(vec3_dot(p, right)) * margin, y = fabsf(vec3_dot(p, above)) * margin;
        distance = fmaxf(distance, depth + fmaxf(x / tan_x, y / tan_y));
        distance = fmaxf(distance, depth + 0.05f * radius);
    }
    camera.target = center;
    camera.position = vec3_add_scaled(center, back, distance);
    camera.near_distance = 0.01f * radius;
    camera.far_distance = distance + 2 * radius;
    camera.vertical_extent = 2 * radius;
    *out = camera;
    return FNL_OK;
}
