/* SPDX-License-Identifier: MIT */
/* What an empty window offers: built-in scenes, and those that were open before. */
#include "view/view.h"

#include <string.h>

static const struct {
    const char *name, *source, *help;
} scenes[] = {{"Hall", "builtin:hall", "A pillared hall lit by hundreds of lamps"},
              {"City", "builtin:city", "Streets at night, thousands of lights"},
              {"Interior", "builtin:interior", "A gallery with statues and pictures"},
              {"Room", "builtin:room", "A room with a window and a table"},
              {"Spheres", "builtin:spheres", "Metals and plastics from smooth to rough"},
              {"Glass", "builtin:glass", "Panes in front of each other"},
              {"Lamps", "builtin:lamps", "A row of lamps to the horizon"},
              {"Grass", "builtin:grass", "Alpha-masked blades"}};

void view_panel_start(struct view *v) {
    const struct view_settings *s = &v->settings;
    char label[300], opened[VIEW_PATH] = "";
    const float scale = v->scale;
    const struct ui_rectangle area = view_area(v);
    ui_card("##start", (struct ui_rectangle){area.x / scale, area.y / scale, area.width / scale, area.height / scale}, 460);
    ui_align_text();
    ui_text("Drop a model into this window, or");
    ui_same_line();
    if (ui_button("open a file##start")) view_browse(v, false);
    ui_note("Fanal reads glTF 2.0: .glb and .gltf");
    ui_separator();
    ui_text("Built-in scenes");
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++) {
        if (i) ui_same_line_if_fits(scenes[i].name);
        if (ui_button(scenes[i].name)) snprintf(opened, sizeof opened, "%s", scenes[i].source);
        ui_tooltip(scenes[i].help);
    }
    if (s->recent_count > 0) {
        ui_separator();
        ui_text("Recent files");
    }
    for (uint32_t i = 0; i < s->recent_count; i++) {
        const char *slash = strrchr(s->recent[i], '/');
        snprintf(label, sizeof label, "%.200s##recent%u", slash ? slash + 1 : s->recent[i], i);
        if (i) ui_same_line_if_fits(label);
        if (ui_button(label)) snprintf(opened, sizeof opened, "%s", s->recent[i]);
        ui_tooltip(s->recent[i]);
    }
    ui_window_end();
    if (opened[0]) view_open(v, opened);
}
