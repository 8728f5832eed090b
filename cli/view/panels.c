/* SPDX-License-Identifier: MIT */
/* The panels of the window, the list of keys, and the same as text. */
#include "view/view.h"

#include "legend.h"
#include "options.h"
#include "origin.h"
#include "output.h"
#include "print.h"
#include "view/ui.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- all of them ---- */

/* The last warning or error that came after the panel Messages was last seen; NULL: none. */
static const char *last_problem(const struct view *v) {
    const struct view_messages *m = &v->messages;
    for (uint32_t i = m->count; i-- > m->seen && m->count - i <= VIEW_MESSAGES;)
        if (m->lines[i % VIEW_MESSAGES].level >= FNL_LOG_WARNING) return m->lines[i % VIEW_MESSAGES].text;
    return NULL;
}

static void show_messages(struct view *v) {
    pthread_mutex_lock(&v->messages.mutex);
    v->messages.seen = v->messages.count;
    const uint32_t count = v->messages.count, first = count > VIEW_MESSAGES ? count - VIEW_MESSAGES : 0;
    for (uint32_t i = count; i-- > first;) {
        const char *text = v->messages.lines[i % VIEW_MESSAGES].text;
        if (v->messages.lines[i % VIEW_MESSAGES].level >= FNL_LOG_WARNING)
            ui_warning("%s", text);
        else
            ui_note("%s", text);
    }
    pthread_mutex_unlock(&v->messages.mutex);
}

static void show_help(struct view *v) {
    if (ui_dialog("Keys", &v->shows_help, 540, 450)) {
        static const char *const rows[][2] = {{"left mouse", "orbit"},
                                              {"right mouse", "look around"},
                                              {"middle mouse, or Shift and left", "move sideways"},
                                              {"wheel", "closer, farther"},
                                              {"W A S D Q E", "fly; Shift: faster"},
                                              {"Ctrl and left mouse", "pick what is there"},
                                              {"N", "orbit, fly, walk"},
                                              {"M", "the mouse looks around; Escape ends it"},
                                              {"L", "icons of lights and decals"},
                                              {"T or 1, R or 2", "move, turn what is picked"},
                                              {"Delete", "remove a light or decal"},
                                              {"Escape", "deselect; close a menu or dialog"},
                                              {"Ctrl and Z, Ctrl and Y", "undo, redo"},
                                              {"F", "see the whole scene"},
                                              {"Space", "play, pause"},
                                              {"P", "save the picture, under an unused name"},
                                              {"Ctrl and O", "open a file"},
                                              {"V", "record the camera's way, or stop"},
                                              {"Tab", "hide the toolbar and the panels"},
                                              {"F1", "this list"},
                                              {"F2, F3", "the timeline, the frame graph"},
                                              {"Ctrl and Q", "quit"}};
        if (ui_table("keys", 2, 0.46f)) {
            for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
                ui_cell();
                ui_text("%s", rows[i][0]);
                ui_cell();
                ui_text("%s", rows[i][1]);
            }
            ui_table_end();
        }
    }
    ui_window_end();
}

/* ---- docks ---- */

static void (*const contents[VIEW_PANEL_COUNT])(struct view *) = {view_panel_scene,   view_panel_lights,     view_panel_options,
                                                                  view_panel_inspect, view_panel_statistics, show_messages};
static const char *const titles[VIEW_PANEL_COUNT] = {"Scene", "Lights", "Options", "Inspect", "Statistics", "Messages"};

void view_open_panel(struct view *v, enum view_panel panel) {
    v->panels[panel] = true;
    v->front = panel;
    v->hides_panels = false;
    view_want(v, 2);
}

bool view_open_panel_named(struct view *v, const char *name) {
    for (uint32_t i = 0; i < VIEW_PANEL_COUNT; i++) {
        if (strcasecmp(name, titles[i]) != 0) continue;
        view_open_panel(v, (enum view_panel)i);
        return true;
    }
    fprintf(stderr, "fanal: error: panel: '%s' is not one of scene, lights, options, inspect, statistics, messages\n", name);
    return false;
}

/* Whether a panel from `first` up to `end` is open. */
static bool is_open(const struct view *v, uint32_t first, uint32_t end) {
    for (uint32_t i = first; i < end; i++)
        if (v->panels[i]) return true;
    return false;
}

