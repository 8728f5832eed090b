/* SPDX-License-Identifier: MIT */
/* Lights: many at once, and one by one. */
#include "view/view.h"

#include <float.h>
#include <math.h>
#include <string.h>

#define DEGREES 57.2957795f

static void scatter(struct view *v) {
    static const uint32_t counts[] = {16, 64, 256, 1024, 4096};
    char label[16];
    ui_align_text();
    ui_text("scatter");
    for (uint32_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        snprintf(label, sizeof label, "%u", counts[i]);
        ui_same_line();
        if (!ui_button(label)) continue;
        fnl_scatter_params params = v->world.scatter;
        params.count = counts[i];
        params.seed = v->shown.info.light_count; /* others than before */
        if (fnl_scene_scatter_light_shapes(v->shown.scene, &params) == FNL_OK) view_select_changed(v);
    }
}

/* In front of the camera, as bright as the scene is large. */
static void add_light(struct view *v) {
    const fnl_camera *c = &v->camera.now;
    struct view_edit edit = {.kind = VIEW_EDIT_LIGHT_THERE, .comes = true, .after.light = fnl_light_params_default()};
    fnl_light_params *light = &edit.after.light;
    const fnl_vec3 to = {c->target.x - c->position.x, c->target.y - c->position.y, c->target.z - c->position.z};
    light->position = (fnl_vec3){c->position.x + to.x * 0.6f, c->position.y + to.y * 0.6f, c->position.z + to.z * 0.6f};
    light->direction = to;
    light->intensity = fmaxf(1e-3f, 0.4f * (to.x * to.x + to.y * to.y + to.z * to.z));
    uint32_t index;
    if (view_edit_do(v, &edit) && view_find(v, FNL_ENTITY_LIGHT, edit.id, &index)) view_select_light(v, index);
}

/* ---- several ---- */

static struct view_id id_at(const struct view *v, uint32_t index) {
    fnl_entity_info entity;
    if (fnl_scene_query_entity(v->shown.scene, FNL_ENTITY_LIGHT, index, &entity) != FNL_OK) return (struct view_id){0};
    return (struct view_id){entity.id.light.index, entity.id.light.generation};
}

static uint32_t find_id(const struct view_id *ids, uint32_t count, struct view_id id) {
    for (uint32_t i = 0; i < count; i++)
        if (ids[i].index == id.index && ids[i].generation == id.generation) return i;
    return UINT32_MAX;
}

/* The value of a member that only some kinds have: a bool or floats. */
static void *member_of(fnl_light_params *light, const fnl_light_member *member) { return (char *)light + member->offset; }

static void copy_changed(fnl_light_params *light, const fnl_light_params *before, const fnl_light_params *after, size_t offset, size_t size) {
    const char *new = (const char *)after + offset;
    if (memcmp((const char *)before + offset, new, size) != 0) memcpy((char *)light + offset, new, size);
}

/* What an edit has changed of one light, for another; each has its own place. */
static void change_likewise(fnl_light_params *light, const fnl_light_params *before, const fnl_light_params *after) {
    const fnl_light_kind_info *kind = fnl_light_kind_find(after->kind);
#define LIKEWISE(member) copy_changed(light, before, after, offsetof(fnl_light_params, member), sizeof after->member)
    LIKEWISE(kind);
    LIKEWISE(direction);
    LIKEWISE(color);
    LIKEWISE(intensity);
    LIKEWISE(range);
    LIKEWISE(source_radius);
    LIKEWISE(source_angle);
    LIKEWISE(casts_shadows);
    LIKEWISE(mask);
    LIKEWISE(contact_scale);
    LIKEWISE(shadow_update);
#undef LIKEWISE
    for (uint32_t i = 0; i < kind->member_count; i++) {
        const fnl_light_member *m = &kind->members[i];
        copy_changed(light, before, after, m->offset, m->unit == FNL_LIGHT_UNIT_SWITCH ? sizeof(bool) : m->count * sizeof(float));
    }
}

