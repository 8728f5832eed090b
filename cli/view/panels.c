/* SPDX-License-Identifier: MIT */
/* The panels of the window, the list of keys, and the same as text. */
#include "view/view.h"

#include "legend.h"
#include "options.h"
#include "view/ui.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- all of them ---- */

static void show_messages(struct view *v) {
    pthread_mutex_lock(&v->messages.mutex);
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
    if (ui_window("Keys", &v->shows_help, 420, 120, 420, 420)) {
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
                                              {"Escape", "let go of it"},
                                              {"Ctrl and Z, Ctrl and Y", "undo, redo"},
                                              {"F", "see the whole scene"},
                                              {"Space", "play, pause"},
                                              {"P", "save the picture"},
                                              {"Ctrl and O", "open a file"},
                                              {"V", "record the camera's way, or stop"},
                                              {"Tab", "hide the panels"},
                                              {"F1", "this list"},
                                              {"F2, F3", "the timeline, the frame graph"},
                                              {"Ctrl and Q", "quit"}};
        if (ui_table("keys", 2, 0.55f)) {
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

void view_panels(struct view *v) {
    view_compare_back(v);
    view_select_draw(v);
    if (v->hides_panels) return;
    const float high = (float)v->height / v->scale, wide = (float)v->width / v->scale;
    if (ui_window("Scene", NULL, 8, 8, 340, high * 0.42f)) view_panel_scene(v);
    ui_window_end();
    if (ui_window("Options", NULL, 8, 16 + high * 0.42f, 340, high * 0.58f - 24)) view_panel_options(v);
    ui_window_end();
    if (ui_window("Frame", NULL, wide - 348, 8, 340, high * 0.38f)) view_panel_frame(v);
    ui_window_end();
    if (ui_window("Inspect", NULL, wide - 348, 16 + high * 0.38f, 340, high * 0.45f)) view_panel_inspect(v);
    ui_window_end();
    if (ui_window("Messages", NULL, wide - 348, 24 + high * 0.83f, 340, high * 0.17f - 32)) show_messages(v);
    ui_window_end();
    view_panel_wide(v);
    if (view_has_legend(v)) {
        if (ui_window("Legend", NULL, 356, high - 158, 270, 150)) view_panel_legend(v);
        ui_window_end();
    }
    view_panel_browser(v);
    if (v->shows_help) show_help(v);
}

/* ---- as text ---- */

bool view_write_report(const struct view *v, const char *path) {
    FILE *file = fopen(path, "w");
    if (!file) {
        fprintf(stderr, "fanal: error: %s: cannot be written\n", path);
        return false;
    }
    const fnl_frame_stats *s = &v->stats;
    fprintf(file, "scene\t%s\ntriangles\t%llu\nlights\t%u\nframes\t%llu\n", v->shown.source ? v->shown.source : "",
            (unsigned long long)v->shown.info.triangle_count, v->shown.info.light_count, (unsigned long long)v->frames_drawn);
    const fnl_camera *c = &v->camera.now;
    fprintf(file, "camera\t%.9g\t%.9g\t%.9g\t%.9g\t%.9g\t%.9g\n", (double)c->position.x, (double)c->position.y, (double)c->position.z,
            (double)c->target.x, (double)c->target.y, (double)c->target.z);
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
    return fclose(file) == 0;
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
    fprintf(file, " --eye %.9g,%.9g,%.9g --look-at %.9g,%.9g,%.9g --fov %.17g --near %.9g", (double)c->position.x, (double)c->position.y,
            (double)c->position.z, (double)c->target.x, (double)c->target.y, (double)c->target.z,
            (double)c->vertical_fov * (180 / 3.14159265358979323846), (double)c->near_distance);
    if (c->up.x != 0 || c->up.y != 1 || c->up.z != 0) fprintf(file, " --up %.9g,%.9g,%.9g", (double)c->up.x, (double)c->up.y, (double)c->up.z);
}

static void print_surroundings(const struct view *v, FILE *file) {
    const struct view_surroundings *s = &v->surroundings;
    if (!s->changed) {
        fputs(v->environment_arguments, file);
        return;
    }
    if (s->none) {
        if (v->shown.info.light_count == 0) fputs(" --ambient 0,0,0", file); /* nothing takes its place */
        return;
    }
    if (s->source[0]) fprintf(file, " --environment '%s'", s->source);
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
        fputs(text, stdout);
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
    fputs(v->arguments, file);
    print_surroundings(v, file);
    if (v->variant[0]) fprintf(file, " --variant '%s'", v->variant);
}

/* Of the last sequence, with what is set now. */
static void print_sequence(const struct view *v, FILE *file, uint32_t width, uint32_t height, const char *animation) {
    const fnl_camera *c = &v->camera.now;
    fprintf(file, "# the last sequence:\n# fanal render '%s' --size %ux%u --fov %.17g --near %.9g", v->shown.source, width, height,
            (double)c->vertical_fov * (180 / 3.14159265358979323846), (double)c->near_distance);
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
    fprintf(file, "fanal render '%s' --size %ux%u", v->shown.source, width, height);
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