/* A tab for each of its panels that is open. */
static void show_dock(struct view *v, const char *name, struct ui_rectangle at, uint32_t first, uint32_t end) {
    char label[48];
    ui_dock(name, at);
    if (ui_tabs(name)) {
        for (uint32_t i = first; i < end; i++) {
            if (!v->panels[i]) continue;
            snprintf(label, sizeof label, "%s##tab", titles[i]);
            if (ui_tab(label, &v->panels[i], v->front == i)) {
                snprintf(label, sizeof label, "%s##contents", titles[i]);
                ui_child(label, 0);
                contents[i](v);
                ui_child_end();
                ui_tab_end();
            }
            if (!v->panels[i]) view_want(v, 2);
        }
        ui_tabs_end();
    }
    ui_window_end();
}

/* Left, right and below; in narrow windows all tabs are in one dock. What is left is the area. */
static void show_docks(struct view *v, float top) {
    enum { LEFT_END = VIEW_PANEL_INSPECT, DOCK = 330, NARROW = 900 };
    const float wide = (float)v->width / v->scale, high = (float)v->height / v->scale, dock = fminf(DOCK, fmaxf(0.45f * wide, fminf(230, 0.6f * wide)));
    const uint32_t end = wide < NARROW ? VIEW_PANEL_COUNT : LEFT_END;
    struct ui_rectangle rest = {0, top, wide, fmaxf(high - top, 1)};
    if (is_open(v, 0, end)) {
        show_dock(v, "##left", (struct ui_rectangle){0, top, dock, rest.height}, 0, end);
        rest.x += dock;
        rest.width -= dock;
    }
    if (is_open(v, end, VIEW_PANEL_COUNT)) {
        show_dock(v, "##right", (struct ui_rectangle){wide - dock, top, dock, rest.height}, end, VIEW_PANEL_COUNT);
        rest.width -= dock;
    }
    v->front = VIEW_PANEL_COUNT;
    if (v->timeline.shown != VIEW_NOTHING_WIDE) {
        const float below = fminf(350, 0.55f * rest.height);
        view_panel_wide(v, (struct ui_rectangle){rest.x, top + rest.height - below, rest.width, below});
        rest.height -= below;
    }
    const float s = v->scale;
    v->area = (struct ui_rectangle){floorf(rest.x * s), floorf(rest.y * s), floorf(rest.width * s), floorf(rest.height * s)};
}

/* What the picture says in its lower left corner: what is being loaded, how coarse it is, what went wrong. */
static void show_state(struct view *v) {
    const struct ui_rectangle area = view_area(v);
    char text[500] = "";
    const char *told = last_problem(v);
    if (v->loader.running)
        view_loader_describe(&v->loader, text, sizeof text);
    else if (told)
        snprintf(text, sizeof text, "%.400s", told);
    else if (v->part < 1 && v->shown.source)
        snprintf(text, sizeof text, "moving: %.0f %%", (double)v->part * 100);
    if (text[0]) ui_back_note(area.x + 8 * v->scale, area.y + area.height - 8 * v->scale, text);
}

void view_panels(struct view *v) {
    if (!v->hides_panels) {
        show_docks(v, fminf(view_toolbar(v), floorf(0.4f * (float)v->height / v->scale)));
        view_frame_again(v);
        show_state(v);
        if (!v->shown.source && !v->loader.running) view_panel_start(v);
        view_show_legend(v);
        view_panel_browser(v);
        if (v->shows_help) show_help(v);
    }
    view_compare_back(v);
    view_select_draw(v);
}

/* ---- as text ---- */

/* Where the camera is and looks, in file coordinates; returns the digits to print. */
static int camera_places(const struct view *v, double eye[3], double target[3]) {
    origin_place(v->shown.scene, v->camera.now.position, eye);
    origin_place(v->shown.scene, v->camera.now.target, target);
    return origin_digits(v->shown.scene);
}

