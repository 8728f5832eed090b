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
    if (!ui_combo("variant", "choose")) return;
    if (ui_choice("none", false)) fnl_scene_select_variant(v->shown.scene, FNL_NO_VARIANT);
    for (uint32_t i = 0; i < v->shown.info.variant_count; i++) {
        const bool known = fnl_scene_query_entity(v->shown.scene, FNL_ENTITY_VARIANT, i, &info) == FNL_OK;
        snprintf(label, sizeof label, "%s##%u", known && info.name ? info.name : "without a name", i);
        if (ui_choice(label, false)) fnl_scene_select_variant(v->shown.scene, i);
    }
    view_want(v, 2);
    ui_combo_end();
}

static void show_exposure(struct view *v) {
    bool metered = v->frame.exposure == FNL_EXPOSURE_AUTO;
    if (ui_checkbox("exposure from the picture", &metered)) {
        v->frame.exposure = metered ? FNL_EXPOSURE_AUTO : FNL_EXPOSURE_EV;
        v->frame.ev = v->stats.ev;
        view_want(v, 2);
    }
    if (metered) return;
    ui_item_width(150);
    if (ui_number("EV100", &v->frame.ev, -10, 20, "%.2f")) view_want(v, 2);
}

void view_panel_scene(struct view *v) {
    const fnl_scene_info *info = &v->shown.info;
    ui_note("%s", v->shown.source ? v->shown.source : "Drop a glTF file here.");
    if (v->loader.running) ui_bar((float)atomic_load(&v->loader.progress) / 1000, "loading");
    if (!v->shown.scene) return;
    ui_text("%llu triangles, %llu instances, %u materials", (unsigned long long)info->triangle_count, (unsigned long long)info->instance_count,
            info->material_count);
    show_cameras(v);
    show_animation(v);
    show_variants(v);
    show_exposure(v);
    ui_item_width(-60);
    ui_input("##path", v->save_path, sizeof v->save_path);
    ui_same_line();
    if (ui_button("save")) view_save_picture(v, v->save_path);
    ui_tooltip("Saves the picture at the window's size, as 'fanal render' would make it: .png or .exr (P)");
    if (ui_button("print the command")) view_print_command(v, stdout);
    ui_tooltip("Writes to the terminal which 'fanal render' makes this picture");
    if (ui_header("lights", true)) view_panel_lights(v);
}
