/* SPDX-License-Identifier: MIT */
/* The toolbar and its menus: what is set most often. */
#include "view/view.h"

#include <math.h>
#include <string.h>

/* ---- options ---- */

static void set(struct view *v, const char *key, const char *value) {
    if (strcmp(key, "shadows") == 0) *(view_edited(v) == &v->frame ? &v->own_shadows : &v->compare.own_shadows) = true;
    fnl_frame_set(&v->host, view_edited(v), key, value);
    view_want(v, 2);
}

static bool find_option(const char *key, fnl_option *out) {
    for (uint32_t i = 0; fnl_option_query(i, out); i++)
        if (strcmp(out->key, key) == 0) return true;
    return false;
}

void view_show_choices(struct view *v, const char *key) {
    fnl_option o;
    char value[64];
    const char *name;
    if (!find_option(key, &o)) return;
    fnl_frame_get(view_edited(v), key, value, sizeof value);
    for (uint32_t i = 0; (name = fnl_value_name(o.names, i)); i++) {
        const char *help = fnl_value_help(o.names, i);
        if (ui_radio(name, strcmp(name, value) == 0)) set(v, key, name);
        if (help) ui_tooltip(help);
    }
}

/* While two methods are compared: whose options the menus change. */
static void show_edited(const struct view *v) {
    if (v->compare.mode != VIEW_COMPARE_OFF) ui_note(v->compare.edits_b ? "of B" : "of A");
}

/* ---- menus ---- */

static void show_environment(struct view *v) {
    if (!ui_menu("Environment", false)) return;
    view_thumbnails_update(v);
    view_show_surroundings(v);
    ui_menu_end();
}

static void show_exposure(struct view *v) {
    if (!ui_menu("Exposure", false)) return;
    view_show_exposure(v);
    ui_menu_end();
}

static void show_antialiasing(struct view *v) {
    static const char *const samples[] = {"auto", "1", "2", "4", "8"};
    char msaa[16];
    if (!ui_menu("Antialiasing", false)) return;
    show_edited(v);
    fnl_frame_get(view_edited(v), "msaa", msaa, sizeof msaa);
    ui_text("Samples per pixel (MSAA)");
    for (int i = 0; i < 5; i++) {
        char label[24];
        snprintf(label, sizeof label, "%s##samples", samples[i]);
        if (i) ui_same_line();
        if (ui_radio(label, strcmp(msaa, samples[i]) == 0)) set(v, "msaa", samples[i]);
    }
    ui_tooltip("auto: 4 if the path and the device support it, otherwise 1");
    ui_separator();
    ui_text("Filter");
    view_show_choices(v, "aa");
    ui_menu_end();
}

static void show_shadows(struct view *v) {
    if (!ui_menu("Shadows", false)) return;
    show_edited(v);
    view_show_choices(v, "shadows");
    ui_separator();
    ui_text("Edges (maps, hybrid)");
    view_show_choices(v, "shadow.filter");
    ui_menu_end();
}

static void show_debug(struct view *v) {
    if (!ui_menu("Debug", view_edited(v)->debug != FNL_DEBUG_NONE)) return;
    show_edited(v);
    view_show_choices(v, "debug");
    ui_menu_end();
}

static void show_compare(struct view *v) {
    if (!ui_menu("Compare", v->compare.mode != VIEW_COMPARE_OFF)) return;
    view_panel_compare(v);
    ui_menu_end();
}

/* What the file has: cameras, variants, animations. */
static void show_file(struct view *v) {
    if (fnl_scene_count(v->shown.scene, FNL_ENTITY_CAMERA) > 0 && ui_menu("Camera", false)) {
        view_show_cameras(v);
        ui_menu_end();
    }
    if (v->shown.info.variant_count > 0 && ui_menu("Variant", v->variant[0] != 0)) {
        view_show_variants(v);
        ui_menu_end();
    }
    if (v->shown.info.animation_count > 0 && ui_menu("Animation", v->plays)) {
        view_show_animation(v);
        ui_menu_end();
    }
}

static void show_save(struct view *v) {
    if (!ui_menu("Save", false)) return;
    view_panel_files(v);
    ui_menu_end();
}

static void show_panel_choice(struct view *v, const char *label, enum view_panel panel, const char *help) {
    bool open = v->panels[panel];
    if (ui_checkbox(label, &open)) {
        v->panels[panel] = open;
        if (open) view_open_panel(v, panel);
        view_want(v, 2);
    }
    ui_tooltip(help);
}

static void show_panels(struct view *v) {
    uint32_t count = 0;
    for (int i = 0; i < VIEW_PANEL_COUNT; i++) count += v->panels[i];
    if (!ui_menu("Panels", count > 0 || v->timeline.shown != VIEW_NOTHING_WIDE)) return;
    show_panel_choice(v, "Scene", VIEW_PANEL_SCENE, "File contents, camera controls, window appearance");
    show_panel_choice(v, "Lights", VIEW_PANEL_LIGHTS, "Add lights, change them, switch them on and off");
    show_panel_choice(v, "Options", VIEW_PANEL_OPTIONS, "Every option of a frame");
    show_panel_choice(v, "Inspect", VIEW_PANEL_INSPECT, "The object, light or decal that was picked, and the pixel (Ctrl and left mouse)");
    show_panel_choice(v, "Statistics", VIEW_PANEL_STATISTICS, "What the frame costs: passes, memory, counters");
    show_panel_choice(v, "Messages", VIEW_PANEL_MESSAGES, "What was loaded, saved or went wrong");
    ui_separator();
    bool timeline = v->timeline.shown == VIEW_TIMELINE, graph = v->timeline.shown == VIEW_GRAPH;
    if (ui_checkbox("Timeline", &timeline)) view_show_wide(v, VIEW_TIMELINE);
    ui_tooltip("When each pass ran, in this and recent frames (F2)");
    if (ui_checkbox("Frame graph", &graph)) view_show_wide(v, VIEW_GRAPH);
    ui_tooltip("Passes, what they read and write, barriers (F3)");
    ui_menu_end();
}

float view_toolbar(struct view *v) {
    ui_toolbar();
    if (ui_toolbar_button("Open", v->files.browses)) view_browse(v, false);
    ui_tooltip("Opens a model, a scene or a panorama (Ctrl and O)");
    if (v->shown.source) {
        if (ui_toolbar_button("Reset view", false)) view_reset_camera(v);
        ui_tooltip("Back to the first view (F shows the whole scene)");
        show_file(v);
        show_environment(v);
        show_exposure(v);
        show_antialiasing(v);
        show_shadows(v);
        show_debug(v);
        show_compare(v);
        show_save(v);
    }
    show_panels(v);
    if (ui_toolbar_button("Help", v->shows_help)) v->shows_help = !v->shows_help;
    ui_tooltip("Keys and mouse (F1)");
    return ui_toolbar_end();
}