static void edit_light(struct view *v, uint32_t index, const fnl_light_params *before, const fnl_light_params *after) {
    const struct view_marked *m = &v->marked;
    const struct view_id own = id_at(v, index);
    struct view_edit edit = {.kind = VIEW_EDIT_LIGHT, .id = own, .before.light = *before, .after.light = *after};
    view_edit_do(v, &edit);
    if (find_id(m->ids, m->count, own) == UINT32_MAX) return;
    for (uint32_t i = 0; i < m->count; i++) {
        uint32_t other;
        edit.id = m->ids[i];
        if ((edit.id.index == own.index && edit.id.generation == own.generation) || !view_find(v, FNL_ENTITY_LIGHT, edit.id, &other) ||
            fnl_scene_query_light(v->shown.scene, other, &edit.before.light) != FNL_OK)
            continue;
        edit.after.light = edit.before.light;
        change_likewise(&edit.after.light, before, after);
        view_edit_do(v, &edit);
    }
}

/* A light that is off has an intensity of 0; the window knows what it was. */
static void switch_light(struct view *v, uint32_t index, bool on) {
    struct view_marked *m = &v->marked;
    fnl_light_params before;
    if (fnl_scene_query_light(v->shown.scene, index, &before) != FNL_OK || (before.intensity > 0) == on) return;
    const struct view_id id = id_at(v, index);
    uint32_t at = find_id(m->off, m->off_count, id);
    struct view_edit edit = {.kind = VIEW_EDIT_LIGHT, .id = id, .before.light = before, .after.light = before};
    if (!on) {
        if (at == UINT32_MAX) at = m->off_count < VIEW_OFF ? m->off_count++ : VIEW_OFF - 1;
        m->off[at] = id;
        m->intensity[at] = before.intensity;
        edit.after.light.intensity = 0;
    } else {
        edit.after.light.intensity = at != UINT32_MAX ? m->intensity[at] : 1;
    }
    view_edit_do(v, &edit);
}

/* With those that change together with it. */
static void switch_all(struct view *v, uint32_t index, bool on) {
    const struct view_marked *m = &v->marked;
    uint32_t other;
    switch_light(v, index, on);
    for (uint32_t i = 0; i < m->count && find_id(m->ids, m->count, id_at(v, index)) != UINT32_MAX; i++)
        if (view_find(v, FNL_ENTITY_LIGHT, m->ids[i], &other)) switch_light(v, other, on);
}

static void mark(struct view *v, uint32_t index) {
    struct view_marked *m = &v->marked;
    const struct view_id id = id_at(v, index);
    const uint32_t at = find_id(m->ids, m->count, id);
    if (at != UINT32_MAX)
        m->ids[at] = m->ids[--m->count];
    else if (m->count < VIEW_MARKED)
        m->ids[m->count++] = id;
}

/* ---- one ---- */

static bool show_number(const char *label, float *value, float low, float high, const char *format) {
    ui_item_width(150);
    return ui_number(label, value, low, high, format);
}

static bool show_degrees(const char *label, float *radians, float low, float high) {
    float degrees = *radians * DEGREES;
    if (!show_number(label, &degrees, low * DEGREES, high * DEGREES, "%.1f degrees")) return false;
    *radians = degrees / DEGREES;
    return true;
}

static bool show_metres(const char *name, float *value, float low, float high) {
    char label[64];
    snprintf(label, sizeof label, "%s, m", name);
    return show_number(label, value, low, high, "%.3g");
}

static bool show_kind(fnl_light_params *light) {
    bool edited = false;
    ui_item_width(150);
    if (!ui_combo("kind", fnl_value_name(FNL_ENUM_LIGHT_KIND, light->kind))) return false;
    for (uint32_t i = 0; i < FNL_LIGHT_KIND_COUNT; i++) {
        if (!ui_choice(fnl_value_name(FNL_ENUM_LIGHT_KIND, i), i == (uint32_t)light->kind)) continue;
        light->kind = (fnl_light_kind)i;
        edited = true;
    }
    ui_combo_end();
    return edited;
}

