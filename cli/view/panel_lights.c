/* SPDX-License-Identifier: MIT */
/* Lights: many at once, and one by one. */
#include "view/view.h"

#include "view/ui.h"

#include <float.h>
#include <math.h>

static void changed(struct view *v) {
    fnl_scene_query_info(v->shown.scene, &v->shown.info);
    v->shown.changed = true;
    view_want(v, 2);
}

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
        if (fnl_scene_scatter_light_shapes(v->shown.scene, &params) == FNL_OK) changed(v);
    }
}

/* In front of the camera, as bright as the scene is large. */
static void add_light(struct view *v) {
    const fnl_camera *c = &v->camera.now;
    fnl_light_params light = fnl_light_params_default();
    fnl_light_id id;
    const fnl_vec3 to = {c->target.x - c->position.x, c->target.y - c->position.y, c->target.z - c->position.z};
    light.position = (fnl_vec3){c->position.x + to.x * 0.6f, c->position.y + to.y * 0.6f, c->position.z + to.z * 0.6f};
    light.intensity = fmaxf(1e-3f, 0.4f * (to.x * to.x + to.y * to.y + to.z * to.z));
    if (fnl_scene_add_light(v->shown.scene, &light, &id) != FNL_OK) return;
    v->light = fnl_scene_count(v->shown.scene, FNL_ENTITY_LIGHT) - 1;
    changed(v);
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

static void edit_light(struct view *v) {
    fnl_light_params light;
    fnl_entity_info entity;
    const uint32_t count = fnl_scene_count(v->shown.scene, FNL_ENTITY_LIGHT);
    if (count == 0) return;
    v->light = v->light < count ? v->light : count - 1;
    ui_item_width(150);
    ui_count("light", &v->light, 0, count - 1);
    if (fnl_scene_query_light(v->shown.scene, v->light, &light) != FNL_OK ||
        fnl_scene_query_entity(v->shown.scene, FNL_ENTITY_LIGHT, v->light, &entity) != FNL_OK)
        return;
    ui_text("%s %s", fnl_value_name(FNL_ENUM_LIGHT_KIND, light.kind), entity.name ? entity.name : "");
    bool edited = false;
    ui_item_width(200);
    edited |= ui_color("colour", light.color);
    ui_item_width(150);
    edited |= ui_number(light.kind == FNL_LIGHT_DIRECTIONAL || light.kind == FNL_LIGHT_BOX ? "lux" : "candela", &light.intensity, 0, FLT_MAX, "%.4g");
    if (light.kind != FNL_LIGHT_DIRECTIONAL) edited |= show_place(&light.position);
    edited |= ui_checkbox("casts shadows", &light.casts_shadows);
    if (edited && fnl_scene_set_light(v->shown.scene, entity.id.light, &light) == FNL_OK) changed(v);
    ui_same_line();
    if (ui_button("remove") && fnl_scene_remove_light(v->shown.scene, entity.id.light) == FNL_OK) changed(v);
}

void view_panel_lights(struct view *v) {
    ui_text("%u lights", v->shown.info.light_count);
    ui_same_line();
    if (ui_button("add one")) add_light(v);
    scatter(v);
    edit_light(v);
}
