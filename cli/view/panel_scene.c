/* SPDX-License-Identifier: MIT */
/* The scene: what it has, where it is seen from, when, and what stands around it. */
#include "view/view.h"

#include <math.h>
#include <string.h>

/* "Name", or what it is called that has none; `kind` and the number tell widgets apart. */
static void label_of(char label[128], const char *name, const char *kind, uint32_t number) {
    if (name && name[0])
        snprintf(label, 128, "%.80s##%s%u", name, kind, number);
    else
        snprintf(label, 128, "%s %u##%s", kind, number, kind);
}

/* ---- what the file has: in menus of the toolbar ---- */

void view_show_cameras(struct view *v) {
    fnl_entity_info info;
    fnl_camera camera;
    char label[128];
    const uint32_t count = fnl_scene_count(v->shown.scene, FNL_ENTITY_CAMERA);
    for (uint32_t i = 0; i < count; i++) {
        const bool named = fnl_scene_query_entity(v->shown.scene, FNL_ENTITY_CAMERA, i, &info) == FNL_OK;
        if (fnl_scene_query_camera(v->shown.scene, i, &camera) != FNL_OK) continue;
        label_of(label, named ? info.name : NULL, "camera", i);
        if (!ui_radio(label, memcmp(&camera, &v->camera.now, sizeof camera) == 0)) continue;
        v->camera.now = camera;
        view_want(v, 2);
    }
}

void view_show_animation(struct view *v) {
    fnl_animation_info info;
    char label[128];
    float time = (float)v->time, speed = (float)v->speed;
    if (v->shown.info.animation_count == 0 || fnl_scene_query_animation(v->shown.scene, v->animation, &info) != FNL_OK) return;
    if (ui_button(v->plays ? "pause" : "play")) v->plays = !v->plays;
    ui_tooltip("Space");
    ui_same_line();
    ui_item_width(150);
    if (ui_number("seconds", &time, 0, (float)fmax(info.duration, 1e-3), "%.2f")) view_set_time(v, (double)time);
    ui_item_width(150);
    if (ui_number("speed", &speed, 0, 4, "%.2f")) v->speed = (double)speed;
    for (uint32_t i = 0; i < v->shown.info.animation_count && v->shown.info.animation_count > 1; i++) {
        fnl_scene_query_animation(v->shown.scene, i, &info);
        label_of(label, info.name, "animation", i);
        if (!ui_radio(label, i == v->animation)) continue;
        v->animation = i;
        view_set_time(v, 0);
    }
    view_panel_blend(v);
}

void view_show_variants(struct view *v) {
    fnl_entity_info info;
    char label[128];
    if (ui_radio("file default", !v->variant[0]) && fnl_scene_select_variant(v->shown.scene, FNL_NO_VARIANT) == FNL_OK) {
        v->variant[0] = 0;
        view_want(v, 2);
    }
    for (uint32_t i = 0; i < v->shown.info.variant_count; i++) {
        const bool known = fnl_scene_query_entity(v->shown.scene, FNL_ENTITY_VARIANT, i, &info) == FNL_OK && info.name;
        label_of(label, known ? info.name : NULL, "variant", i);
        if (!ui_radio(label, known && strcmp(v->variant, info.name) == 0) || fnl_scene_select_variant(v->shown.scene, i) != FNL_OK) continue;
        snprintf(v->variant, sizeof v->variant, "%s", known ? info.name : "");
        view_want(v, 2);
    }
}

/* ---- what stands around it ---- */

/* The studio that frames show where nothing else is: not the scene's. */
static bool stands_in_studio(const struct view *v) { return v->surroundings.none && v->frame.studio && v->shown.info.light_count <= FNL_STUDIO_FILL_LIGHTS && !v->shown.info.has_ambient; }

static bool show_made_environments(struct view *v) {
    static const char *const names[VIEW_ENVIRONMENTS] = {"Studio", "Sky", "Overcast"};
    struct view_surroundings *s = &v->surroundings;
    bool chosen = false;
    for (uint32_t i = 0; i < VIEW_ENVIRONMENTS; i++) {
        const float top = (float)i / VIEW_ENVIRONMENTS, bottom = (float)(i + 1) / VIEW_ENVIRONMENTS;
        const bool shown = s->none ? i == 0 && stands_in_studio(v) : strcmp(s->source, view_environments[i]) == 0;
        if (i) ui_same_line();
        if (!ui_picture_button(names[i], VIEW_THUMBNAIL_IMAGE, top, bottom, VIEW_THUMBNAIL_WIDTH, VIEW_THUMBNAIL_HEIGHT, shown)) continue;
        snprintf(s->source, sizeof s->source, "%s", view_environments[i]);
        s->none = false;
        chosen = true;
    }
    return chosen;
}

