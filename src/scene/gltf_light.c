/* SPDX-License-Identifier: MIT */
/* Cameras (glTF 2.0, 3.10) and KHR_lights_punctual: what they are, and then where they stand. */
#include "scene/gltf.h"
#include "scene/light_kinds.h"

/* ---- cameras ---- */

/** Perspective views of this renderer reach to infinity and take the picture's aspect; the file's are not needed. */
static bool load_perspective(struct gltf *g, json_t *object, const struct at *at, fnl_camera *camera) {
    float far = 0, near = camera->near_distance;
    bool good = gltf_float(g, object, at, "yfov", true, 1e-4f, PI - 1e-4f, &camera->vertical_fov);
    if (gltf_float(g, object, at, "znear", true, 1e-6f, FLT_MAX, &near))
        camera->near_distance = near;
    else
        good = false;
    if (gltf_float(g, object, at, "zfar", false, 0, FLT_MAX, &far) && far <= near)
        gltf_warn(g, at, "zfar %g is not greater than znear %g; it is ignored", (double)far, (double)near);
    return good;
}

static bool load_orthographic(struct gltf *g, json_t *object, const struct at *at, fnl_camera *camera) {
    float height = 0, width = 0, near = 0, far = 0;
    camera->orthographic = true;
    bool good = gltf_float(g, object, at, "xmag", true, -FLT_MAX, FLT_MAX, &width);
    good &= gltf_float(g, object, at, "ymag", true, -FLT_MAX, FLT_MAX, &height);
    good &= gltf_float(g, object, at, "znear", true, 0, FLT_MAX, &near);
    good &= gltf_float(g, object, at, "zfar", true, 0, FLT_MAX, &far);
    if (!good) return false;
    if (!(far > near)) {
        gltf_warn(g, at, "zfar %g is not greater than znear %g; the camera is left out", (double)far, (double)near);
        return false;
    }
    if (height == 0) {
        gltf_warn(g, AT_KEY(at, "ymag"), "is 0; the camera is left out");
        return false;
    }
    camera->vertical_extent = 2 * fabsf(height);
    camera->far_distance = far;
    camera->near_distance = near;
    return true;
}

static void load_camera(struct gltf *g, json_t *object, const struct at *at, struct gltf_camera *out) {
    out->camera = fnl_camera_default();
    out->name = gltf_name(g, object, at);
    out->extras = gltf_extras(g, object);
    gltf_mask(g, object, at, "FNL_view_mask", &out->camera.view_mask);
    const char *type = gltf_string(g, object, at, "type", true);
    if (json_object_get(object, "perspective") && json_object_get(object, "orthographic"))
        gltf_warn(g, at, "has both 'perspective' and 'orthographic'; 'type' decides");
    bool perspective = type && strcmp(type, "perspective") == 0, orthographic = type && strcmp(type, "orthographic") == 0;
    if (!perspective && !orthographic) {
        if (type) gltf_warn(g, AT_KEY(at, "type"), "is unknown; the camera is left out");
        return;
    }
    json_t *lens = gltf_object(g, object, at, type, true);
    if (!lens) return;
    out->valid = perspective ? load_perspective(g, lens, AT_KEY(at, type), &out->camera)
                             : load_orthographic(g, lens, AT_KEY(at, type), &out->camera);
}

/* ---- lights ---- */

static void load_spot(struct gltf *g, json_t *object, const struct at *at, fnl_light_params *light) {
    gltf_float(g, object, at, "innerConeAngle", false, 0, PI / 2, &light->inner_cone_angle);
    gltf_float(g, object, at, "outerConeAngle", false, 0, PI / 2, &light->outer_cone_angle);
    if (light->outer_cone_angle <= 0) {
        gltf_warn(g, AT_KEY(at, "outerConeAngle"), "is 0, which leaves no light; 0.001 is used");
        light->outer_cone_angle = 0.001f;
    }
    if (light->inner_cone_angle >= light->outer_cone_angle) {
        gltf_warn(g, AT_KEY(at, "innerConeAngle"), "is not less than outerConeAngle; the cone gets a hard edge");
        light->inner_cone_angle = light->outer_cone_angle;
    }
}

