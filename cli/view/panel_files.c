/* SPDX-License-Identifier: MIT */
/* Files: a browser of folders, to open and to save; and what is saved, in the panel of the scene. */
#include "view/view.h"

#include <dirent.h>
#include <errno.h>
#include <math.h>
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
    v->files.typed[0] = v->files.overwrites[0] = 0;
    v->files.begins = true;
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

/* ---- names that are not taken ---- */

bool view_exists(const char *path) { return access(path, F_OK) == 0; }

void view_free_name(char *path, size_t capacity) {
    char base[VIEW_PATH], end[64] = "";
    const char *dot = strrchr(path, '.'), *slash = strrchr(path, '/');
    if (dot && (!slash || dot > slash) && strlen(dot) < sizeof end) snprintf(end, sizeof end, "%s", dot);
    snprintf(base, sizeof base, "%.*s", (int)(strlen(path) - strlen(end)), path);
    for (uint32_t i = 1; view_exists(path) && i < 10000; i++)
        if (snprintf(path, capacity, "%s-%u%s", base, i, end) >= (int)capacity) return;
}

/* Writes over a file only after one more click. */
static bool save_scene(struct view *v, const char *path) {
    struct view_files *f = &v->files;
    if (view_ends_with(path, ".glb") && view_exists(path) && strcmp(f->overwrites, path) != 0) {
        snprintf(f->overwrites, sizeof f->overwrites, "%s", path);
        return false;
    }
    f->overwrites[0] = 0;
    return view_save_scene(v, path);
}

