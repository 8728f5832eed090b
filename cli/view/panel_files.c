/* SPDX-License-Identifier: MIT */
/* Files: a browser of folders, to open and to save; and what is saved, in the panel of the scene. */
#include "view/view.h"

#include "view/ui.h"

#include <dirent.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- folders ---- */

static bool is_shown(const char *name, bool saves) {
    static const char *const kinds[] = {".gltf", ".glb", ".hdr", ".exr"};
    for (size_t i = saves ? 1 : 0; i < (saves ? 2 : sizeof kinds / sizeof *kinds); i++)
        if (view_ends_with(name, kinds[i])) return true;
    return false;
}

/* Folders first, then by name. */
static int compare(const void *a, const void *b) {
    const struct view_entry *x = a, *y = b;
    if (x->folder != y->folder) return x->folder ? -1 : 1;
    const int order = strcasecmp(x->name, y->name);
    return order ? order : strcmp(x->name, y->name);
}

static void add_entry(struct view_files *f, const char *name) {
    char path[VIEW_PATH + 256];
    struct stat s;
    if (snprintf(path, sizeof path, "%s/%s", f->folder, name) >= (int)sizeof path || stat(path, &s) != 0) return;
    const bool folder = S_ISDIR(s.st_mode);
    if (!folder && (!S_ISREG(s.st_mode) || !is_shown(name, f->browser_saves))) return;
    if ((f->entry_count & (f->entry_count - 1)) == 0) { /* full at every power of two */
        struct view_entry *bigger = realloc(f->entries, (f->entry_count ? 2 * (size_t)f->entry_count : 1) * sizeof *bigger);
        if (!bigger) return;
        f->entries = bigger;
    }
    struct view_entry *entry = &f->entries[f->entry_count++];
    snprintf(entry->name, sizeof entry->name, "%s", name);
    entry->folder = folder;
    entry->size = (uint64_t)s.st_size;
}

static void read_folder(struct view *v) {
    enum { MOST = 10000 };
    struct view_files *f = &v->files;
    DIR *folder = opendir(f->folder);
    f->entry_count = 0;
    if (!folder) {
        char text[VIEW_PATH + 200];
        snprintf(text, sizeof text, "%s: cannot be read: %s", f->folder, strerror(errno));
        view_say(v, FNL_LOG_ERROR, text);
        return;
    }
    for (struct dirent *d; f->entry_count < MOST && (d = readdir(folder));)
        if (d->d_name[0] != '.') add_entry(f, d->d_name);
    closedir(folder);
    if (f->entry_count) qsort(f->entries, f->entry_count, sizeof *f->entries, compare);
}

/* The folder without links; false: there is none. */
static bool enter(struct view *v, const char *path) {
    char *real = realpath(path, NULL);
    struct stat s;
    const bool good = real && strlen(real) < VIEW_PATH && stat(real, &s) == 0 && S_ISDIR(s.st_mode);
    if (good) {
        snprintf(v->files.folder, sizeof v->files.folder, "%s", strcmp(real, "/") == 0 ? "/." : real);
        read_folder(v);
    }
    free(real);
    return good;
}

void view_browse(struct view *v, bool saves) {
    v->files.browses = true;
    v->files.browser_saves = saves;
    v->files.typed[0] = 0;
    if (saves) snprintf(v->files.typed, sizeof v->files.typed, "%s", v->files.scene_path);
    if (!v->files.folder[0]) {
        char folder[VIEW_PATH];
        const char *source = v->shown.source, *slash = source ? strrchr(source, '/') : NULL;
        snprintf(folder, sizeof folder, "%.*s", slash ? (int)(slash + 1 - source) : 1, slash ? source : ".");
        if (enter(v, folder)) return;
        snprintf(v->files.folder, sizeof v->files.folder, "%s", getenv("HOME") ? getenv("HOME") : "/");
    }
    read_folder(v);
}

/* A name in the folder, or a path from the root or the user's folder on. */
static void full_path(const struct view_files *f, const char *name, char out[VIEW_PATH]) {
    const char *home = getenv("HOME");
    if (name[0] == '/')
        snprintf(out, VIEW_PATH, "%s", name);
    else if (name[0] == '~' && name[1] == '/' && home)
        snprintf(out, VIEW_PATH, "%s%s", home, name + 1);
    else if (snprintf(out, VIEW_PATH, "%s/%s", f->folder, name) >= VIEW_PATH)
        out[0] = 0;
}

static void choose(struct view *v, const char *name) {
    struct view_files *f = &v->files;
    char path[VIEW_PATH];
    if (!name[0]) return;
    if (!f->browser_saves && strncmp(name, "builtin:", 8) == 0) {
        f->browses = false;
        view_open(v, name);
        return;
    }
    full_path(f, name, path);
    if (enter(v, path)) {
        f->typed[0] = 0;
        return;
    }
    if (f->browser_saves) {
        if (view_save_scene(v, path)) {
            snprintf(f->scene_path, sizeof f->scene_path, "%s", path);
            f->browses = false;
        }
        return;
    }
    if (access(path, R_OK) != 0) {
        char text[VIEW_PATH + 200];
        snprintf(text, sizeof text, "%s: cannot be opened: %s", path, strerror(errno));
        view_say(v, FNL_LOG_ERROR, text);
        return;
    }
    f->browses = false;
    view_open(v, path);
}

/* ---- the browser ---- */