static void load_member(struct gltf *g, json_t *object, const struct at *at, fnl_light_params *light, const fnl_light_member *member) {
    char key[LIGHT_KEY];
    void *value = light_value(light, member);
    const float low = fmaxf(member->low, member->useful_low);
    light_member_key(member, key);
    if (member->unit == FNL_LIGHT_UNIT_SWITCH)
        *(bool *)value = gltf_bool(g, object, at, key, member->defaults[0] > 0);
    else if (member->count == 1)
        gltf_float(g, object, at, key, false, low, member->high, value);
    else
        gltf_floats(g, object, at, key, member->count, low, member->high, value);
}

static void warn_of_shape(struct gltf *g, const struct at *at) {
    char names[256] = "";
    for (fnl_light_kind kind = 0; kind < FNL_LIGHT_KIND_COUNT; kind++) {
        const size_t used = strlen(names);
        if (!light_kinds[kind].punctual) snprintf(names + used, sizeof names - used, "%s%s", used ? ", " : "", fnl_value_name(FNL_ENUM_LIGHT_KIND, kind));
    }
    gltf_warn(g, at, "is none of %s; it is ignored", names);
}

/** The extras of a light may give it a shape that the extension lacks (docs/techniques/light-shapes.md); other programs see its type. */
static void load_shape(struct gltf *g, json_t *light_object, const struct at *light_at, fnl_light_params *light) {
    json_t *extras = json_object_get(light_object, "extras");
    if (!json_is_object(extras)) return;
    const struct at *extras_at = AT_KEY(light_at, "extras"), *at = AT_KEY(extras_at, "FNL_light_shapes");
    json_t *object = gltf_object(g, extras, extras_at, "FNL_light_shapes", false);
    const char *shape = object ? gltf_string(g, object, at, "shape", true) : NULL;
    if (!shape) return;
    fnl_light_kind kind = 0;
    while (kind < FNL_LIGHT_KIND_COUNT && (light_kinds[kind].punctual || strcmp(shape, fnl_value_name(FNL_ENUM_LIGHT_KIND, kind)) != 0)) kind++;
    if (kind == FNL_LIGHT_KIND_COUNT) {
        warn_of_shape(g, AT_KEY(at, "shape"));
        return;
    }
    light->kind = kind;
    for (uint32_t i = 0; i < light_kinds[kind].info.member_count; i++) load_member(g, object, at, light, &light_kinds[kind].info.members[i]);
}

/** And what no extension says of shadows (docs/techniques/shadows.md). */
static void load_shadows(struct gltf *g, json_t *light_object, const struct at *light_at, fnl_light_params *light) {
    json_t *extras = json_object_get(light_object, "extras");
    if (!json_is_object(extras)) return;
    const struct at *extras_at = AT_KEY(light_at, "extras"), *at = AT_KEY(extras_at, "FNL_light_shadows");
    json_t *object = gltf_object(g, extras, extras_at, "FNL_light_shadows", false);
    if (!object) return;
    light->casts_shadows = gltf_bool(g, object, at, "castsShadows", true);
    gltf_float(g, object, at, "sourceRadius", false, 0, FLT_MAX, &light->source_radius);
    gltf_float(g, object, at, "sourceAngle", false, 0, 1, &light->source_angle);
    gltf_float(g, object, at, "contactScale", false, 0, 1000, &light->contact_scale);
    const char *name = gltf_string(g, object, at, "update", false);
    uint32_t update;
    if (name && fnl_value_find(FNL_ENUM_SHADOW_UPDATE, name, &update))
        light->shadow_update = (fnl_shadow_update)update;
    else if (name)
        gltf_warn(g, AT_KEY(at, "update"), "is neither always nor on-request; it is ignored");
}

void gltf_mask(struct gltf *g, json_t *object, const struct at *at, const char *name, uint32_t *mask) {
    json_t *extras = json_object_get(object, "extras");
    uint64_t number;
    if (json_is_object(extras) && gltf_uint(g, extras, AT_KEY(at, "extras"), name, false, 0, 255, &number)) *mask = (uint32_t)number;
}

