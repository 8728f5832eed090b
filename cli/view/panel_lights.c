/* SPDX-License-Identifier: MIT */
/* Lights: many at once, and one by one. */
#include "view/view.h"

#include "view/ui.h"

#include <float.h>
#include <math.h>

static void scatter(struct view *v) {
    static const uint32_t counts[] = {16, 64, 256, 1024, 4096};
    char label[16];
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
    light->intensity = fmaxf(1e-3f, 0.4f * (to.x * to.x + to.y * to.y + to.z * to.z));
    uint32_t index;
    if (view_edit_do(v, &edit) && view_find(v, FNL_ENTITY_LIGHT, edit.id, &index)) view_select_light(v, index);
}

static bool show_place(fnl_vec3 *place) {
    bool moved = false;
    ui_item_width(76);
    moved |= ui_number("x", &place->x, -FLT_MAX, FLT_MAX, "%.3f");
    ui_same_line();
    ui_item_width(76);
    moved |= ui_number("y", &place->y, -FLT_MAX, FLT_MAX, "%.3f");
    ui_same_line();
    ui_item_width(76);
    return moved | ui_number("z", &place->z, -FLT_MAX, FLT_MAX, "%.3f");
}

void view_show_light(struct view *v, uint32_t index) {
    fnl_light_params light;
    fnl_entity_info entity;
    if (fnl_scene_query_light(v->shown.scene, index, &light) != FNL_OK || fnl_scene_query_entity(v->shown.scene, FNL_ENTITY_LIGHT, index, &entity) != FNL_OK)
        return;
    const fnl_light_params before = light;
    const struct view_id id = {entity.id.light.index, entity.id.light.generation};
    ui_text("%s %s", fnl_value_name(FNL_ENUM_LIGHT_KIND, light.kind), entity.name ? entity.name : "");
    bool edited = false;
    ui_item_width(200);
    edited |= ui_color("colour", light.color);
    ui_item_width(150);
    edited |= ui_number(light.kind == FNL_LIGHT_DIRECTIONAL || light.kind == FNL_LIGHT_BOX ? "lux" : "candela", &light.intensity, 0, FLT_MAX, "%.4g");
    if (light.kind != FNL_LIGHT_DIRECTIONAL) edited |= show_place(&light.position);
    edited |= ui_checkbox("casts shadows", &light.casts_shadows);
    bool requested = light.shadow_update == FNL_SHADOW_UPDATE_ON_REQUEST;
    if (light.casts_shadows && ui_checkbox("keeps its shadow map", &requested)) {
        light.shadow_update = requested ? FNL_SHADOW_UPDATE_ON_REQUEST : FNL_SHADOW_UPDATE_ALWAYS;
        edited = true;
    }
    struct view_edit edit = {.kind = VIEW_EDIT_LIGHT, .id = id, .before.light = before, .after.light = light};
    if (edited) view_edit_do(v, &edit);
    ui_same_line();
    edit.kind = VIEW_EDIT_LIGHT_THERE;
    if (ui_button("remove")) view_edit_do(v, &edit);
}

static void choose_light(struct view *v) {
    const uint32_t count = fnl_scene_count(v->shown.scene, FNL_ENTITY_LIGHT);
    if (count == 0) return;
    v->light = v->light < count ? v->light : count - 1;
    ui_item_width(150);
    if (ui_count("light", &v->light, 0, count - 1)) view_select_light(v, v->light);
    view_show_light(v, v->light);
}

void view_panel_lights(struct view *v) {
    ui_text("%u lights", v->shown.info.light_count);
    ui_same_line();
    if (ui_button("add one")) add_light(v);
    ui_same_line();
    if (ui_checkbox("show lights", &v->select.shows_lights)) view_want(v, 2);
    ui_tooltip("L");
    scatter(v);
    choose_light(v);
}
