/* SPDX-License-Identifier: MIT */
/* The scene: what it has, where it is seen from, when. */
#include "view/view.h"

#include "view/ui.h"

#include <math.h>
#include <string.h>

static void show_cameras(struct view *v) {
    fnl_entity_info info;
    char label[96];
    const uint32_t count = fnl_scene_count(v->shown.scene, FNL_ENTITY_CAMERA);
    if (ui_button("frame all")) view_frame_all(v);
    ui_tooltip("F");
    if (count == 0) return;
    ui_same_line();
    ui_item_width(150);
    if (!ui_combo("camera", "of the scene")) return;
    for (uint32_t i = 0; i < count; i++) {
        const bool named = fnl_scene_query_entity(v->shown.scene, FNL_ENTITY_CAMERA, i, &info) == FNL_OK && info.name && info.name[0];
        snprintf(label, sizeof label, "%s##%u", named ? info.name : "without a name", i);
        if (ui_choice(label, false)) {
            fnl_scene_query_camera(v->shown.scene, i, &v->camera.now);
            view_want(v, 2);
        }
    }
    ui_combo_end();
}

static void show_animation(struct view *v) {
    fnl_animation_info info;
    float time = (float)v->time, speed = (float)v->speed;
    if (v->shown.info.animation_count == 0 || fnl_scene_query_animation(v->shown.scene, v->animation, &info) != FNL_OK) return;
    if (ui_button(v->plays ? "pause" : "play")) v->plays = !v->plays;
    ui_tooltip("Space");
    ui_same_line();
    ui_item_width(150);
    if (ui_number("seconds", &time, 0, (float)fmax(info.duration, 1e-3), "%.2f")) view_set_time(v, (double)time);
    ui_item_width(150);
    if (ui_number("speed", &speed, 0, 4, "%.2f")) v->speed = (double)speed;
    if (v->shown.info.animation_count < 2) return;
    ui_item_width(150);
    if (!ui_combo("animation", info.name ? info.name : "without a name")) return;
    for (uint32_t i = 0; i < v->shown.info.animation_count; i++) {
        char label[96];
        fnl_scene_query_animation(v->shown.scene, i, &info);
        snprintf(label, sizeof label, "%s##%u", info.name ? info.name : "without a name", i);
        if (!ui_choice(label, i == v->animation)) continue;
        v->animation = i;
        view_set_time(v, 0);
    }
    ui_combo_end();
}

static void show_variants(struct view *v) {
    fnl_entity_info info;
    char label[96];
    if (v->shown.info.variant_count == 0) return;
    ui_item_width(150);
    if (!ui_combo("variant", v->variant[0] ? v->variant : "as the file has it")) return;
    if (ui_choice("none", false) && fnl_scene_select_variant(v->shown.scene, FNL_NO_VARIANT) == FNL_OK) v->variant[0] = 0;
    for (uint32_t i = 0; i < v->shown.info.variant_count; i++) {
        const bool known = fnl_scene_query_entity(v->shown.scene, FNL_ENTITY_VARIANT, i, &info) == FNL_OK;
        snprintf(label, sizeof label, "%s##%u", known && info.name ? info.name : "without a name", i);
        if (ui_choice(label, false) && fnl_scene_select_variant(v->shown.scene, i) == FNL_OK) snprintf(v->variant, sizeof v->variant, "%s", known && info.name ? info.name : "");
    }
    view_want(v, 2);
    ui_combo_end();
}

static void show_navigation(struct view *v) {
    static const char *const names[VIEW_NAVIGATION_COUNT] = {"orbit", "fly", "walk"};
    static const char *const helps[VIEW_NAVIGATION_COUNT] = {"the left mouse button turns about what is looked at", "it looks around; W A S D Q E fly where you look",
                                                             "it looks around; W A S D stay at this height, Q E change it"};
    ui_item_width(150);
    if (!ui_combo("navigation", names[v->settings.navigation])) return;
    for (uint32_t i = 0; i < VIEW_NAVIGATION_COUNT; i++) {
        if (ui_choice(names[i], i == v->settings.navigation)) v->settings.navigation = i;
        ui_tooltip(helps[i]);
    }
    ui_combo_end();
}

