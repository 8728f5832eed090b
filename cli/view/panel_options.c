/* SPDX-License-Identifier: MIT */
/* A widget for each row of the table of options. */
#include "view/view.h"

#include "options.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static bool matches(const char *text, const char *filter) {
    const size_t length = strlen(filter);
    for (; *text; text++)
        if (strncasecmp(text, filter, length) == 0) return true;
    return length == 0;
}

static bool set(struct view *v, const char *key, const char *value) {
    view_want(v, 2);
    fnl_frame *frame = view_edited(v);
    if (strcmp(key, "shadows") == 0) *(frame == &v->frame ? &v->own_shadows : &v->compare.own_shadows) = true;
    return fnl_frame_set(&v->host, frame, key, value) == FNL_OK;
}

static void show_names(struct view *v, const fnl_option *o, const char *label, const char *value) {
    const char *name;
    if (!ui_combo(label, value)) return;
    for (uint32_t i = 0; (name = fnl_value_name(o->names, i)); i++) {
        const char *help = fnl_value_help(o->names, i);
        if (ui_choice(name, strcmp(name, value) == 0)) set(v, o->key, name);
        if (help) ui_tooltip(help);
    }
    ui_combo_end();
}

static void show_choices(struct view *v, const fnl_option *o, const char *label, const char *value) {
    char text[16];
    if (!ui_combo(label, value)) return;
    if (o->has_auto && ui_choice("auto", strcmp(value, "auto") == 0)) set(v, o->key, "auto");
    for (uint32_t i = 0; i < o->choice_count; i++) {
        snprintf(text, sizeof text, "%u", o->choices[i]);
        if (ui_choice(text, strcmp(text, value) == 0)) set(v, o->key, text);
    }
    ui_combo_end();
}

/* Powers of two and multiples go in steps of what is allowed. */
static uint32_t nearest_count(const fnl_option *o, uint32_t wanted, uint32_t before) {
    double value = wanted;
    if (o->power_of_two) {
        value = before;
        if (wanted > before) value *= 2;
        if (wanted < before) value /= 2;
    } else if (o->multiple > 1) {
        value = round(value / o->multiple) * o->multiple;
        if (value == before && wanted != before) value += wanted > before ? o->multiple : -(double)o->multiple;
    }
    return (uint32_t)fmax(o->low, fmin(o->high, value));
}

static void show_option(struct view *v, const fnl_option *o, const char *label) {
    char value[64], usual[64], text[64], help[1024], range[256];
    const fnl_frame *frame = view_edited(v);
    fnl_frame_get(frame, o->key, value, sizeof value);
    fnl_frame_get(&v->usual, o->key, usual, sizeof usual);
    ui_item_width(150);
    if (o->kind == FNL_OPTION_SWITCH) {
        bool on = strcmp(value, "on") == 0;
        if (ui_checkbox(label, &on)) set(v, o->key, on ? "on" : "off");
    } else if (o->kind == FNL_OPTION_NAME) {
        show_names(v, o, label, value);
    } else if (o->choice_count > 0) {
        show_choices(v, o, label, value);
    } else if (o->kind == FNL_OPTION_COUNT) {
        const uint32_t before = (uint32_t)strtoul(value, NULL, 10);
        uint32_t count = before;
        if (ui_count(label, &count, (uint32_t)o->low, (uint32_t)fmin(o->high, 4294967295.0))) {
            snprintf(text, sizeof text, "%u", nearest_count(o, count, before));
            set(v, o->key, text);
        }
    } else {
        float number = strtof(value, NULL);
        const bool is_auto = o->has_auto && strcmp(value, "auto") == 0;
        if (is_auto) number = (float)o->low;
        if (ui_number(label, &number, (float)o->low, (float)o->high, is_auto ? "auto" : "%.4g")) {
            snprintf(text, sizeof text, "%.9g", (double)number);
            set(v, o->key, text);
        }
    }
    options_print_range(o, range, sizeof range);
    snprintf(help, sizeof help, "%s: %s\n%s%s", o->key, o->help, range, o->exact ? "\nThe picture stays the same." : "");
    ui_tooltip(help);
    const bool unused = (frame->shading != FNL_SHADING_AUTO && !(o->shadings >> frame->shading & 1)) ||
                        (frame->lists != FNL_LISTS_AUTO && !(o->lists >> frame->lists & 1));
    if (unused) {
        ui_same_line();
        ui_text("(no effect)");
    }
    if (strcmp(value, usual) == 0) return;
    ui_same_line();
    snprintf(text, sizeof text, "reset##%s", o->key);
    if (ui_button(text)) set(v, o->key, usual);
}

/* ---- those that are wanted most, in words ---- */

static void show_everyday(struct view *v) {
    static const struct {
        const char *key, *label;
    } rows[] = {{"aa", "Antialiasing"},           {"msaa", "Samples per pixel"}, {"shadows", "Shadows"},    {"shadow.filter", "Shadow edges"},
                {"shadow.memory", "Shadow memory"}, {"shading", "Shading path"},   {"lists", "Light lists"},  {"transparency", "Transparency"},
                {"tonemap", "Tone mapping"},      {"ground", "Ground"},            {"studio", "Studio"},      {"background", "Background"},
                {"debug", "Debug view"},          {"count-lights", "Count lights"}};
    for (size_t r = 0; r < sizeof rows / sizeof *rows; r++) {
        char label[64];
        fnl_option o;
        snprintf(label, sizeof label, "%s##everyday", rows[r].label);
        for (uint32_t i = 0; fnl_option_query(i, &o); i++)
            if (strcmp(o.key, rows[r].key) == 0) show_option(v, &o, label);
    }
}

/* ---- all ---- */

/* What stands before the first dot of a key; of plain keys "frame". */
static void group_of(const fnl_option *o, char group[32]) {
    const char *dot = strchr(o->key, '.');
    snprintf(group, 32, "%.*s", dot ? (int)(dot - o->key) : 5, dot ? o->key : "frame");
}

static bool is_shown(const struct view *v, const fnl_option *o) {
    if (strcmp(o->key, "width") == 0 || strcmp(o->key, "height") == 0) return false; /* the window's */
    return matches(o->key, v->filter) || matches(o->help, v->filter);
}

/* The group, with all that belongs to it wherever it stands in the table. */
static void show_group(struct view *v, const char *group) {
    char label[48], own[32];
    bool open = true, begun = false;
    fnl_option o;
    for (uint32_t i = 0; open && fnl_option_query(i, &o); i++) {
        group_of(&o, own);
        if (strcmp(own, group) != 0 || !is_shown(v, &o)) continue;
        snprintf(label, sizeof label, "%.31s##options", group);
        if (!begun && !v->filter[0]) open = ui_header(label, strcmp(group, "frame") == 0);
        begun = true;
        if (open) show_option(v, &o, o.key);
    }
}

void view_panel_options(struct view *v) {
    char groups[32][32];
    uint32_t count = 0;
    fnl_option o;
    if (v->compare.mode != VIEW_COMPARE_OFF) view_compare_choose(v);
    if (ui_header("Everyday", true)) show_everyday(v);
    if (!ui_header("All options", false)) return;
    ui_item_width(-60);
    ui_input("filter", v->filter, sizeof v->filter);
    ui_tooltip("Shows the options whose name or description has this in it.");
    for (uint32_t i = 0; fnl_option_query(i, &o) && count < 32; i++) {
        uint32_t at = 0;
        group_of(&o, groups[count]);
        while (strcmp(groups[at], groups[count]) != 0) at++;
        if (at == count) count++;
    }
    for (uint32_t i = 0; i < count; i++) show_group(v, groups[i]);
}
