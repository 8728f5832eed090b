/* SPDX-License-Identifier: MIT */
/* What the window remembers: a file of lines "key value". */
#include "view/view.h"

#include "input.h"
#include "output.h"
#include "print.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

const char *const view_present_names[VIEW_PRESENT_COUNT] = {"fifo", "mailbox", "immediate"};
const char *const view_color_names[VIEW_COLOR_COUNT] = {"srgb", "scrgb", "hdr10"};

struct view_settings view_settings_default(void) {
    return (struct view_settings){.width = 1280, .height = 720, .dark = true, .panels = true};
}

/* By the XDG base directories; false: there is no such folder. */
static bool settings_path(char *out, size_t capacity) {
    const char *folder = getenv("XDG_CONFIG_HOME"), *home = getenv("HOME");
    int length = -1;
    if (folder && folder[0] == '/')
        length = snprintf(out, capacity, "%s/fanal/view", folder);
    else if (home && home[0] == '/')
        length = snprintf(out, capacity, "%s/.config/fanal/view", home);
    return length > 0 && (size_t)length < capacity;
}

/* ---- rows: how each stands in the file ---- */

static const struct {
    const char *key;
    enum { COUNT, NUMBER, SWITCH } kind;
    size_t offset;
    double low, high;
} rows[] = {{"width", COUNT, offsetof(struct view_settings, width), 64, 16384},
            {"height", COUNT, offsetof(struct view_settings, height), 64, 16384},
            {"scale", NUMBER, offsetof(struct view_settings, scale), 0, 4},
            {"dark", SWITCH, offsetof(struct view_settings, dark), 0, 1},
            {"panels", SWITCH, offsetof(struct view_settings, panels), 0, 1},
            {"present", COUNT, offsetof(struct view_settings, present), 0, VIEW_PRESENT_COUNT - 1},
            {"color", COUNT, offsetof(struct view_settings, color), 0, VIEW_COLOR_COUNT - 1},
            {"navigation", COUNT, offsetof(struct view_settings, navigation), 0, VIEW_NAVIGATION_COUNT - 1}};
enum { ROW_COUNT = sizeof rows / sizeof *rows };

static bool take_line(struct view_settings *s, char *line) {
    char *value = strchr(line, ' ');
    if (!value) return false;
    *value++ = 0;
    if (strcmp(line, "recent") == 0) {
        if (s->recent_count == VIEW_RECENT || strlen(value) >= sizeof s->recent[0] || !*value) return false;
        strcpy(s->recent[s->recent_count++], value);
        return true;
    }
    char *end;
    const double number = strtod(value, &end);
    if (end == value || *end) return false;
    for (size_t i = 0; i < ROW_COUNT; i++) {
        char *at = (char *)s + rows[i].offset;
        if (strcmp(line, rows[i].key) != 0) continue;
        if (!(number >= rows[i].low && number <= rows[i].high)) return false;
        if (rows[i].kind == NUMBER)
            *(float *)at = (float)number;
        else if (rows[i].kind == SWITCH)
            *(bool *)at = number != 0;
        else
            *(uint32_t *)at = (uint32_t)number;
        return true;
    }
    return false;
}

void view_settings_load(struct view_settings *s) {
    char path[1024], line[1100];
    *s = view_settings_default();
    FILE *file = settings_path(path, sizeof path) && access(path, F_OK) == 0 ? input_open(path, 1 << 20) : NULL;
    if (!file) return;
    for (uint32_t number = 1; fgets(line, sizeof line, file); number++) {
        line[strcspn(line, "\n")] = 0;
        if (*line && !take_line(s, line)) fprintf(stderr, "fanal: warning: %s:%u: not a setting, left out\n", path, number);
    }
    fclose(file);
}

/* All folders above a file. */
static void make_folders(char *path) {
    for (char *at = path + 1; (at = strchr(at, '/')); at++) {
        *at = 0;
        mkdir(path, 0755); /* if it cannot be made, neither can the file */
        *at = '/';
    }
}

bool view_settings_save(const struct view_settings *s) {
    char path[1024];
    struct output out;
    if (!settings_path(path, sizeof path)) return true; /* a user without a home */
    make_folders(path);
    if (!output_begin(path, &out)) return false;
    for (size_t i = 0; i < ROW_COUNT; i++) {
        const char *at = (const char *)s + rows[i].offset;
        if (rows[i].kind == NUMBER)
            fprintf(out.stream, "%s %.9g\n", rows[i].key, (double)*(const float *)at);
        else
            fprintf(out.stream, "%s %u\n", rows[i].key, rows[i].kind == SWITCH ? *(const bool *)at : *(const uint32_t *)at);
    }
    for (uint32_t i = 0; i < s->recent_count; i++) {
        fputs("recent ", out.stream);
        fwrite(s->recent[i], 1, strlen(s->recent[i]), out.stream); /* as it is: it is read again */
        fputc('\n', out.stream);
    }
    return output_commit(&out);
}

void view_settings_note_scene(struct view_settings *s, const char *source) {
    char whole[sizeof s->recent[0]];
    char *resolved = strncmp(source, "builtin:", 8) == 0 ? NULL : realpath(source, NULL);
    const char *name = resolved ? resolved : source;
    uint32_t at = 0;
    if (strlen(name) < sizeof whole && !strchr(name, '\n')) {
        strcpy(whole, name);
        while (at < s->recent_count && strcmp(s->recent[at], whole) != 0) at++;
        if (at == s->recent_count && s->recent_count < VIEW_RECENT) s->recent_count++;
        if (at == VIEW_RECENT) at--;
        memmove(s->recent + 1, s->recent, at * sizeof s->recent[0]);
        strcpy(s->recent[0], whole);
    }
    free(resolved);
}