static void show_surroundings(struct view *v) {
    static const char *const made[] = {"builtin:studio", "builtin:sky", "builtin:overcast"};
    struct view_surroundings *s = &v->surroundings;
    fnl_environment_params *params = &s->params;
    float degrees = params->rotation * (180 / 3.14159265f);
    bool changed = false;
    ui_item_width(200);
    if (ui_combo("environment", s->none ? "none" : s->source[0] ? s->source : "of the file")) {
        if (ui_choice("none##environment", s->none)) changed = s->none = true;
        for (size_t i = 0; i < sizeof made / sizeof *made; i++) {
            if (!ui_choice(made[i], !s->none && strcmp(s->source, made[i]) == 0)) continue;
            snprintf(s->source, sizeof s->source, "%s", made[i]);
            s->none = false;
            changed = true;
        }
        ui_combo_end();
    }
    ui_tooltip("Drop an .hdr or .exr panorama into the window to stand the scene in it.");
    if (!s->none) {
        ui_item_width(150);
        if (ui_number("rotation", &degrees, -180, 180, "%.1f degrees")) {
            params->rotation = degrees * (3.14159265f / 180);
            changed = true;
        }
        ui_item_width(150);
        changed |= ui_number("intensity", &params->intensity, 0, 20, "%.3g");
        changed |= ui_checkbox("seen behind the scene", &params->background);
    }
    if (changed) view_apply_surroundings(v);
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
    s->present = show_names("presentation", view_present_names, VIEW_PRESENT_COUNT, s->present);
    ui_tooltip("fifo waits for the screen; mailbox shows the newest picture and does not wait; immediate may tear");
    s->color = show_names("colour space", view_color_names, VIEW_COLOR_COUNT, s->color);
    ui_tooltip("scrgb and hdr10: brighter than white, where the screen can; else srgb");
    ui_item_width(150);
    if (ui_number("size of letters", &scale, 0.5f, 4, "%.2f")) v->wanted_scale = scale;
    ui_checkbox("dark", &s->dark);
    if (s->present != before.present || s->color != before.color || s->dark != before.dark) view_apply_settings(v);
}

static void show_recent(struct view *v) {
    char source[sizeof v->settings.recent[0]] = "";
    if (v->settings.recent_count == 0) return;
    ui_item_width(200);
    if (!ui_combo("recent", "open again")) return;
    for (uint32_t i = 0; i < v->settings.recent_count; i++)
        if (ui_choice(v->settings.recent[i], false)) snprintf(source, sizeof source, "%s", v->settings.recent[i]);
    ui_combo_end();
    if (source[0]) view_open(v, source);
}

static void show_exposure(struct view *v) {
    bool metered = v->frame.exposure == FNL_EXPOSURE_AUTO;
    if (ui_checkbox("exposure from the picture", &metered)) {
        v->frame.exposure = metered ? FNL_EXPOSURE_AUTO : FNL_EXPOSURE_EV;
        v->frame.ev = v->stats.ev;
        view_compare_expose(v);
    }
    if (metered) return;
    ui_item_width(150);
    if (ui_number("EV100", &v->frame.ev, -10, 20, "%.2f")) view_compare_expose(v);
}

void view_panel_scene(struct view *v) {
    const fnl_scene_info *info = &v->shown.info;
    ui_note("%s", v->shown.source ? v->shown.source : "Drop a glTF file here.");
    show_recent(v);
    if (v->loader.running) ui_bar((float)atomic_load(&v->loader.progress) / 1000, "loading");
    if (!v->shown.scene) return;
    ui_text("%llu triangles, %llu instances, %u materials", (unsigned long long)info->triangle_count, (unsigned long long)info->instance_count,
            info->material_count);
    show_cameras(v);
    show_navigation(v);
    show_animation(v);
    view_panel_blend(v);
    show_variants(v);
    show_exposure(v);
    ui_item_width(-60);
    ui_input("##path", v->save_path, sizeof v->save_path);
    ui_same_line();
    if (ui_button("save")) view_save_picture(v, v->save_path);
    ui_tooltip("Saves the picture at the window's size, as 'fanal render' would make it: .png or .exr (P)");
    view_panel_files(v);
    if (ui_button("copy the command")) view_copy_command(v);
    ui_tooltip("Which 'fanal render' makes this picture: into the clipboard, and to the terminal");
    ui_same_line();
    if (ui_button("export the tables") && view_write_report(v, "fanal-tables.tsv")) view_say(v, FNL_LOG_INFO, "wrote fanal-tables.tsv");
    ui_tooltip("What the panels say, as lines of words and numbers between tabs: fanal-tables.tsv");
    if (ui_header("lights", true)) view_panel_lights(v);
    if (ui_header("surroundings", false)) show_surroundings(v);
    if (ui_header("window", false)) show_window(v);
}