bool view_write_report(const struct view *v, const char *path) {
    struct output report;
    if (!output_begin(path, &report)) return false;
    FILE *file = report.stream;
    const fnl_frame_stats *s = &v->stats;
    fprintf(file, "scene\t%s\ntriangles\t%llu\nlights\t%u\nframes\t%llu\n", v->shown.source ? v->shown.source : "",
            (unsigned long long)v->shown.info.triangle_count, v->shown.info.light_count, (unsigned long long)v->frames_drawn);
    const struct ui_rectangle area = view_area(v);
    fprintf(file, "area\t%.0f\t%.0f\t%.0f\t%.0f\n", (double)area.x, (double)area.y, (double)area.width, (double)area.height);
    fprintf(file, "shadows\t%s\n", fnl_value_name(FNL_ENUM_SHADOWS, v->frame.shadows));
    double eye[3], target[3];
    const int digits = camera_places(v, eye, target);
    fprintf(file, "camera\t%.*g\t%.*g\t%.*g\t%.*g\t%.*g\t%.*g\n", digits, eye[0], digits, eye[1], digits, eye[2], digits, target[0], digits, target[1], digits,
            target[2]);
    fprintf(file, "shading\t%s\nlists\t%s\npasses_ms\t%.4f\n", fnl_value_name(FNL_ENUM_SHADING, s->shading), fnl_value_name(FNL_ENUM_LISTS, s->lists),
            s->gpu_milliseconds);
    view_report_timeline(v, file);
    view_report_graph(v, file);
    for (uint32_t i = 0; i < s->counter_count; i++) fprintf(file, "counter\t%s\t%llu\n", s->counters[i].key, (unsigned long long)s->counters[i].value);
    fprintf(file, "device_bytes\t%llu\n", (unsigned long long)s->device_bytes);
    for (uint32_t i = 0; i < s->memory_kind_count; i++) fprintf(file, "memory\t%s\t%llu\n", s->memory_kinds[i].name, (unsigned long long)s->memory_kinds[i].bytes);
    view_compare_report(v, file);
    char legend[1024];
    legend_print(v->frame.debug, legend, sizeof legend);
    if (legend[0]) fprintf(file, "legend\t%s\t%s\n", fnl_value_name(FNL_ENUM_DEBUG_VIEW, v->frame.debug), legend);
    view_report_frame(v, file);
    view_report_pixel(v, file);
    view_select_report(v, file);
    const uint32_t count = v->messages.count, first = count > VIEW_MESSAGES ? count - VIEW_MESSAGES : 0;
    for (uint32_t i = first; i < count; i++) fprintf(file, "message\t%s\n", v->messages.lines[i % VIEW_MESSAGES].text);
    return output_commit(&report);
}

