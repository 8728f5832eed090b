/* SPDX-License-Identifier: MIT */
#include "options.h"

#include "json_text.h"
#include "print.h"

#include <math.h>
#include <float.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const struct {
    const char *name, *key;
} named[] = {{"shading", "shading"},
             {"lists", "lists"},
             {"msaa", "msaa"},
             {"msaa-method", "deferred.msaa-method"},
             {"gbuffer", "gbuffer.layout"},
             {"shadows", "shadows"},
             {"contact-shadows", "shadow.contact-length"},
             {"energy", "material.energy"},
             {"transparency", "transparency"},
             {"decals", "decals"},
             {"aa", "aa"},
             {"cull", "culling"},
             {"geometry", "geometry"},
             {"occlusion", "occlusion"},
             {"light-lod", "light-lod"},
             {"stereo-path", "stereo.path"},
             {"tonemap", "tonemap"},
             {"debug", "debug"}};

const char *options_named(uint32_t index, const char **key) {
    if (index >= sizeof named / sizeof *named) return NULL;
    if (key) *key = named[index].key;
    return named[index].name;
}

static bool has_option(const struct option *options, int count, const char *name) {
    for (int i = 0; i < count; i++)
        if (strcmp(options[i].name, name) == 0) return true;
    return false;
}

void options_make_long(const struct option *own, int count, bool several, struct option *out) {
    const char *name, *key;
    int end = count;
    fnl_option o;
    memcpy(out, own, (size_t)count * sizeof *out);
    for (uint32_t i = 0; (name = options_named(i, &key)) && end + 1 < count + OPTIONS_NAMED_MAX; i++) {
        bool is_switch = fnl_option_find(key, &o) && o.kind == FNL_OPTION_SWITCH;
        if (!has_option(own, count, name))
            out[end++] = (struct option){name, is_switch && !several ? no_argument : required_argument, NULL, OPTIONS_NAMED + (int)i};
    }
    out[end] = (struct option){0};
}

/* ---- setting ---- */

/* The library's line without the function that it is about: the option says that. */
static void keep_line(void *user, fnl_log_level level, const char *line) {
    (void)level;
    const char *after = strstr(line, ": ");
    snprintf(user, 1024, "%s", after ? after + 2 : line);
}

bool options_set(fnl_frame *frame, const char *option, const char *key, const char *value) {
    char line[1024] = "";
    fnl_host host = fnl_host_default();
    host.user = line;
    host.log = keep_line;
    if (fnl_frame_set(&host, frame, key, value) == FNL_OK) return true;
    bool is_named = strcmp(option, "set") != 0 && strcmp(option, "vary") != 0 && strncmp(line, key, strlen(key)) == 0;
    if (is_named) fprintf(stderr, "fanal: error: --%s%s\n", option, line + strlen(key)); /* "--gbuffer is 'x', must be …" */
    else fprintf(stderr, "fanal: error: --%s: %s\n", option, line);
    return false;
}

bool options_set_text(fnl_frame *frame, const char *option, const char *text, const char **key) {
    char name[64];
    size_t length = strcspn(text, "=");
    fnl_option found;
    if (!text[length] || length >= sizeof name) {
        fprintf(stderr, "fanal: error: --%s: '%.80s' is not KEY=VALUE; 'fanal render --options' prints the keys\n", option, text);
        return false;
    }
    snprintf(name, sizeof name, "%.*s", (int)length, text);
    if (!fnl_option_find(name, &found)) {
        fprintf(stderr, "fanal: error: --%s: there is no option '%s'; 'fanal render --options' prints the keys\n", option, name);
        return false;
    }
    if (key) *key = found.key;
    return options_set(frame, option, found.key, text + length + 1);
}

/* ---- printing ---- */

bool options_print_values(const char *key, const char *value) {
    fnl_option option;
    const char *name;
    if (!value || strcmp(value, "help") != 0 || !fnl_option_find(key, &option) || option.kind != FNL_OPTION_NAME) return false;
    for (uint32_t i = 0; (name = fnl_value_name(option.names, i)); i++) {
        const char *help = fnl_value_help(option.names, i);
        if (help) printf("%-15s %s\n", name, help);
        else printf("%s\n", name);
    }
    return true;
}