static bool show_overwrite(struct view *v) {
    struct view_files *f = &v->files;
    bool saved = false;
    if (!f->overwrites[0]) return false;
    const char *slash = strrchr(f->overwrites, '/');
    ui_warning("%s exists.", slash ? slash + 1 : f->overwrites);
    if (ui_button("overwrite it")) {
        snprintf(f->scene_path, sizeof f->scene_path, "%s", f->overwrites);
        f->overwrites[0] = 0;
        saved = view_save_scene(v, f->scene_path);
    }
    ui_same_line();
    if (ui_button("keep it")) f->overwrites[0] = 0;
    return saved;
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
        f->begins = true;
        return;
    }
    if (f->browser_saves) {
        if (save_scene(v, path)) {
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
    uint32_t shown = 0;
    if (ui_table("entries", 2, 0.8f)) {
        for (uint32_t i = 0; i < f->entry_count; i++) {
            const struct view_entry *entry = &f->entries[i];
            if (!f->browser_saves && !strcasestr(entry->name, f->typed)) continue;
            shown++;
            snprintf(label, sizeof label, "%s%s##entry", entry->name, entry->folder ? "/" : "");
            ui_cell();
            if (ui_choice(label, strcmp(entry->name, f->typed) == 0)) snprintf(chosen, sizeof chosen, "%s", entry->name);
            ui_cell();
            if (!entry->folder) show_size(entry->size);
        }
        ui_table_end();
    }
    if (shown == 0 && !f->browser_saves) ui_note(f->typed[0] ? "No file name matches." : "There are no models here: .glb, .gltf, .hdr and .exr files would be listed.");
    if (!chosen[0]) return;
    struct stat s;
    char path[VIEW_PATH];
    full_path(f, chosen, path);
    if (f->browser_saves && stat(path, &s) == 0 && !S_ISDIR(s.st_mode))
        snprintf(f->typed, sizeof f->typed, "%s", chosen); /* writing over it takes one more click */
    else
        choose(v, chosen);
}

/* What was typed; of a part of a name the only file that has it. */
static void enter_typed(struct view *v) {
    struct view_files *f = &v->files;
    char path[VIEW_PATH], only[256] = "";
    uint32_t count = 0;
    full_path(f, f->typed, path);
    for (uint32_t i = 0; i < f->entry_count; i++) {
        if (!strcasestr(f->entries[i].name, f->typed)) continue;
        snprintf(only, sizeof only, "%s", f->entries[i].name);
        count++;
    }
    const bool whole = f->browser_saves || view_exists(path) || strncmp(f->typed, "builtin:", 8) == 0;
    snprintf(path, sizeof path, "%s", whole || count != 1 ? f->typed : only);
    choose(v, path);
}

void view_panel_browser(struct view *v) {
    struct view_files *f = &v->files;
    if (!f->browses) return;
    if (ui_dialog(f->browser_saves ? "Save the scene" : "Open a scene", &f->browses, 560, 460)) {
        ui_note("%s", f->folder);
        if (ui_button("up")) choose(v, "..");
        ui_tooltip("To the folder above");
        ui_same_line();
        ui_item_width(-110);
        if (f->begins) ui_focus();
        f->begins = false;
        const bool entered = ui_input("##typed", f->typed, sizeof f->typed);
        ui_tooltip(f->browser_saves ? "The name of the file: .glb" : "Type part of a name to filter, or a path or builtin:NAME and Enter");
        ui_same_line();
        if (ui_button(f->browser_saves ? "save here" : "open this") || entered) enter_typed(v);
        if (f->browser_saves && show_overwrite(v)) f->browses = false;
        ui_child("folder", fmaxf(ui_height_left() - 4, 60));
        show_entries(v);
        ui_child_end();
    }
    ui_window_end();
    if (!f->browses) f->overwrites[0] = 0;
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

/* Sequences from the window leave pictures that are there alone. */
static bool is_free(struct view *v) {
    char first[600], text[800];
    snprintf(first, sizeof first, v->files.pattern, 0u);
    if (!view_exists(first)) return true;
    snprintf(text, sizeof text, "%.500s exists: choose another name for the pictures", first);
    view_say(v, FNL_LOG_ERROR, text);
    view_want(v, 2);
    return false;
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
    if (ui_button("turntable") && is_free(v)) view_turntable(v, f->turntable_count);
    ui_tooltip("Writes so many pictures once round the scene; the window waits meanwhile");
    ui_item_width(-70);
    ui_input("path", f->flight_path, sizeof f->flight_path);
    if (ui_button(f->flight.records ? "stop" : "record")) view_toggle_flight(v);
    ui_tooltip("Records the camera path until you stop it (V), for --camera-path");
    ui_same_line();
    if (ui_button("render the path") && is_free(v)) view_save_sequence(v, f->flight_path, f->pattern);
    ui_tooltip("Writes a picture of each place that was recorded; the window waits meanwhile");
    if (f->flight.records) ui_note("%u %s, %.1f s", f->flight.count, view_plural(f->flight.count, "place", "places"), f->flight.seconds);
}

void view_save_next_picture(struct view *v) {
    view_free_name(v->save_path, sizeof v->save_path);
    view_save_picture(v, v->save_path);
}

void view_panel_files(struct view *v) {
    struct view_files *f = &v->files;
    ui_text("Picture");
    ui_item_width(200);
    ui_input("##path", v->save_path, sizeof v->save_path);
    ui_same_line();
    if (ui_button("save")) view_save_next_picture(v);
    ui_tooltip("Same as 'fanal render': .png or .exr (P). Adds a number if the name is taken.");
    show_size_fields(v);
    if (ui_button("copy the command")) view_copy_command(v);
    ui_tooltip("Which 'fanal render' makes this picture: into the clipboard, and to the terminal");
    ui_separator();
    ui_text("Scene");
    ui_item_width(200);
    ui_input("##scene", f->scene_path, sizeof f->scene_path);
    ui_same_line();
    if (ui_button("save scene")) save_scene(v, f->scene_path);
    ui_tooltip("Writes the scene with all that was changed, as .glb");
    show_overwrite(v);
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
            if (info.name && info.name[0])
                snprintf(label, sizeof label, "with %.60s##blend%u", info.name, i);
            else
                snprintf(label, sizeof label, "with animation %u##blend", i);
            if (ui_choice(label, i == f->blend_with)) f->blend_with = i;
        }
        view_set_time(v, v->time);
        ui_combo_end();
    }
    if (f->blend_with >= count) return;
    ui_item_width(150);
    if (ui_number("part of it", &f->blend_part, 0, 1, "%.2f")) view_set_time(v, v->time);
}