static bool equal(fnl_vec3 a, fnl_vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

/* Which camera of the scene it is; -1: none. */
static int camera_index(const struct view *v) {
    const fnl_camera *c = &v->camera.now;
    fnl_camera other;
    const uint32_t count = fnl_scene_count(v->shown.scene, FNL_ENTITY_CAMERA);
    for (uint32_t i = 0; i < count; i++) {
        if (fnl_scene_query_camera(v->shown.scene, i, &other) != FNL_OK) continue;
        if (equal(c->position, other.position) && equal(c->target, other.target) && equal(c->up, other.up) && c->orthographic == other.orthographic &&
            c->vertical_fov == other.vertical_fov && c->vertical_extent == other.vertical_extent && c->near_distance == other.near_distance &&
            c->far_distance == other.far_distance && c->shift.x == other.shift.x && c->shift.y == other.shift.y)
            return (int)i;
    }
    return -1;
}

static void print_camera(const struct view *v, FILE *file) {
    const fnl_camera *c = &v->camera.now;
    const int index = camera_index(v);
    if (index >= 0) {
        fprintf(file, " --camera %d", index);
        return;
    }
    double eye[3], target[3];
    const int digits = camera_places(v, eye, target);
    fprintf(file, " --eye %.*g,%.*g,%.*g --look-at %.*g,%.*g,%.*g --fov %.17g --near %.9g", digits, eye[0], digits, eye[1], digits, eye[2], digits, target[0], digits,
            target[1], digits, target[2],
            (double)c->vertical_fov * (180 / 3.14159265358979323846), (double)c->near_distance);
    if (c->up.x != 0 || c->up.y != 1 || c->up.z != 0) fprintf(file, " --up %.9g,%.9g,%.9g", (double)c->up.x, (double)c->up.y, (double)c->up.z);
}

/* What comes before the word is Fanal's own. */
static void print_word(FILE *file, const char *before, const char *text) {
    char *word = print_shell_word(text);
    fputs(before, file); /* own text */
    fprintf(file, " %s", word ? word : "''");
    free(word);
}

static void print_surroundings(const struct view *v, FILE *file) {
    const struct view_surroundings *s = &v->surroundings;
    if (!s->changed) {
        fprintf(file, "%s", v->environment_arguments);
        return;
    }
    if (s->none) {
        if (v->shown.info.light_count == 0) fputs(" --ambient 0,0,0", file); /* nothing takes its place */
        return;
    }
    if (s->source[0]) print_word(file, " --environment", s->source);
    fprintf(file, " --environment-rotation %.9g --environment-intensity %.9g", (double)s->params.rotation * (180 / 3.14159265358979323846),
            (double)s->params.intensity);
    if (!s->params.background) fputs(" --environment-hidden", file);
}

void view_copy_command(const struct view *v) {
    char *text = NULL;
    size_t size;
    FILE *file = open_memstream(&text, &size);
    if (!file) return;
    view_print_command(v, file);
    if (fclose(file) == 0) {
        fputs(text, stdout); /* own text */
        fflush(stdout);
        if (v->window) view_window_set_clipboard(v->window, text);
    }
    free(text);
}

static void print_options(const struct view *v, FILE *file) {
    fnl_option o;
    char value[64], usual[64];
    const fnl_frame frame = fnl_frame_default();
    for (uint32_t i = 0; fnl_option_query(i, &o); i++) {
        fnl_frame_get(&v->frame, o.key, value, sizeof value);
        fnl_frame_get(&frame, o.key, usual, sizeof usual);
        if (strcmp(o.key, "width") != 0 && strcmp(o.key, "height") != 0 && (strcmp(o.key, "shadows") == 0 || strcmp(value, usual) != 0)) fprintf(file, " --set %s=%s", o.key, value);
    }
}

/* What was said of the scene, and what was chosen in the window. */
static void print_scene(const struct view *v, FILE *file) {
    fprintf(file, "%s", v->arguments);
    if (view_is_asked_for(v, v->shown.source)) fprintf(file, "%s", v->light_arguments);
    print_surroundings(v, file);
    if (v->variant[0]) print_word(file, " --variant", v->variant);
}

/* Of the last sequence, with what is set now. */
static void print_sequence(const struct view *v, FILE *file, uint32_t width, uint32_t height, const char *animation) {
    const fnl_camera *c = &v->camera.now;
    print_word(file, "# the last sequence:\n# fanal render", v->shown.source);
    fprintf(file, " --size %ux%u --fov %.17g --near %.9g", width, height, (double)c->vertical_fov * (180 / 3.14159265358979323846), (double)c->near_distance);
    if (c->up.x != 0 || c->up.y != 1 || c->up.z != 0) fprintf(file, " --up %.9g,%.9g,%.9g", (double)c->up.x, (double)c->up.y, (double)c->up.z);
    print_scene(v, file);
    if (v->shown.info.animation_count) fprintf(file, " --time %.17g --animation %s", v->time, animation);
    print_options(v, file);
    fprintf(file, " %s\n", v->files.sequence);
}

void view_print_command(const struct view *v, FILE *file) {
    uint32_t width, height;
    char animation[96];
    view_save_size(v, &width, &height);
    view_animation_text(v, animation, sizeof animation);
    print_word(file, "fanal render", v->shown.source);
    fprintf(file, " --size %ux%u", width, height);
    print_camera(v, file);
    print_scene(v, file);
    if (v->time > 0 || view_blends(v)) fprintf(file, " --time %.17g --animation %s", v->time, animation);
    print_options(v, file);
    fputs(" -o picture.png\n", file);
    const fnl_camera *c = &v->camera.now;
    if ((c->orthographic || c->shift.x != 0 || c->shift.y != 0) && camera_index(v) < 0) fputs("# with a camera that is neither orthographic nor shifted\n", file);
    if (v->shown.changed) fputs("# without what was changed in the window; 'save scene' keeps that\n", file);
    if (v->files.sequence[0]) print_sequence(v, file, width, height, animation);
    fflush(file);
}