static bool show_range(fnl_light_params *light) {
    bool edited = false, unlimited = isinf(light->range);
    if (ui_checkbox("no range limit", &unlimited)) {
        light->range = unlimited ? INFINITY : fmaxf(fnl_light_range(light, 1, 0.05f), 1e-3f);
        edited = true;
    }
    ui_tooltip("The light reaches everything; off: it ends at the range below");
    return edited | (!unlimited && show_number("range, m", &light->range, 1e-3f, FLT_MAX, "%.3g"));
}

static bool show_value(const fnl_light_member *m, uint32_t i, float *value, float high) {
    const float low = fmaxf(m->low, m->useful_low);
    switch (m->unit) {
    case FNL_LIGHT_UNIT_RADIANS:
        return show_degrees(m->labels[i], value, low, high);
    case FNL_LIGHT_UNIT_METERS:
        return show_metres(m->labels[i], value, low > 0 ? fmaxf(low, 1e-3f) : 0, high);
    default:
        return show_number(m->labels[i], value, low, high, "%.3g");
    }
}

static bool show_member(fnl_light_params *light, const fnl_light_kind_info *kind, const fnl_light_member *m) {
    float *values = member_of(light, m), high = m->high;
    bool edited = false;
    for (uint32_t i = 0; m->at_most && i < kind->member_count; i++)
        if (strcmp(kind->members[i].name, m->at_most) == 0) high = *(float *)member_of(light, &kind->members[i]);
    for (uint32_t i = 0; i < m->count; i++) {
        edited |= m->unit == FNL_LIGHT_UNIT_SWITCH ? ui_checkbox(m->labels[i], member_of(light, m)) : show_value(m, i, &values[i], high);
        if (*m->hint) ui_tooltip(m->hint);
        if (m->at_most) values[i] = fminf(values[i], high);
    }
    return edited;
}

/* Members that only some kinds have. Limits come first, so the members they limit follow in the same frame. */
static bool show_shape(fnl_light_params *light) {
    const fnl_light_kind_info *kind = fnl_light_kind_find(light->kind);
    bool edited = false;
    for (int limited = 0; limited < 2; limited++)
        for (uint32_t i = 0; i < kind->member_count; i++)
            if ((kind->members[i].at_most != NULL) == limited) edited |= show_member(light, kind, &kind->members[i]);
    if (kind->has_source_angle) edited |= show_degrees("source size", &light->source_angle, 0, 1);
    if (kind->has_source_radius) edited |= show_metres("source radius", &light->source_radius, 0, 1e4f);
    if (kind->has_source_angle || kind->has_source_radius) ui_tooltip("Size of the light itself: larger means softer shadows, if Shadow edges are soft");
    return edited;
}

static bool put_at_camera(const struct view *v, fnl_light_params *light) {
    const fnl_camera *c = &v->camera.now;
    if (!ui_button("move to the camera")) return false;
    light->position = c->position;
    light->direction = (fnl_vec3){c->target.x - c->position.x, c->target.y - c->position.y, c->target.z - c->position.z};
    return true;
}

