/* SPDX-License-Identifier: MIT */
/* Lights of a file that is saved: KHR_lights_punctual, with Fanal's shapes and shadows in the extras. */
#include "scene/glb.h"
#include "scene/light_kinds.h"

#define PUNCTUAL "KHR_lights_punctual"

/* ---- poses ---- */

static float nudge(float value, int steps) { return steps == 0 ? value : nextafterf(value, steps > 0 ? INFINITY : -INFINITY); }

/* A vector near a multiple of `wanted` that the loader makes exactly that of again: its length decides how it is rounded. */
static vec3 find_exact(vec3 wanted, vec3 (*make)(vec3 direction, vec3 v), vec3 direction) {
    for (int i = 0; i < 2048; i++)
        for (int k = 0; k < 27; k++) {
            const vec3 multiple = vec3_scale(wanted, 1 + (float)i * 0.000487f);
            const vec3 tried = {nudge(multiple.x, (k + 1) % 3 - 1), nudge(multiple.y, (k / 3 + 1) % 3 - 1), nudge(multiple.z, (k / 9 + 1) % 3 - 1)};
            const vec3 again = make(direction, tried);
            if (memcmp(&again, &wanted, sizeof wanted) == 0) return tried;
        }
    return wanted;
}

static vec3 make_direction(vec3 ignored, vec3 v) {
    UNUSED(ignored);
    return vec3_normalize(v);
}

mat4 glb_turn(vec3 direction, vec3 up) {
    if (fabsf(vec3_dot(direction, up)) > 1e-3f) up = light_up(direction, up); /* of no meaning for the light: scattered ones have any */
    const vec3 back = vec3_scale(find_exact(direction, make_direction, direction), -1), above = find_exact(up, light_up, direction), side = vec3_normalize(vec3_cross(above, back));
    return (mat4){{side.x, side.y, side.z, 0, above.x, above.y, above.z, 0, back.x, back.y, back.z, 0, 0, 0, 0, 1}};
}

/* ---- one light ---- */

static void write_member(struct glb *g, json_t *shape, const fnl_light_params *p, const fnl_light_member *member) {
    char key[LIGHT_KEY];
    const float *values = light_value_of(p, member);
    light_member_key(member, key);
    if (member->unit == FNL_LIGHT_UNIT_SWITCH) {
        const bool on = *(const bool *)light_value_of(p, member);
        if (on != (member->defaults[0] > 0)) glb_set(g, shape, key, json_boolean(on));
    } else {
        glb_set(g, shape, key, member->count == 1 ? glb_float(*values) : glb_floats(values, member->count));
    }
}

static void write_shape(struct glb *g, json_t *object, const fnl_light_params *p) {
    const struct light_kind *kind = &light_kinds[p->kind];
    json_t *shape = json_object();
    if (!kind->punctual) {
        glb_set(g, shape, "shape", json_string(fnl_value_name(FNL_ENUM_LIGHT_KIND, p->kind)));
        for (uint32_t i = 0; i < kind->info.member_count; i++) write_member(g, shape, p, &kind->info.members[i]);
    }
    glb_set_extra(g, object, "FNL_light_shapes", shape);
}

static void write_shadows(struct glb *g, json_t *object, const fnl_light_params *p) {
    json_t *shadows = json_object();
    if (!p->casts_shadows) glb_set(g, shadows, "castsShadows", json_false());
    if (p->contact_scale != 1) glb_set(g, shadows, "contactScale", glb_float(p->contact_scale));
    if (p->shadow_update != FNL_SHADOW_UPDATE_ALWAYS) glb_set(g, shadows, "update", json_string(fnl_value_name(FNL_ENUM_SHADOW_UPDATE, p->shadow_update)));
    if (light_kinds[p->kind].info.parallel && p->source_angle != 0) glb_set(g, shadows, "sourceAngle", glb_float(p->source_angle));
    if (!light_kinds[p->kind].info.parallel && p->source_radius != 0) glb_set(g, shadows, "sourceRadius", glb_float(p->source_radius));
    glb_set_extra(g, object, "FNL_light_shadows", shadows);
}

static bool differ(const float *a, const float *b, uint32_t count) { return memcmp(a, b, count * sizeof *a) != 0; }

