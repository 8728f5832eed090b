/* SPDX-License-Identifier: MIT */
#include "counters.h"

#include "json_text.h"
#include "print.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- all there are ---- */

static const char *const kinds[] = {"count", "overflow", "switch"};

static json_t *describe(const fnl_counter *c) {
    return json_pack("{s:s,s:s,s:s,s:s,s:o,s:s?}", "key", c->key, "help", c->help, "kind", kinds[c->kind], "unit", c->unit,
                     "shading", options_users_json(c->shadings, FNL_ENUM_SHADING), "needs", *c->needs ? c->needs : NULL);
}

static void print_row(const fnl_counter *c, bool markdown) {
    char paths[256];
    options_print_users(c->shadings, FNL_ENUM_SHADING, paths, sizeof paths);
    const char *unit = c->kind == FNL_COUNTER_SWITCH ? "yes or no" : c->unit, *both = *paths && *c->needs ? ", " : "";
    if (markdown)
        printf("| `%s` | %s | %s | %s%s%s%s%s |\n", c->key, unit, c->help, paths, both, *c->needs ? "`" : "", c->needs,
               *c->needs ? "`" : "");
    else
        printf(*paths || *c->needs ? "%s%s%s%s\n    %s\n%s%s%s%s\n" : "%s%s%s%s\n    %s\n%s%s%s%s", c->key, *unit ? " (" : "", unit, *unit ? ")" : "", c->help,
               *paths || *c->needs ? "    with: " : "", paths, both, c->needs);
}

void counters_print(enum options_form form) {
    fnl_counter c;
    json_t *all = json_array();
    if (form == OPTIONS_MARKDOWN)
        puts("<!-- SPDX-License-Identifier: MIT -->\n"
             "# Counters\n"
             "\n"
             "Numbers that belong to one technique, besides those that every frame has. `fanal render` prints those of its "
             "frame below the times of the\n"
             "passes. `--stats` writes them as JSON, where `coarse.by-depth` is `by_depth` in the object `coarse`. `fanal "
             "bench` has a column for each.\n"
             "In a program `fnl_counter_find()` finds one in `fnl_frame_stats`. A frame has the counters of what it does, "
             "and no others: the last\n"
             "column names the shading paths that have one, and the option that it needs. This page is what `fanal render "
             "--counters --markdown`\n"
             "prints.\n"
             "\n"
             "| key | unit | | only with |\n"
             "|---|---|---|---|");
    for (uint32_t i = 0; fnl_counter_query(i, &c); i++) {
        if (form == OPTIONS_JSON)
            json_array_append_new(all, describe(&c));
        else
            print_row(&c, form == OPTIONS_MARKDOWN);
    }
    if (form == OPTIONS_JSON) json_text_print(all, JSON_INDENT(1));
    json_decref(all);
}

/* ---- those of a frame ---- */

void counters_print_table(const fnl_frame_stats *stats) {
    char value[32];
    if (stats->counter_count) printf("\n  %-28s %12s\n", "counter", "value");
    for (uint32_t i = 0; i < stats->counter_count; i++) {
        const fnl_counter *c = &stats->counters[i];
        if (c->kind == FNL_COUNTER_SWITCH)
            snprintf(value, sizeof value, "%s", c->value ? "yes" : "no");
        else if (strcmp(c->unit, "bytes") == 0)
            snprintf(value, sizeof value, "%.1f KiB", (double)c->value / 1024);
        else
            snprintf(value, sizeof value, "%" PRIu64, c->value);
        printf("  %-28s %12s  %s\n", c->key, value, c->help);
    }
}

static json_t *value_json(const fnl_counter *c) {
    return c->kind == FNL_COUNTER_SWITCH ? json_boolean(c->value) : json_integer((json_int_t)c->value);
}

/* The parts of a key as JSON spells them. */
struct place {
    char group[64], name[64];
};

static struct place place_of(const char *key) {
    struct place place;
    size_t length = strcspn(key, ".");
    snprintf(place.group, sizeof place.group, "%.*s", (int)length, key);
    snprintf(place.name, sizeof place.name, "%s", key[length] ? key + length + 1 : "");
    for (char *dash = place.group; (dash = strchr(dash, '-'));) *dash = '_';
    for (char *dash = place.name; (dash = strchr(dash, '-'));) *dash = '_';
    return place;
}

void counters_set_groups(json_t *object, const fnl_frame_stats *stats) {
    fnl_counter c;
    for (uint32_t i = 0; i < stats->counter_count; i++) {
        struct place place = place_of(stats->counters[i].key);
        if (!json_object_get(object, place.group)) json_object_set_new(object, place.group, json_object());
    }
    for (uint32_t i = 0; fnl_counter_query(i, &c); i++) {
        const fnl_counter *own = fnl_counter_find(stats, c.key);
        struct place place = place_of(c.key);
        json_t *group = json_object_get(object, place.group);
        if (json_is_object(group))
            json_object_set_new(group, place.name, own ? value_json(own) : json_null());
        else
            json_object_set_new(object, place.group, json_null());
    }
}

json_t *counters_json(const fnl_frame_stats *stats) {
    json_t *object = json_object();
    for (uint32_t i = 0; i < stats->counter_count; i++)
        json_object_set_new(object, stats->counters[i].key, value_json(&stats->counters[i]));
    return object;
}

uint64_t counters_value(const fnl_frame_stats *stats, const char *key) {
    const fnl_counter *c = fnl_counter_find(stats, key);
    return c ? c->value : 0;
}

uint64_t counters_overflow(const fnl_frame_stats *stats) {
    uint64_t sum = 0;
    for (uint32_t i = 0; i < stats->counter_count; i++)
        if (stats->counters[i].kind == FNL_COUNTER_OVERFLOW) sum += stats->counters[i].value;
    for (uint32_t i = 0; i < stats->view_count; i++) sum += counters_overflow(&stats->views[i]);
    return sum;
}
