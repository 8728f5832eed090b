/* SPDX-License-Identifier: MIT */
/* What a candidate sets besides shading and lists: options of the frame, as one text "key=value,key=value". */
#include "bench.h"

#include "options.h"
#include "print.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

fnl_frame bench_frame(void) {
    fnl_frame frame = fnl_frame_default();
    frame.msaa = 1;
    frame.aa = FNL_ANTIALIASING_NONE;
    frame.shadows = FNL_SHADOWS_OFF;
    frame.studio = false;
    frame.ground = FNL_GROUND_OFF;
    frame.background = FNL_BACKGROUND_SCENE;
    return frame;
}

/* Cases and candidates have these themselves, and results come of those. */
static bool is_reserved(const char *key) {
    static const char *const keys[] = {"width", "height", "shading", "lists", "msaa", "debug", "timers", "count-lights", "pin-choice"};
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++)
        if (strcmp(key, keys[i]) == 0) return true;
    return false;
}

bool bench_ways_find(const char *option, const char *key, fnl_option *out) {
    if (!fnl_option_find(key, out)) {
        fprintf(stderr, "fanal: error: --%s: there is no option '%s'; 'fanal render --options' prints the keys\n", option, key);
        return false;
    }
    if (!is_reserved(key)) return true;
    fprintf(stderr, "fanal: error: --%s: %s cannot be set here; see 'fanal bench --help'\n", option, key);
    return false;
}

/* Some options matter with one sample alone, or with several. */
bool bench_way_heeded(const fnl_option *o, const char *value, fnl_shading shading, fnl_light_lists lists, uint32_t msaa) {
    if (!(o->shadings >> shading & 1) || !(o->lists >> lists & 1)) return false;
    if (strncmp(o->key, "deferred.msaa-", 14) == 0) return msaa > 1;
    if (strcmp(o->key, "visibility.barycentrics") == 0 || strcmp(o->key, "visibility.grid") == 0) return msaa == 1;
    bool by_gbuffer = shading == FNL_SHADING_DEFERRED || shading == FNL_SHADING_DEFERRED_VOLUMES || shading == FNL_SHADING_MOBILE;
    if (strcmp(o->key, "decals") == 0 && strcmp(value, "gbuffer") == 0) return by_gbuffer && msaa == 1; /* else lists step in */
    return true;
}

/* ---- texts ---- */

void bench_ways_print(const fnl_frame *frame, bool exact, char *text, size_t capacity) {
    const fnl_frame usual = bench_frame();
    fnl_option o;
    size_t length = 0;
    *text = 0;
    for (uint32_t i = 0; fnl_option_query(i, &o) && length < capacity; i++) {
        char value[64], default_value[64];
        if (is_reserved(o.key) || (o.exact && !exact)) continue;
        fnl_frame_get(frame, o.key, value, sizeof value);
        fnl_frame_get(&usual, o.key, default_value, sizeof default_value);
        if (strcmp(value, default_value) != 0)
            length += (size_t)snprintf(text + length, capacity - length, "%s%s=%s", length ? "," : "", o.key, value);
    }
}

bool bench_ways_apply(const char *option, const char *text, fnl_frame *frame) {
    char copy[1024], *rest = copy;
    fnl_option o;
    if (!*text) return true;
    if (snprintf(copy, sizeof copy, "%s", text) >= (int)sizeof copy) return false;
    for (char *part; (part = strsep(&rest, ","));) {
        char key[64];
        snprintf(key, sizeof key, "%.*s", (int)strcspn(part, "="), part);
        if (part[strcspn(part, "=")] && !bench_ways_find(option, key, &o)) return false;
        if (!options_set_text(frame, option, part, NULL)) return false;
    }
    return true;
}

void bench_ways_of(const char *options, char *text, size_t capacity) {
    fnl_frame frame = bench_frame();
    *text = 0;
    if (bench_ways_apply("set", options, &frame)) bench_ways_print(&frame, false, text, capacity);
}

void bench_ways_reset_lists(fnl_frame *frame) {
    const fnl_frame usual = bench_frame();
    frame->list = usual.list;
    frame->tiles = usual.tiles;
    frame->clusters = usual.clusters;
    frame->fine = usual.fine;
    frame->raster = usual.raster;
}

void bench_ways_without_lists(const char *options, char *text, size_t capacity) {
    fnl_frame frame = bench_frame();
    *text = 0;
    if (!bench_ways_apply("set", options, &frame)) return;
    bench_ways_reset_lists(&frame);
    bench_ways_print(&frame, true, text, capacity);
}

void bench_ways_describe(const struct bench_candidate *candidate, json_t *result) {
    char copy[1024], *rest = copy, ways[1024];
    json_t *settings = json_object();
    snprintf(copy, sizeof copy, "%s", candidate->options);
    for (char *part; *candidate->options && (part = strsep(&rest, ","));) {
        char *value = strchr(part, '=');
        if (!value) continue;
        *value++ = 0;
        json_object_set_new(settings, part, json_string(value));
    }
    bench_ways_of(candidate->options, ways, sizeof ways);
    json_object_set_new(result, "ways", json_string(ways));
    json_object_set_new(result, "settings", settings);
}

/* ---- what is varied ---- */

static bool add_value(struct bench_vary *vary, const char *option, const char *value) {
    fnl_frame scratch = bench_frame();
    if (!options_set(&scratch, option, vary->option.key, value)) return false;
    if (vary->count == BENCH_VALUES_MAX) {
        fprintf(stderr, "fanal: error: --%s: more than %d values\n", option, BENCH_VALUES_MAX);
        return false;
    }
    snprintf(vary->values[vary->count++], sizeof *vary->values, "%s", value);
    return true;
}

/* Every value but `auto`, which is one of the others. */
static bool add_every(struct bench_vary *vary, const char *option) {
    const fnl_option *o = &vary->option;
    const char *name;
    char number[16];
    if (o->kind == FNL_OPTION_SWITCH) return add_value(vary, option, "off") && add_value(vary, option, "on");
    for (uint32_t i = 0; o->kind == FNL_OPTION_NAME && (name = fnl_value_name(o->names, i)); i++)
        if (strcmp(name, "auto") != 0 && !add_value(vary, option, name)) return false;
    for (uint32_t i = 0; i < o->choice_count; i++) {
        snprintf(number, sizeof number, "%u", o->choices[i]);
        if (!add_value(vary, option, number)) return false;
    }
    if (vary->count) return true;
    fprintf(stderr, "fanal: error: --%s: %s has too many values for 'all': name some\n", option, o->key);
    return false;
}

bool bench_vary_add(struct bench_matrix *m, const char *option, const char *key, const char *values) {
    char copy[2048], *rest = copy;
    uint32_t i = 0;
    fnl_option o;
    if (!bench_ways_find(option, key, &o)) return false;
    if (snprintf(copy, sizeof copy, "%s", values) >= (int)sizeof copy) return false;
    while (i < m->vary_count && strcmp(m->varied[i].option.key, key) != 0) i++;
    if (i == BENCH_VARY_MAX) {
        fprintf(stderr, "fanal: error: --%s: more than %d options vary\n", option, BENCH_VARY_MAX);
        return false;
    }
    if (i == m->vary_count) m->vary_count++;
    m->varied[i] = (struct bench_vary){.option = o}; /* later values replace earlier ones */
    if (strcmp(values, "all") == 0 && !(o.kind == FNL_OPTION_NAME && fnl_value_find(o.names, "all", NULL)))
        return add_every(&m->varied[i], option);
    for (char *part; (part = strsep(&rest, ","));)
        if (!add_value(&m->varied[i], option, part)) return false;
    return true;
}