/* Of `p` what differs from `base`, which `object` says so far. `light`: whose animated numbers stay the file's; SCENE_NONE: none. */
static void write_light(struct glb *g, json_t *object, const fnl_light_params *p, const fnl_light_params *base, uint32_t light) {
#define OTHER(member, count)                                                                                                                         \
    (differ((const float *)&p->member, (const float *)&base->member, count) && !glb_animates(g, SCENE_PROPERTY_LIGHT, light, offsetof(fnl_light_params, member)))
    const char *type = light_kinds[p->kind].type, *before = json_string_value(json_object_get(object, "type"));
    if (!before || strcmp(before, type) != 0) glb_set(g, object, "type", json_string(type));
    if (OTHER(color, 3)) glb_set(g, object, "color", glb_floats(p->color, 3));
    if (OTHER(intensity, 1)) glb_set(g, object, "intensity", glb_float(p->intensity));
    if (!isfinite(p->range) || light_kinds[p->kind].info.parallel)
        json_object_del(object, "range");
    else if (OTHER(range, 1))
        glb_set(g, object, "range", glb_float(p->range));
    if (strcmp(type, "spot") == 0) {
        json_t *spot = glb_object(g, object, "spot");
        if (p->kind == FNL_LIGHT_SPOT && (OTHER(inner_cone_angle, 1) || base->kind != p->kind)) glb_set(g, spot, "innerConeAngle", glb_float(p->inner_cone_angle));
        if (p->kind == FNL_LIGHT_SPOT && (OTHER(outer_cone_angle, 1) || base->kind != p->kind)) glb_set(g, spot, "outerConeAngle", glb_float(p->outer_cone_angle));
    } else {
        json_object_del(object, "spot");
    }
#undef OTHER
    write_shape(g, object, p);
    write_shadows(g, object, p);
    glb_set_extra(g, object, "FNL_light_mask", p->mask == 255 ? NULL : json_integer((json_int_t)p->mask));
}

/* ---- lights of the document ---- */

static bool same_members(const fnl_light_params *a, const fnl_light_params *b) {
    const fnl_light_kind_info *kind = &light_kinds[a->kind].info;
    for (uint32_t i = 0; i < kind->member_count; i++)
        if (memcmp(light_value_of(a, &kind->members[i]), light_value_of(b, &kind->members[i]), light_member_size(&kind->members[i])) != 0) return false;
    return true;
}

/* Whether two say the same, but for the pose. */
static bool same_light(const fnl_light_params *a, const fnl_light_params *b) {
    return a->kind == b->kind && same_members(a, b) && !differ(a->color, b->color, 3) && a->intensity == b->intensity && a->range == b->range &&
           a->source_radius == b->source_radius && a->source_angle == b->source_angle && a->casts_shadows == b->casts_shadows &&
           a->shadow_update == b->shadow_update && a->mask == b->mask && a->contact_scale == b->contact_scale && a->profile.index == b->profile.index &&
           a->profile.generation == b->profile.generation;
}

static json_t *node_of(const struct glb *g, uint32_t node) { return json_array_get(json_object_get(g->root, "nodes"), node); }
static json_t *reference_of(const struct glb *g, uint32_t node, const char *extension) {
    return json_object_get(json_object_get(node_of(g, node), "extensions"), extension);
}
static json_t *document_lights(const struct glb *g) {
    return json_object_get(json_object_get(json_object_get(g->root, "extensions"), PUNCTUAL), "lights");
}

static uint32_t light_index(const struct glb *g, uint32_t node) {
    const json_t *value = json_object_get(reference_of(g, node, PUNCTUAL), "light");
    return json_is_number(value) ? (uint32_t)json_number_value(value) : SCENE_NONE;
}

static uint32_t users_of(const struct glb *g, uint32_t light) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < g->node_count; i++) count += light_index(g, i) == light;
    return count;
}

/* EXT_lights_ies has no intensity but a factor of the profile's: one that gives exactly this again, or the nearest. */
static void patch_profiled(struct glb *g, uint32_t node, const fnl_light_params *now, const fnl_light_params *base) {
    json_t *reference = reference_of(g, node, "EXT_lights_ies");
    const float candela = g->scene->profiles.data[now->profile.index].candela;
    float multiplier = now->intensity / candela;
    for (int i = 0; i < 4 && multiplier * candela != now->intensity; i++) multiplier = nextafterf(multiplier, multiplier * candela < now->intensity ? INFINITY : 0);
    if (now->intensity != base->intensity) glb_set(g, reference, "multiplier", glb_float(multiplier));
    if (differ(now->color, base->color, 3)) glb_set(g, reference, "color", glb_floats(now->color, 3));
    if (now->source_radius != base->source_radius || now->casts_shadows != base->casts_shadows || now->shadow_update != base->shadow_update || now->mask != base->mask || now->contact_scale != base->contact_scale || now->kind != base->kind || now->range != base->range)
        glb_left_out(g, "the kind, range, shadows or mask of a light with a profile");
}

/* The object of a light that is only this one's, to be changed. */
static json_t *own_light(struct glb *g, uint32_t node, uint32_t *index) {
    json_t *lights = document_lights(g);
    *index = light_index(g, node);
    if (users_of(g, *index) > 1) *index = glb_append(g, lights, json_deep_copy(json_array_get(lights, *index)));
    return json_array_get(lights, *index);
}

