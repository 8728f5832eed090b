/* SPDX-License-Identifier: MIT */
/* What is picked: an object with its material, a light, or a decal; all of it can be changed. */
#include "view/view.h"

#include "view/ui.h"
#include "view/view_maths.h"

#include <float.h>
#include <string.h>

#define DEGREES 57.2957795f

bool view_show_mask(const char *label, uint32_t *mask) {
    char shown[16] = "all";
    bool edited = false;
    if (*mask != 255) snprintf(shown, sizeof shown, "0x%02x", *mask);
    ui_item_width(100);
    if (!ui_combo(label, shown)) return false;
    for (uint32_t bit = 0; bit < 8; bit++) {
        char name[16];
        snprintf(name, sizeof name, "bit %u", bit);
        if (!ui_choice(name, *mask >> bit & 1)) continue;
        *mask ^= 1u << bit;
        edited = true;
    }
    ui_combo_end();
    return edited;
}

bool view_show_vector(const char *name, fnl_vec3 *value, const char *format) {
    static const char *const axes[] = {"x", "y", "z"};
    float *numbers[] = {&value->x, &value->y, &value->z};
    bool edited = false;
    for (int i = 0; i < 3; i++) {
        char label[48];
        snprintf(label, sizeof label, "##%s %s", name, axes[i]);
        ui_item_width(66);
        edited |= ui_number(label, numbers[i], -FLT_MAX, FLT_MAX, format);
        ui_same_line();
    }
    ui_text("%s", name);
    return edited;
}

static bool show_factor(const char *label, float *value, float low, float high) {
    ui_item_width(150);
    return ui_number(label, value, low, high, "%.3f");
}

static bool show_color(const char *label, float rgb[3]) {
    ui_item_width(200);
    return ui_color(label, rgb);
}

/* ---- objects ---- */

static void show_transform(struct view *v, const fnl_instance_info *instance) {
    struct view_typed *t = &v->select.typed;
    struct maths_parts parts;
    if (!t->parts || memcmp(&t->of, &instance->transform, sizeof t->of) != 0) {
        t->of = instance->transform;
        t->parts = maths_part(&t->of, &parts);
        if (t->parts) {
            t->place = parts.place;
            t->degrees = maths_scale(parts.turn, DEGREES);
            t->scale = parts.scale;
        }
    }
    if (!t->parts) {
        ui_note("Its matrix is flat or shears: handles move it, but it has no rotation and scale.");
        return;
    }
    struct view_edit edit = {.kind = VIEW_EDIT_TRANSFORM, .id = v->select.id, .before.transform = instance->transform};
    bool edited = view_show_vector("position, m", &t->place, "%.3f");
    ui_tooltip("Metres, relative to its parent");
    edited |= view_show_vector("rotation, deg", &t->degrees, "%.1f");
    ui_tooltip("Degrees about x, then y, then z");
    edited |= view_show_vector("scale", &t->scale, "%.3f");
    if (!edited) return;
    parts = (struct maths_parts){t->place, maths_scale(t->degrees, 1 / DEGREES), t->scale};
    edit.after.transform = maths_compose(&parts);
    if (view_edit_do(v, &edit))
        t->of = edit.after.transform;
    else
        t->parts = false;
}

static const char *name_of(const struct view *v, fnl_entity kind, uint32_t index) {
    fnl_entity_info info;
    return fnl_scene_query_entity(v->shown.scene, kind, index, &info) == FNL_OK ? info.name : "";
}