static void load_light(struct gltf *g, json_t *object, const struct at *at, struct gltf_light *out) {
    fnl_light_params *light = &out->params;
    *light = fnl_light_params_default();
    out->name = gltf_name(g, object, at);
    out->extras = gltf_extras(g, object);
    const char *type = gltf_string(g, object, at, "type", true);
    if (!type) return;
    light->kind = 0;
    while (light->kind < FNL_LIGHT_KIND_COUNT && (!light_kinds[light->kind].punctual || strcmp(type, light_kinds[light->kind].type) != 0)) light->kind++;
    if (light->kind == FNL_LIGHT_KIND_COUNT) {
        gltf_warn(g, AT_KEY(at, "type"), "is unknown; the light is left out");
        return;
    }
    gltf_floats(g, object, at, "color", 3, 0, FLT_MAX, light->color);
    gltf_float(g, object, at, "intensity", false, 0, FLT_MAX, &light->intensity);
    if (light_kinds[light->kind].info.has_range && gltf_float(g, object, at, "range", false, 0, FLT_MAX, &light->range) &&
        light->range <= 0) {
        gltf_warn(g, AT_KEY(at, "range"), "is not greater than 0; it is derived from the intensity");
        light->range = INFINITY;
    }
    if (light->kind == FNL_LIGHT_SPOT) {
        json_t *spot = gltf_object(g, object, at, "spot", true);
        if (spot) load_spot(g, spot, AT_KEY(at, "spot"), light);
    }
    load_shape(g, object, at, light);
    load_shadows(g, object, at, light);
    gltf_mask(g, object, at, "FNL_light_mask", &light->mask);
    out->valid = true;
}

static void load_lights(struct gltf *g) {
    struct gltf_extension_place place;
    json_t *extension = gltf_extension(g->root, &g->top, "KHR_lights_punctual", &place);
    json_t *array = extension ? gltf_array(g, extension, &place.extension, "lights", true) : NULL;
    const struct at *at = AT_KEY(&place.extension, "lights");
    g->light_count = gltf_count(array);
    g->lights = gltf_scratch(g, g->light_count, sizeof *g->lights);
    for (uint32_t i = 0; i < g->light_count && g->result == FNL_OK; i++) {
        json_t *object = gltf_element(g, array, at, i);
        if (object) load_light(g, object, AT_INDEX(at, i), &g->lights[i]);
    }
}

void gltf_load_cameras(struct gltf *g) {
    json_t *array = gltf_array(g, g->root, &g->top, "cameras", false);
    const struct at *at = AT_KEY(&g->top, "cameras");
    g->camera_count = gltf_count(array);
    g->cameras = gltf_scratch(g, g->camera_count, sizeof *g->cameras);
    for (uint32_t i = 0; i < g->camera_count && g->result == FNL_OK; i++) {
        json_t *object = gltf_element(g, array, at, i);
        if (object) load_camera(g, object, AT_INDEX(at, i), &g->cameras[i]);
    }
    if (g->result == FNL_OK) load_lights(g);
    if (g->result == FNL_OK) gltf_load_profiles(g);
}

/* ---- placing ---- */

static void place_camera(struct gltf *g, uint32_t node_index, struct scene_node *node) {
    const struct gltf_camera *source = &g->cameras[node->camera];
    node->camera = SCENE_NONE;
    if (!source->valid) return;
    struct scene_camera camera = {.extras = source->extras, .node = node_index, .camera = source->camera};
    camera.name = *source->name ? source->name
                  : *node->name ? node->name
                                : arena_format(&g->scene->arena, "camera%u", g->scene->cameras.count);
    if (!camera.name || !array_push(g->host, &g->scene->cameras, camera)) {
        gltf_fail_memory(g);
        return;
    }
    node->camera = g->scene->cameras.count - 1;
}

/** Only what is part of the shown scene: every such node with a camera or light gets one of its own, in node order. */
void gltf_place(struct gltf *g) {
    scene_update_transforms(g->scene);
    scene_find_origin(g->scene);
    for (uint32_t i = 0; i < g->node_count && g->result == FNL_OK; i++) {
        struct scene_node *node = &g->scene->nodes.data[i];
        if (node->camera != SCENE_NONE && g->in_scene[i])
            place_camera(g, i, node);
        else
            node->camera = SCENE_NONE;
        fnl_light_params profiled;
        if (g->in_scene[i] && gltf_read_profile_light(g, i, &profiled)) {
            g->result = scene_reserve_lights(g->scene, 1);
            if (g->result != FNL_OK) return;
            g->scene->lights.data[scene_add_light(g->scene, &profiled, i)].name = node->name;
        }
        uint32_t light = g->node_lights[i];
        if (light == SCENE_NONE || !g->in_scene[i] || !g->lights[light].valid) continue;
        g->result = scene_reserve_lights(g->scene, 1);
        if (g->result != FNL_OK) return;
        uint32_t index = scene_add_light(g->scene, &g->lights[light].params, i);
        struct scene_light *placed = &g->scene->lights.data[index];
        placed->name = *g->lights[light].name ? g->lights[light].name : node->name;
        placed->extras = g->lights[light].extras;
    }
}