static void add_light_node(struct glb *g, const struct scene_light *light, const char *name, uint32_t index) {
    const fnl_light_params *p = &light->params;
    json_t *node = json_object();
    const fnl_light_kind_info *kind = &light_kinds[p->kind].info;
    const mat4 turn = kind->has_direction ? glb_turn(p->direction, p->up) : mat4_identity();
    double place[3] = {0, 0, 0};
    if (kind->has_position && light->node == SCENE_NONE) memcpy(place, light->place, sizeof place);
    else if (kind->has_position) place_from_vec3(p->position, g->scene->origin, place);
    if (name && *name) glb_set(g, node, "name", glb_text(g, name));
    glb_set(g, glb_extension(g, node, PUNCTUAL), "light", json_integer((json_int_t)index));
    glb_add_root(g, node, &turn, place);
}

static void patch_light(struct glb *g, uint32_t index, const struct scene_light *now, const struct scene_light *base) {
    const bool profiled = base->params.profile.generation != 0;
    const char *extension = profiled ? "EXT_lights_ies" : PUNCTUAL;
    if (!now) { /* removed */
        if (!g->scene->nodes.data[base->node].removed) glb_remove_extension(node_of(g, base->node), extension);
        return;
    }
    if (now->node == base->node && same_light(&now->params, &base->params)) return;
    if (profiled && now->node == base->node && now->params.profile.generation == base->params.profile.generation) {
        patch_profiled(g, base->node, &now->params, &base->params);
        return;
    }
    if (profiled) {
        glb_left_out(g, "the profile of light %u, which stands on no node of its own any more", index);
        glb_remove_extension(node_of(g, base->node), extension);
        return;
    }
    if (now->params.profile.generation) glb_left_out(g, "the profile of light %u", index);
    uint32_t place;
    json_t *object = own_light(g, base->node, &place);
    write_light(g, object, &now->params, &base->params, index);
    if (now->node == base->node) {
        glb_set(g, reference_of(g, base->node, PUNCTUAL), "light", json_integer((json_int_t)place));
        return;
    }
    glb_remove_extension(node_of(g, base->node), PUNCTUAL); /* it was put elsewhere */
    add_light_node(g, now, NULL, place);
}

/* ---- lights that were added ---- */

static bool is_environments(const fnl_scene *scene, uint32_t index) {
    const struct scene_environment *e = &scene->environment;
    for (uint32_t i = 0; i < e->source_count; i++)
        if (e->lights[i].index == index && e->lights[i].generation == scene->lights.data[index].generation) return true;
    return false;
}

static void add_light(struct glb *g, uint32_t index) {
    const struct scene_light *light = &g->scene->lights.data[index];
    const fnl_light_params usual = fnl_light_params_default();
    json_t *object = json_object();
    glb_set_name(g, object, light->name, light->extras);
    write_light(g, object, &light->params, &usual, SCENE_NONE);
    if (light->params.profile.generation) glb_left_out(g, "the profile of light %u", index);
    json_t *lights = glb_array(g, glb_extension(g, g->root, PUNCTUAL), "lights");
    const uint32_t place = glb_append(g, lights, object), node = light->node == SCENE_NONE ? SCENE_NONE : g->nodes[light->node];
    if (node == SCENE_NONE || reference_of(g, node, PUNCTUAL)) /* it follows a node that was added with it, or stands alone */
        add_light_node(g, light, light->name, place);
    else
        glb_set(g, glb_extension(g, node_of(g, node), PUNCTUAL), "light", json_integer((json_int_t)place));
}

void glb_save_lights(struct glb *g) {
    const fnl_scene *now = g->scene, *file = g->file;
    uint32_t hulls = 0;
    for (uint32_t i = 0; file && i < file->lights.count && g->result == FNL_OK; i++) {
        const struct scene_light *base = &file->lights.data[i], *light = i < now->lights.count ? &now->lights.data[i] : NULL;
        const bool same = light && !light->removed && light->generation == base->generation;
        if (!is_environments(file, i)) patch_light(g, i, same ? light : NULL, base);
    }
    for (uint32_t i = 0; i < now->lights.count && g->result == FNL_OK; i++) {
        const struct scene_light *light = &now->lights.data[i];
        if (light->removed) continue;
        hulls += light->hull != NULL;
        const bool of_file = file && i < file->lights.count && file->lights.data[i].generation == light->generation;
        if (!of_file && !is_environments(now, i)) add_light(g, i);
    }
    if (hulls) glb_left_out(g, "the hulls of %u lights", hulls);
    json_t *lights = document_lights(g);
    if (lights && json_array_size(lights) == 0) glb_remove_extension(g->root, PUNCTUAL);
}