static void show_object(struct view *v, uint32_t index) {
    fnl_instance_info instance;
    fnl_mesh_info mesh;
    if (fnl_scene_query_instance(v->shown.scene, index, &instance) != FNL_OK) return;
    ui_text("object %u %s", index, name_of(v, FNL_ENTITY_INSTANCE, index));
    if (instance.mesh.generation && fnl_scene_query_mesh(v->shown.scene, instance.mesh.index, v->select.primitive, &mesh) == FNL_OK) {
        const uint32_t corners = mesh.params.index_count ? mesh.params.index_count : mesh.params.vertex_count;
        ui_text("mesh %u %s", instance.mesh.index, name_of(v, FNL_ENTITY_MESH, instance.mesh.index));
        ui_text("primitive %u of %u: %u %s", v->select.primitive, mesh.primitive_count, corners / mesh.corner_count,
                mesh.corner_count == 3   ? "triangles"
                : mesh.corner_count == 2 ? "lines"
                                         : "points");
    }
    struct view_edit edit = {.kind = VIEW_EDIT_VISIBLE, .id = v->select.id, .before.visible = instance.visible, .after.visible = instance.visible};
    if (ui_checkbox("visible", &edit.after.visible)) view_edit_do(v, &edit);
    edit = (struct view_edit){.kind = VIEW_EDIT_LIGHT_MASK, .id = v->select.id, .before.light_mask = instance.light_mask, .after.light_mask = instance.light_mask};
    if (view_show_mask("light mask", &edit.after.light_mask)) view_edit_do(v, &edit);
    edit = (struct view_edit){.kind = VIEW_EDIT_VIEW_MASK, .id = v->select.id, .before.view_mask = instance.view_mask, .after.view_mask = instance.view_mask};
    if (view_show_mask("view mask", &edit.after.view_mask)) view_edit_do(v, &edit);
    if (instance.joint_count)
        ui_note("%u joints move it.", instance.joint_count);
    else
        show_transform(v, &instance);
}

/* ---- materials ---- */

static bool show_alpha_mode(fnl_material_params *m) {
    static const char *const names[] = {"opaque", "mask", "blend"};
    bool edited = false;
    ui_item_width(150);
    if (ui_combo("alpha", names[m->alpha_mode])) {
        for (int i = 0; i < 3; i++) {
            if (!ui_choice(names[i], (int)m->alpha_mode == i)) continue;
            m->alpha_mode = (fnl_alpha_mode)i;
            edited = true;
        }
        ui_combo_end();
    }
    if (m->alpha_mode == FNL_ALPHA_MASK) edited |= show_factor("cutoff", &m->alpha_cutoff, 0, 1);
    return edited;
}

static bool show_core(fnl_material_params *m) {
    bool edited = show_color("base color", m->base_color);
    edited |= show_factor("opacity", &m->base_color[3], 0, 1);
    edited |= show_factor("metallic", &m->metallic, 0, 1);
    edited |= show_factor("roughness", &m->roughness, 0, 1);
    edited |= show_color("emission", m->emissive);
    ui_tooltip("cd/m^2");
    edited |= show_alpha_mode(m);
    edited |= ui_checkbox("double-sided", &m->double_sided);
    ui_same_line();
    edited |= ui_checkbox("unlit", &m->unlit);
    ui_same_line();
    edited |= ui_checkbox("casts shadows", &m->casts_shadows);
    edited |= show_factor("normal scale", &m->normal_scale, -4, 4);
    edited |= show_factor("occlusion", &m->occlusion_strength, 0, 1);
    if (m->ior >= 1) edited |= show_factor("index of refraction", &m->ior, 1, 3);
    edited |= show_factor("specular", &m->specular, 0, 1);
    return edited | show_color("specular color", m->specular_color);
}

static bool show_layers(fnl_material_params *m) {
    fnl_layer_number number;
    bool edited = false;
    for (uint32_t i = 0; fnl_layer_number_query(i, &number); i++) {
        float *value = (float *)(void *)((char *)m + number.offset);
        const float *under = (const float *)(const void *)((const char *)m + number.under);
        if (!*number.label || (number.under && !(*under > 0))) continue;
        edited |= number.count == 3 ? show_color(number.label, value) : show_factor(number.label, value, number.least, number.most);
        if (*number.help) ui_tooltip(number.help);
    }
    return edited;
}

static void show_texture(const struct view *v, const char *what, fnl_image_id id) {
    fnl_image_info info;
    if (!id.generation || fnl_scene_query_image(v->shown.scene, id.index, &info) != FNL_OK) return;
    ui_note("%s: %s, %u x %u, %s", what, info.name, info.width, info.height, info.file_kind);
}