static void add(char *text, size_t capacity, const char *more) {
    size_t length = strlen(text);
    if (length < capacity) snprintf(text + length, capacity - length, "%s", more);
}

static void print_choices(const fnl_option *o, char *text, size_t capacity) {
    char number[16];
    for (uint32_t i = 0; i < o->choice_count; i++) {
        snprintf(number, sizeof number, "%s%u", i == 0 ? "" : i + 1 < o->choice_count ? ", " : " or ", o->choices[i]);
        add(text, capacity, number);
    }
}

void options_print_range(const fnl_option *o, char *text, size_t capacity) {
    const char *name;
    char range[96];
    *text = 0;
    switch (o->kind) {
    case FNL_OPTION_SWITCH:
        add(text, capacity, "on, off");
        return;
    case FNL_OPTION_NAME:
        for (uint32_t i = 0; (name = fnl_value_name(o->names, i)); i++) {
            add(text, capacity, i ? ", " : "");
            add(text, capacity, name);
        }
        return;
    default:
        if (o->choice_count) print_choices(o, text, capacity);
        else if (o->high >= (double)FLT_MAX) snprintf(text, capacity, "%s %g", o->above_low ? "above" : "at least", o->low);
        else snprintf(text, capacity, "%g .. %.7g", o->low, o->high);
        if (o->multiple > 1) {
            snprintf(range, sizeof range, ", a multiple of %u", o->multiple);
            add(text, capacity, range);
        }
        if (o->power_of_two) add(text, capacity, ", a power of two");
        if (o->has_auto) add(text, capacity, ", or auto");
        if (*o->unit) {
            snprintf(range, sizeof range, " %s", o->unit);
            add(text, capacity, range);
        }
    }
}

json_t *options_users_json(uint32_t bits, fnl_enum type) {
    const char *name;
    if (bits == UINT32_MAX) return json_null();
    json_t *array = json_array();
    for (uint32_t i = 0; (name = fnl_value_name(type, i)); i++)
        if (bits >> i & 1 && strcmp(name, "auto") != 0) json_array_append_new(array, json_string(name));
    return array;
}

static json_t *values_of(const fnl_option *o) {
    const char *name;
    json_t *array = json_array();
    for (uint32_t i = 0; i < o->choice_count; i++) json_array_append_new(array, json_integer(o->choices[i]));
    for (uint32_t i = 0; o->kind == FNL_OPTION_NAME && (name = fnl_value_name(o->names, i)); i++)
        json_array_append_new(array, json_string(name));
    if (json_array_size(array)) return array;
    json_decref(array);
    return json_null();
}

static json_t *describe(const fnl_option *o, const fnl_frame *usual) {
    static const char *const kinds[] = {"switch", "count", "number", "name"};
    char value[64];
    bool has_range = (o->kind == FNL_OPTION_COUNT && !o->choice_count) || o->kind == FNL_OPTION_NUMBER;
    fnl_frame_get(usual, o->key, value, sizeof value);
    return json_pack("{s:s,s:s,s:s,s:s,s:s,s:o,s:o,s:o,s:o,s:o,s:b}", "key", o->key, "help", o->help, "kind", kinds[o->kind],
                     "default", value, "unit", o->unit, "values", values_of(o), "low",
                     has_range ? json_real(o->low) : json_null(), "high",
                     has_range && o->high < (double)FLT_MAX ? json_real(o->high) : json_null(), "shading",
                     options_users_json(o->shadings, FNL_ENUM_SHADING), "lists",
                     options_users_json(o->lists, FNL_ENUM_LISTS), "same_picture", o->exact);
}