static void show_size(uint64_t size) {
    static const char *const units[] = {"B", "KB", "MB", "GB", "TB"};
    double value = (double)size;
    int unit = 0;
    for (; value >= 999.5 && unit < 4; unit++) value /= 1000;
    ui_text(unit == 0 ? "%.0f %s" : "%.3g %s", value, units[unit]);
}

static void show_entries(struct view *v) {
    struct view_files *f = &v->files;
    char label[300], chosen[256] = "";
    if (!ui_table("entries", 2, 0.8f)) return;
    for (uint32_t i = 0; i < f->entry_count; i++) {
        const struct view_entry *entry = &f->entries[i];
        snprintf(label, sizeof label, "%s%s##entry", entry->name, entry->folder ? "/" : "");
        ui_cell();
        if (ui_choice(label, strcmp(entry->name, f->typed) == 0)) snprintf(chosen, sizeof chosen, "%s", entry->name);
        ui_cell();
        if (!entry->folder) show_size(entry->size);
    }
    ui_table_end();
    if (!chosen[0]) return;
    struct stat s;
    char path[VIEW_PATH];
    full_path(f, chosen, path);
    if (f->browser_saves && stat(path, &s) == 0 && !S_ISDIR(s.st_mode))
        snprintf(f->typed, sizeof f->typed, "%s", chosen); /* writing over it takes one more click */
    else
        choose(v, chosen);
}

void view_panel_browser(struct view *v) {
    struct view_files *f = &v->files;
    if (!f->browses) return;
    if (ui_window(f->browser_saves ? "Save the scene" : "Open", &f->browses, 380, 60, 480, 420)) {
        ui_note("%s", f->folder);
        if (ui_button("up")) choose(v, "..");
        ui_tooltip("To the folder above");
        ui_same_line();
        ui_item_width(-110);
        const bool entered = ui_input("##typed", f->typed, sizeof f->typed);
        ui_same_line();
        if (ui_button(f->browser_saves ? "save here" : "open this") || entered) choose(v, f->typed);
        ui_child("folder", 310);
        show_entries(v);
        ui_child_end();
    }
    ui_window_end();
}

/* ---- what is saved ---- */

static void show_size_fields(struct view *v) {
    struct view_files *f = &v->files;
    ui_item_width(70);
    if (ui_count("##wide", &f->save_width, 0, 16384)) view_want(v, 1);
    ui_same_line();
    ui_text("x");
    ui_same_line();
    ui_item_width(70);
    if (ui_count("pixels", &f->save_height, 0, 16384)) view_want(v, 1);
    ui_tooltip("Of pictures that are saved; 0: the window's size");
}

static void show_sequences(struct view *v) {
    struct view_files *f = &v->files;
    if (!ui_header("sequences", false)) return;
    ui_item_width(-70);
    ui_input("pictures", f->pattern, sizeof f->pattern);
    ui_tooltip(".png or .exr, with %d or %04d for their numbers");
    ui_item_width(80);
    ui_count("##turns", &f->turntable_count, 1, 3600);
    ui_same_line();
    if (ui_button("turntable")) view_turntable(v, f->turntable_count);
    ui_tooltip("Writes so many pictures once round the scene; the window waits meanwhile");
    ui_item_width(-70);
    ui_input("path", f->flight_path, sizeof f->flight_path);
    if (ui_button(f->flight.records ? "stop" : "record")) view_toggle_flight(v);
    ui_tooltip("Records the way of the camera until it is stopped (R), for --camera-path");
    ui_same_line();
    if (ui_button("render the path")) view_save_sequence(v, f->flight_path, f->pattern);
    ui_tooltip("Writes a picture of each place that was recorded; the window waits meanwhile");
    if (f->flight.records) ui_note("%u places, %.1f s", f->flight.count, f->flight.seconds);
}

void view_panel_files(struct view *v) {
    struct view_files *f = &v->files;
    show_size_fields(v);
    ui_item_width(-90);
    ui_input("##scene", f->scene_path, sizeof f->scene_path);
    ui_same_line();
    if (ui_button("save scene")) view_save_scene(v, f->scene_path);
    ui_tooltip("Writes the scene with all that was changed, as .glb");
    if (ui_button("open")) view_browse(v, false);
    ui_tooltip("Ctrl and O");
    ui_same_line();
    if (ui_button("save scene as")) view_browse(v, true);
    show_sequences(v);
}

/* ---- two animations ---- */

void view_panel_blend(struct view *v) {
    struct view_files *f = &v->files;
    fnl_animation_info info = {.name = "nothing"};
    char label[96];
    const uint32_t count = v->shown.info.animation_count;
    if (count < 2) return;
    if (f->blend_with < count) fnl_scene_query_animation(v->shown.scene, f->blend_with, &info);
    ui_item_width(150);
    if (ui_combo("blend with", info.name ? info.name : "without a name")) {
        if (ui_choice("nothing", f->blend_with >= count)) f->blend_with = UINT32_MAX;
        for (uint32_t i = 0; i < count; i++) {
            fnl_scene_query_animation(v->shown.scene, i, &info);
            snprintf(label, sizeof label, "%s##blend%u", info.name ? info.name : "without a name", i);
            if (ui_choice(label, i == f->blend_with)) f->blend_with = i;
        }
        view_set_time(v, v->time);
        ui_combo_end();
    }
    if (f->blend_with >= count) return;
    ui_item_width(150);
    if (ui_number("part of it", &f->blend_part, 0, 1, "%.2f")) view_set_time(v, v->time);
}