void view_show_light(struct view *v, uint32_t index) {
    fnl_light_params light;
    fnl_entity_info entity;
    if (fnl_scene_query_light(v->shown.scene, index, &light) != FNL_OK || fnl_scene_query_entity(v->shown.scene, FNL_ENTITY_LIGHT, index, &entity) != FNL_OK)
        return;
    const fnl_light_params before = light;
    const struct view_id id = {entity.id.light.index, entity.id.light.generation};
    ui_text("light %u %s", index, entity.name ? entity.name : "");
    if (find_id(v->marked.ids, v->marked.count, id) != UINT32_MAX && v->marked.count > 1)
        ui_note(v->marked.count == 2 ? "The other selected light changes with it, but keeps its position." : "The %u other selected lights change with it, but keep their positions.", v->marked.count - 1);
    bool on = light.intensity > 0;
    if (ui_checkbox("on", &on)) {
        switch_all(v, index, on);
        return;
    }
    ui_same_line();
    bool edited = show_kind(&light);
    const fnl_light_kind_info *kind = fnl_light_kind_find(light.kind);
    ui_item_width(200);
    edited |= ui_color("color", light.color);
    edited |= show_number(kind->parallel ? "lux" : "candela", &light.intensity, 0, FLT_MAX, "%.4g");
    if (kind->has_range) edited |= show_range(&light);
    edited |= show_shape(&light);
    if (kind->has_position) edited |= view_show_vector("position, m", &light.position, "%.3f");
    if (kind->has_direction) edited |= view_show_vector("direction", &light.direction, "%.3f");
    edited |= put_at_camera(v, &light);
    edited |= view_show_mask("light mask", &light.mask);
    edited |= ui_checkbox("casts shadows", &light.casts_shadows);
    if (light.casts_shadows && v->frame.shadow.contact_length > 0) edited |= show_number("contact shadow scale", &light.contact_scale, 0, 1000, "%.3g");
    bool requested = light.shadow_update == FNL_SHADOW_UPDATE_ON_REQUEST;
    if (light.casts_shadows && ui_checkbox("freeze its shadow map", &requested)) {
        light.shadow_update = requested ? FNL_SHADOW_UPDATE_ON_REQUEST : FNL_SHADOW_UPDATE_ALWAYS;
        edited = true;
    }
    if (edited) edit_light(v, index, &before, &light);
    ui_same_line();
    struct view_edit edit = {.kind = VIEW_EDIT_LIGHT_THERE, .id = id, .before.light = before, .after.light = light};
    if (ui_button("remove")) view_edit_do(v, &edit);
}

/* ---- the panel ---- */

static void show_list(struct view *v, uint32_t count) {
    uint32_t first, end;
    ui_list("lights", fminf(8, (float)count), count, &first, &end);
    for (uint32_t i = first; i < end; i++) {
        fnl_light_params light;
        fnl_entity_info entity;
        char label[128];
        if (fnl_scene_query_light(v->shown.scene, i, &light) != FNL_OK || fnl_scene_query_entity(v->shown.scene, FNL_ENTITY_LIGHT, i, &entity) != FNL_OK) continue;
        bool on = light.intensity > 0;
        snprintf(label, sizeof label, "##on %u", i);
        if (ui_checkbox(label, &on)) switch_light(v, i, on);
        ui_tooltip("On or off");
        ui_same_line();
        const bool named = entity.name && entity.name[0];
        snprintf(label, sizeof label, "%u %.60s##light", i, named ? entity.name : fnl_value_name(FNL_ENUM_LIGHT_KIND, light.kind));
        const bool marked = find_id(v->marked.ids, v->marked.count, id_at(v, i)) != UINT32_MAX;
        if (!ui_choice(label, marked || i == v->light)) continue;
        if (v->modifiers & VIEW_CONTROL) {
            if (v->marked.count == 0 && v->light < count) mark(v, v->light);
            mark(v, i);
        } else {
            v->marked.count = 0;
        }
        view_select_light(v, i);
    }
    ui_list_end();
}

void view_panel_lights(struct view *v) {
    const uint32_t count = fnl_scene_count(v->shown.scene, FNL_ENTITY_LIGHT);
    ui_text("%u %s", v->shown.info.light_count, view_plural(v->shown.info.light_count, "light", "lights"));
    if (ui_button("add a light")) add_light(v);
    ui_tooltip("Adds a light in front of the camera");
    ui_same_line();
    if (ui_checkbox("show lights", &v->select.shows_lights)) view_want(v, 2);
    ui_tooltip("As dots in the picture (L); Ctrl+click selects one");
    scatter(v);
    if (count == 0) return;
    v->light = v->light < count ? v->light : count - 1;
    show_list(v, count);
    ui_note("Ctrl+click selects several, which then change together.");
    view_show_light(v, v->light);
}