void options_print_users(uint32_t bits, fnl_enum type, char *text, size_t capacity) {
    uint32_t all = 0, listed = 0;
    const char *name;
    *text = 0;
    if (bits == UINT32_MAX) return;
    for (uint32_t i = 0; (name = fnl_value_name(type, i)); i++) {
        if (strcmp(name, "auto") == 0) continue;
        all++;
        listed += bits >> i & 1;
    }
    bool inverse = listed * 2 > all;
    if (inverse) add(text, capacity, "not ");
    for (uint32_t i = 0, n = 0; (name = fnl_value_name(type, i)); i++) {
        if (strcmp(name, "auto") == 0 || (bits >> i & 1) == inverse) continue;
        add(text, capacity, n++ ? ", " : "");
        add(text, capacity, name);
    }
}

static void print_option(const fnl_option *o, const fnl_frame *usual) {
    char range[512], value[64], paths[256], lists[256];
    options_print_range(o, range, sizeof range);
    fnl_frame_get(usual, o->key, value, sizeof value);
    options_print_users(o->shadings, FNL_ENUM_SHADING, paths, sizeof paths);
    options_print_users(o->lists, FNL_ENUM_LISTS, lists, sizeof lists);
    printf("%s=%s\n    %s\n    takes: %s\n", o->key, value, o->help, range);
    if (*paths) printf("    shading: %s\n", paths);
    if (*lists) printf("    lists: %s\n", lists);
}

/* A cell of a table must not have a bar. */
static void print_row(const fnl_option *o, const fnl_frame *usual) {
    char range[512], value[64], paths[256], lists[256];
    options_print_range(o, range, sizeof range);
    fnl_frame_get(usual, o->key, value, sizeof value);
    options_print_users(o->shadings, FNL_ENUM_SHADING, paths, sizeof paths);
    options_print_users(o->lists, FNL_ENUM_LISTS, lists, sizeof lists);
    printf("| `%s` | `%s` | %s | %s | %s%s%s |\n", o->key, value, range, o->help, *paths ? paths : *lists ? "" : "all", *paths && *lists ? "; " : "", lists);
}

static void print_markdown(const fnl_frame *usual) {
    fnl_option o;
    puts("<!-- SPDX-License-Identifier: MIT -->\n"
         "# Options of a frame\n"
         "\n"
         "`fanal render --set KEY=VALUE` and `fanal bench --set` and `--vary` take each of these by its key; so does `fnl_frame_set()` in a\n"
         "program, where the key with dots and underscores is the member of `fnl_frame`. The last column names the shading paths and light lists\n"
         "that use an option; with others it has no effect, and the command says so. This page is what `fanal render --options --markdown`\n"
         "prints.\n"
         "\n"
         "| key | default | takes | | used by |\n"
         "|---|---|---|---|---|");
    for (uint32_t i = 0; fnl_option_query(i, &o); i++) print_row(&o, usual);
}

void options_print(enum options_form form) {
    const fnl_frame usual = fnl_frame_default();
    fnl_option o;
    if (form == OPTIONS_MARKDOWN) {
        print_markdown(&usual);
        return;
    }
    if (form == OPTIONS_TEXT) {
        puts("Options of a frame with their defaults, for --set KEY=VALUE:\n");
        for (uint32_t i = 0; fnl_option_query(i, &o); i++) print_option(&o, &usual);
        return;
    }
    json_t *all = json_array();
    for (uint32_t i = 0; fnl_option_query(i, &o); i++) json_array_append_new(all, describe(&o, &usual));
    json_text_print(all, JSON_INDENT(1) | JSON_REAL_PRECISION(9));
    json_decref(all);
}

json_t *options_json(const fnl_frame *frame) {
    json_t *json = json_object();
    fnl_option o;
    char text[64];
    for (uint32_t i = 0; fnl_option_query(i, &o); i++) {
        fnl_frame_get(frame, o.key, text, sizeof text);
        bool is_number = (o.kind == FNL_OPTION_COUNT || o.kind == FNL_OPTION_NUMBER) && strcmp(text, "auto") != 0;
        json_t *value = o.kind == FNL_OPTION_SWITCH ? json_boolean(strcmp(text, "on") == 0)
                        : o.kind == FNL_OPTION_COUNT ? json_integer(strtoll(text, NULL, 10))
                        : is_number                  ? json_real(strtod(text, NULL))
                                                     : json_string(text);
        json_object_set_new(json, o.key, value);
    }
    return json;
}