static void show_textures(const struct view *v, const fnl_material_params *m) {
    show_texture(v, "base color", m->base_color_image);
    show_texture(v, "metallic, roughness", m->metallic_roughness_image);
    show_texture(v, "normals", m->normal_image);
    show_texture(v, "occlusion", m->occlusion_image);
    show_texture(v, "emission", m->emissive_image);
    fnl_layer_texture texture;
    for (uint32_t i = 0; fnl_layer_texture_query(i, &texture); i++)
        show_texture(v, texture.label, *(const fnl_image_id *)(const void *)((const char *)m + texture.offset));
}

static void show_material(struct view *v) {
    const int32_t index = v->select.material;
    struct view_edit edit = {.kind = VIEW_EDIT_MATERIAL};
    fnl_entity_info info;
    if (index < 0) {
        ui_note("glTF's default material");
        return;
    }
    if (fnl_scene_query_entity(v->shown.scene, FNL_ENTITY_MATERIAL, (uint32_t)index, &info) != FNL_OK ||
        fnl_scene_query_material(v->shown.scene, (uint32_t)index, &edit.before.material) != FNL_OK)
        return;
    edit.id = (struct view_id){info.id.material.index, info.id.material.generation};
    edit.after.material = edit.before.material;
    ui_text("%d %s", index, info.name);
    bool edited = show_core(&edit.after.material);
    if (ui_header("layers", false)) edited |= show_layers(&edit.after.material);
    show_textures(v, &edit.before.material);
    if (edited) view_edit_do(v, &edit);
}

/* ---- decals ---- */

static void show_decal(struct view *v, uint32_t index) {
    struct view_edit edit = {.kind = VIEW_EDIT_DECAL, .id = v->select.id};
    fnl_mat4 world, own;
    if (fnl_scene_query_decal(v->shown.scene, index, &edit.before.decal) != FNL_OK || !view_select_matrices(v, &world, &own)) return;
    edit.after.decal = edit.before.decal;
    fnl_decal_params *d = &edit.after.decal;
    fnl_vec3 place = maths_column(&own, 3);
    ui_text("decal %u, %s", index, fnl_value_name(FNL_ENUM_DECAL_KIND, d->kind));
    ui_text("%.4g x %.4g x %.4g m", (double)maths_length(maths_column(&world, 0)), (double)maths_length(maths_column(&world, 1)),
            (double)maths_length(maths_column(&world, 2)));
    bool edited = view_show_vector("position, m", &place, "%.3f");
    ui_tooltip("Metres, relative to what it moves with");
    d->transform.m[12] = place.x, d->transform.m[13] = place.y, d->transform.m[14] = place.z;
    edited |= show_color("color", d->color);
    edited |= show_factor("opacity", &d->color[3], 0, 1);
    edited |= show_factor("metallic", &d->metallic, 0, 1);
    edited |= show_factor("roughness", &d->roughness, 0, 1);
    show_texture(v, "color", d->color_image);
    show_texture(v, "normals", d->normal_image);
    show_texture(v, "metallic, roughness", d->metallic_roughness_image);
    show_texture(v, "emission", d->emissive_image);
    if (edited) view_edit_do(v, &edit);
}

/* ---- all ---- */

static void show_undo(struct view *v) {
    const struct view_edits *edits = &v->select.edits;
    if (edits->count == 0) return;
    if (ui_button("undo")) view_edit_undo(v);
    ui_tooltip("Ctrl and Z");
    ui_same_line();
    if (ui_button("redo")) view_edit_redo(v);
    ui_tooltip("Ctrl and Y");
    ui_same_line();
    ui_text("%u of %u edits", edits->done, edits->count);
}

void view_panel_inspect(struct view *v) {
    uint32_t index;
    show_undo(v);
    if (!view_select_index(v, &index)) {
        ui_note("Click on an object with Ctrl held down, or on the icon of a light or decal (L shows them).");
    } else if (v->select.kind == VIEW_PICKED_OBJECT) {
        if (ui_header("object", true)) show_object(v, index);
        if (ui_header("material", true)) show_material(v);
    } else if (v->select.kind == VIEW_PICKED_LIGHT) {
        view_show_light(v, index);
    } else {
        show_decal(v, index);
    }
    if (ui_header("pixel", true)) view_panel_pixel(v);
}