void view_show_surroundings(struct view *v) {
    struct view_surroundings *s = &v->surroundings;
    fnl_environment_params *params = &s->params;
    float degrees = params->rotation * (180 / 3.14159265f);
    bool changed = show_made_environments(v), none = s->none && !stands_in_studio(v);
    if (ui_checkbox("No environment", &none)) {
        v->frame.studio = v->compare.frame.studio = !none; /* where there is no light */
        s->none = none || !s->source[0];
        if (!none && !stands_in_studio(v) && !s->source[0]) {
            snprintf(s->source, sizeof s->source, "%s", view_environments[0]);
            s->none = false;
        }
        changed = true;
    }
    if (!s->none) {
        ui_item_width(150);
        if (ui_number("rotation", &degrees, -180, 180, "%.1f degrees")) {
            params->rotation = degrees * (3.14159265f / 180);
            changed = true;
        }
        ui_item_width(150);
        changed |= ui_number("intensity", &params->intensity, 0, 20, "%.3g");
        changed |= ui_checkbox("show as background", &params->background);
    }
    ui_note("To use your own panorama, drop an .hdr or .exr file into the window, or open it.");
    if (changed) view_apply_surroundings(v);
}

void view_show_exposure(struct view *v) {
    bool metered = v->frame.exposure == FNL_EXPOSURE_AUTO;
    if (ui_checkbox("automatic", &metered)) {
        v->frame.exposure = metered ? FNL_EXPOSURE_AUTO : FNL_EXPOSURE_EV;
        v->frame.ev = v->stats.ev;
        view_compare_expose(v);
    }
    if (metered) {
        ui_note("EV100 %.2f", (double)v->stats.ev);
        return;
    }
    ui_item_width(150);
    if (ui_number("EV100", &v->frame.ev, -10, 20, "%.2f")) view_compare_expose(v);
    ui_tooltip("Exposure value: +1 halves the brightness");
}

/* ---- the window ---- */

static void show_navigation(struct view *v) {
    static const char *const names[VIEW_NAVIGATION_COUNT] = {"orbit", "fly", "walk"};
    static const char *const helps[VIEW_NAVIGATION_COUNT] = {"Drag to orbit around the point you look at", "Drag to look around; W A S D Q E fly where you look",
                                                             "Drag to look around; W A S D stay at this height, Q E change it"};
    for (uint32_t i = 0; i < VIEW_NAVIGATION_COUNT; i++) {
        if (i) ui_same_line();
        if (ui_radio(names[i], i == v->settings.navigation)) v->settings.navigation = i;
        ui_tooltip(helps[i]);
    }
}

static uint32_t show_names(const char *label, const char *const *names, uint32_t count, uint32_t chosen) {
    ui_item_width(150);
    if (!ui_combo(label, names[chosen])) return chosen;
    for (uint32_t i = 0; i < count; i++)
        if (ui_choice(names[i], i == chosen)) chosen = i;
    ui_combo_end();
    return chosen;
}

static void show_window(struct view *v) {
    struct view_settings *s = &v->settings;
    const struct view_settings before = *s;
    float scale = v->scale;
    ui_checkbox("dark theme", &s->dark);
    ui_item_width(150);
    if (ui_number("text size", &scale, 0.5f, 4, "%.2f")) v->wanted_scale = scale;
    s->present = show_names("presentation mode", view_present_names, VIEW_PRESENT_COUNT, s->present);
    ui_tooltip("fifo waits for the screen; mailbox shows the newest picture without waiting; immediate may tear");
    s->color = show_names("color space", view_color_names, VIEW_COLOR_COUNT, s->color);
    ui_tooltip("scrgb and hdr10 show colors brighter than white on HDR screens; other screens use srgb");
    if (s->present != before.present || s->color != before.color || s->dark != before.dark) view_apply_settings(v);
}

/* ---- the panel ---- */

void view_panel_scene(struct view *v) {
    const fnl_scene_info *info = &v->shown.info;
    ui_note("%s", v->shown.source ? v->shown.source : "No scene is open.");
    if (v->shown.source) {
        ui_text("%llu %s, %llu %s, %u %s, %u %s", (unsigned long long)info->triangle_count, view_plural(info->triangle_count, "triangle", "triangles"),
                (unsigned long long)info->instance_count, view_plural(info->instance_count, "object", "objects"), info->material_count,
                view_plural(info->material_count, "material", "materials"), info->light_count, view_plural(info->light_count, "light", "lights"));
        if (ui_button("export tables")) {
            char path[32] = "fanal-tables.tsv", text[64];
            view_free_name(path, sizeof path);
            snprintf(text, sizeof text, "wrote %s", path);
            if (view_write_report(v, path)) view_say(v, FNL_LOG_INFO, text);
        }
        ui_tooltip("Saves the panels' tables as tab-separated text in fanal-tables.tsv, or under the next free name");
    }
    if (ui_header("camera", true)) show_navigation(v);
    if (ui_header("window", true)) show_window(v);
}
