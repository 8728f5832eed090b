/* SPDX-License-Identifier: MIT */
/* results.json and results.csv, and reading them again. */
#include "bench.h"

#include "json_text.h"
#include "output.h"
#include "print.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- results ---- */

static const char *const case_keys[] = {"scene", "asked_lights", "width", "height", "msaa"};
static const char *const candidate_keys[] = {"shading", "lists", "options"};

json_t *bench_key(const struct bench_case *where, const struct bench_candidate *what) {
    json_t *key = json_pack("{s:o,s:o,s:i,s:i,s:i}", "scene", json_text(where->scene), "asked_lights",
                            where->lights < 0 ? json_null() : json_integer(where->lights), "width", (int)where->width,
                            "height", (int)where->height, "msaa", (int)where->msaa);
    if (key && what) {
        json_object_set_new(key, "shading", json_string(fnl_value_name(FNL_ENUM_SHADING, what->shading)));
        json_object_set_new(key, "lists", json_string(fnl_value_name(FNL_ENUM_LISTS, what->lists)));
        json_object_set_new(key, "options", json_string(what->options));
    }
    return key;
}

static bool same_keys(const json_t *a, const json_t *b) {
    for (size_t i = 0; i < sizeof case_keys / sizeof *case_keys; i++)
        if (!json_equal(json_object_get(a, case_keys[i]), json_object_get(b, case_keys[i]))) return false;
    return true;
}

/* "maps"; "" for none. */
static const char *shadows_of(const json_t *result) {
    const char *kind = json_string_value(json_object_get(json_object_get(result, "settings"), "shadows"));
    return kind ? kind : "";
}

bool bench_same_case(const json_t *a, const json_t *b) { return same_keys(a, b) && strcmp(shadows_of(a), shadows_of(b)) == 0; }

json_t *bench_find(const struct bench_data *data, const struct bench_case *where, const struct bench_candidate *what) {
    json_t *key = bench_key(where, what), *found = NULL, *result;
    size_t i;
    json_array_foreach(json_object_get(data->root, "results"), i, result) {
        bool same = same_keys(result, key);
        for (size_t k = 0; k < sizeof candidate_keys / sizeof *candidate_keys; k++)
            same = same && json_equal(json_object_get(result, candidate_keys[k]), json_object_get(key, candidate_keys[k]));
        if (same) found = result;
    }
    json_decref(key);
    return found;
}

static const char *string_of(const json_t *object, const char *key) {
    const char *text = json_string_value(json_object_get(object, key));
    return text ? text : "";
}

/* "deferred with tiled lists (tiles.size=8)"; or "with brute force". */
static void describe(const char *shading, const char *lists, const char *options, char *text, size_t capacity) {
    bool brute = strcmp(lists, fnl_value_name(FNL_ENUM_LISTS, FNL_LISTS_ALL)) == 0;
    char copy[1024], shown[1024] = "", *rest = copy;
    snprintf(copy, sizeof copy, "%s", options);
    for (char *part; (part = strsep(&rest, ","));) /* shadows belong to the case */
        if (strncmp(part, "shadows=", 8) != 0) snprintf(shown + strlen(shown), sizeof shown - strlen(shown), "%s%s", *shown ? "," : "", part);
    options = shown;
    snprintf(text, capacity, "%s with %s%s%s%s%s", shading, brute ? "brute force" : lists, brute ? "" : " lists", *options ? " (" : "", options,
             *options ? ")" : "");
}

void bench_describe(const json_t *result, char *text, size_t capacity) {
    describe(string_of(result, "shading"), string_of(result, "lists"), string_of(result, "options"), text, capacity);
}

void bench_describe_candidate(const struct bench_candidate *candidate, char *text, size_t capacity) {
    describe(fnl_value_name(FNL_ENUM_SHADING, candidate->shading), fnl_value_name(FNL_ENUM_LISTS, candidate->lists), candidate->options, text, capacity);
}

void bench_describe_case(const json_t *results, const json_t *result, char *text, size_t capacity) {
    char scene[512], lights[32] = "", msaa[32] = "";
    double count = bench_number(result, "lights", bench_number(result, "asked_lights", -1)),
           samples = bench_number(result, "msaa", 1);
    bench_scene_name(results, string_of(result, "scene"), scene, sizeof scene);
    if (count >= 0) snprintf(lights, sizeof lights, " with %.0f light%s", count, count == 1 ? "" : "s");
    if (samples > 1) snprintf(msaa, sizeof msaa, ", MSAA %.0f", samples);
    const char *kind = shadows_of(result);
    char shadows[64] = "";
    bool several = false;
    const json_t *other;
    size_t i;
    json_array_foreach(results, i, other) several = several || *shadows_of(other);
    if (several) snprintf(shadows, sizeof shadows, *kind ? ", shadows by %s" : ", without shadows", kind);
    snprintf(text, capacity, "%s%s at %.0fx%.0f%s%s", scene, lights, bench_number(result, "width", 0), bench_number(result, "height", 0), msaa,
             shadows);
}

/* The last `parts` parts of a path. */
static const char *tail_of(const char *path, int parts) {
    const char *at = path + strlen(path);
    while (at > path && (at[-1] != '/' || --parts > 0)) at--;
    return at;
}

void bench_scene_name(const json_t *results, const char *scene, char *text, size_t capacity) {
    const json_t *other;
    size_t i;
    int parts = 1;
    bool alone = strncmp(scene, "builtin:", 8) == 0;
    const char *tail = alone ? scene : tail_of(scene, parts);
    while (!alone && tail > scene) {
        alone = true;
        json_array_foreach(results, i, other) {
            const char *name = string_of(other, "scene");
            alone = alone && (strcmp(name, scene) == 0 || strcmp(tail_of(name, parts), tail) != 0);
        }
        if (!alone) tail = tail_of(scene, ++parts);
    }
    snprintf(text, capacity, "%s", tail);
}

double bench_number(const json_t *object, const char *key, double otherwise) {
    const json_t *value = json_object_get(object, key);
    return json_is_number(value) ? json_number_value(value) : otherwise;
}

double bench_median(const json_t *result, const char *key) {
    return bench_number(json_object_get(result, key), "median", NAN);
}

/* ---- files ---- */

static bool complain(const char *path) {
    fprintf(stderr, "fanal: error: %s: cannot be written: %s\n", path, strerror(errno));
    return false;
}

static const char *const file_names[] = {"results.json", "results.csv", "report.html"};

bool bench_check_folder(const struct bench_settings *settings) {
    char path[4096];
    for (size_t i = 0; i < sizeof file_names / sizeof *file_names && !settings->resume && !settings->overwrite; i++) {
        if (snprintf(path, sizeof path, "%s/%s", settings->output, file_names[i]) >= (int)sizeof path || access(path, F_OK) != 0) continue;
        fprintf(stderr,
                "fanal: error: %s: there are results already: --resume goes on with them, --overwrite replaces them; or give another -o DIR\n",
                path);
        return false;
    }
    struct stat is;
    snprintf(path, sizeof path, "%s", settings->output);
    for (size_t length = strlen(path); length > 1 && path[length - 1] == '/';) path[--length] = 0;
    return (stat(path, &is) == 0 && S_ISDIR(is.st_mode)) || output_check(path);
}

bool bench_prepare_folder(const char *folder, bool *made) {
    char path[4096];
    struct output probe;
    if (snprintf(path, sizeof path, "%s/results.json", folder) >= (int)sizeof path) {
        fputs("fanal: error: --output: the name of the folder is too long\n", stderr);
        return false;
    }
    *made = mkdir(folder, 0777) == 0;
    if (!*made && errno != EEXIST) return complain(folder);
    if (!output_begin(path, &probe)) return false; /* hours of measuring must not end at a folder that cannot be written to */
    output_abandon(&probe);
    return true;
}

bool bench_save_file(const char *folder, const char *name, const char *text, size_t size) {
    char path[4096];
    return snprintf(path, sizeof path, "%s/%s", folder, name) < (int)sizeof path && output_save(path, text, size);
}

/* ---- CSV, after RFC 4180 ---- */

struct text {
    char *bytes;
    size_t length, capacity;
    bool failed;
};

static void append(struct text *t, const char *bytes, size_t length) {
    if (t->length + length + 1 > t->capacity) {
        size_t capacity = 2 * t->capacity + length + 4096;
        char *bigger = realloc(t->bytes, capacity);
        if (!bigger) {
            t->failed = true;
            return;
        }
        t->bytes = bigger;
        t->capacity = capacity;
    }
    memcpy(t->bytes + t->length, bytes, length);
    t->length += length;
}

static void append_field(struct text *t, const json_t *value) {
    char number[64] = "";
    char *copy = json_is_string(value) ? strdup(json_string_value(value)) : NULL;
    const char *text = copy ? copy : number;
    if (json_is_string(value)) {
        if (copy) fnl_text_clean(copy);
        else t->failed = true;
    } else if (json_is_integer(value))
        snprintf(number, sizeof number, "%" JSON_INTEGER_FORMAT, json_integer_value(value));
    else if (json_is_real(value))
        snprintf(number, sizeof number, "%.9g", json_real_value(value));
    else if (json_is_boolean(value))
        text = json_is_true(value) ? "true" : "false";
    bool quote = strpbrk(text, ",\"\r\n") != NULL;
    if (quote) append(t, "\"", 1);
    for (; *text; text++) {
        if (*text == '"') append(t, "\"", 1);
        append(t, text, 1);
    }
    if (quote) append(t, "\"", 1);
    free(copy);
}

/* A column is a key, or "times.statistic". */
/* clang-format off */
static const char *const columns[] = {
    "scene", "width", "height", "msaa", "shading", "lists", "lights", "lights_in_view", "frames",
    "frame_ms.median", "frame_ms.low", "frame_ms.high", "frame_ms.min", "frame_ms.p5", "frame_ms.p95", "frame_ms.mad",
    "gpu_ms.median", "gpu_ms.min", "gpu_ms.p5", "gpu_ms.p95", "gpu_ms.mad",
    "cpu_ms.median", "cpu_ms.min", "cpu_ms.p5", "cpu_ms.p95", "cpu_ms.mad",
    "wall_ms.median", "lists_ms.median", "lists_ms.mad", "shading_ms.median", "shading_ms.mad", "shadows_ms.median", "geometry_ms.median", "rest_ms.median",
    "without_lists_ms.median", "ideal_ms", "over_ideal",
    "evaluations", "evaluations_useful", "per_pixel", "useful_per_pixel", "max_per_pixel",
    "list_bytes", "list_used_bytes", "list_entries", "cells", "overflow_cells", "dropped", "triangles", "triangles_drawn", "triangles_culled_share", "triangles_per_second",
    "image_bytes_read", "image_bytes_written",
    "equal", "differing_pixels", "max_difference"};
/* clang-format on */

/* The options that some result sets: a column each. An array of keys, in the order in which they appear. */
static json_t *setting_columns(const json_t *root) {
    json_t *keys = json_array(), *seen = json_object();
    const json_t *result, *value;
    const char *key;
    size_t i;
    json_array_foreach(json_object_get(root, "results"), i, result) {
        json_object_foreach(json_object_get(result, "settings"), key, value) {
            if (json_object_get(seen, key)) continue;
            json_object_set_new(seen, key, json_true());
            json_array_append_new(keys, json_string(key));
        }
    }
    json_decref(seen);
    return keys;
}

/* The counters that some result has: a column each, in the order of the library. */
static json_t *counter_columns(const json_t *root) {
    json_t *keys = json_array();
    const json_t *result;
    fnl_counter c;
    size_t k;
    for (uint32_t i = 0; fnl_counter_query(i, &c); i++) {
        bool has = false;
        json_array_foreach(json_object_get(root, "results"), k, result) {
            has = has || json_object_get(json_object_get(result, "counters"), c.key);
        }
        if (has) json_array_append_new(keys, json_string(c.key));
    }
    return keys;
}

/* What a result sets, or the default. */
static void append_setting(struct text *t, const json_t *result, const char *key) {
    const fnl_frame usual = bench_frame();
    const json_t *value = json_object_get(json_object_get(result, "settings"), key);
    char text[64] = "";
    if (!value) fnl_frame_get(&usual, key, text, sizeof text);
    append(t, ",", 1);
    if (value) append_field(t, value);
    else append(t, text, strlen(text));
}

static bool save_csv(const char *folder, const json_t *root) {
    enum { COUNT = sizeof columns / sizeof *columns };
    struct text t = {0};
    json_t *settings = setting_columns(root), *counters = counter_columns(root), *key;
    const json_t *result;
    size_t i, k;
    for (int c = 0; c < COUNT; c++) {
        char name[64];
        snprintf(name, sizeof name, "%s", columns[c]);
        for (char *dot = strchr(name, '.'); dot; dot = NULL) *dot = '_';
        if (c) append(&t, ",", 1);
        append(&t, name, strlen(name));
        if (strcmp(name, "lists") != 0) continue;
        json_array_foreach(settings, k, key) {
            append(&t, ",", 1);
            append_field(&t, key);
        }
    }
    json_array_foreach(counters, k, key) {
        append(&t, ",", 1);
        append_field(&t, key);
    }
    append(&t, "\r\n", 2);
    json_array_foreach(json_object_get(root, "results"), i, result) {
        for (int c = 0; c < COUNT; c++) {
            char name[64];
            snprintf(name, sizeof name, "%s", columns[c]);
            char *statistic = strchr(name, '.');
            if (statistic) *statistic++ = 0;
            const json_t *value = json_object_get(result, name);
            if (c) append(&t, ",", 1);
            append_field(&t, statistic ? json_object_get(value, statistic) : value);
            if (strcmp(name, "lists") == 0) json_array_foreach(settings, k, key) append_setting(&t, result, json_string_value(key));
        }
        json_array_foreach(counters, k, key) {
            append(&t, ",", 1);
            append_field(&t, json_object_get(json_object_get(result, "counters"), json_string_value(key)));
        }
        append(&t, "\r\n", 2);
    }
    bool good = !t.failed && bench_save_file(folder, "results.csv", t.bytes, t.length);
    json_decref(settings);
    json_decref(counters);
    free(t.bytes);
    return good;
}

static bool save_json(const char *folder, const json_t *root) {
    char *text = json_text_write(root, JSON_INDENT(1) | JSON_REAL_PRECISION(9));
    bool good = text && bench_save_file(folder, "results.json", text, strlen(text));
    free(text);
    return good;
}

static bool save_page(const char *folder, const struct bench_data *data) {
    size_t size;
    char *text = bench_page_create(data, &size);
    bool good = text && bench_save_file(folder, "report.html", text, size);
    free(text);
    return good;
}

bool bench_save(const char *folder, const struct bench_data *data, bool page) {
    return save_json(folder, data->root) && save_csv(folder, data->root) && (!page || save_page(folder, data));
}

void bench_drop_page(const char *folder) {
    char path[4096];
    if (snprintf(path, sizeof path, "%s/report.html", folder) < (int)sizeof path) unlink(path);
}

/* ---- reading again ---- */

/* NULL with errno 0 when there is no such file, else with a reason. */
static char *read_file(const char *folder, const char *name) {
    char path[4096];
    struct stat status = {0};
    errno = ENAMETOOLONG;
    if (snprintf(path, sizeof path, "%s/%s", folder, name) >= (int)sizeof path) return NULL;
    int descriptor = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    FILE *file = descriptor >= 0 ? fdopen(descriptor, "rb") : NULL;
    if (!file) {
        if (errno == ENOENT) errno = 0;
        return NULL;
    }
    bool regular = fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
    char *text = regular ? malloc((size_t)status.st_size + 1) : NULL;
    size_t got = text ? fread(text, 1, (size_t)status.st_size, file) : 0;
    if (text) text[got] = 0;
    fclose(file);
    if (!text) errno = regular ? ENOMEM : EINVAL;
    return text;
}

/* The page holds the pictures in an element of their own; without a page the new one goes without the old pictures. */
static json_t *load_pictures(const char *folder) {
    static const char start[] = "<script type=\"application/json\" id=\"pictures\">";
    char *page = read_file(folder, "report.html"), *from = page ? strstr(page, start) : NULL;
    json_t *pictures = NULL;
    if (from) {
        from += sizeof start - 1;
        char *end = strstr(from, "</script>");
        if (end) pictures = json_loadb(from, (size_t)(end - from), 0, NULL);
    }
    free(page);
    return pictures;
}

bool bench_load(const char *folder, struct bench_data *data) {
    char *text = read_file(folder, "results.json");
    json_error_t error = {0};
    *data = (struct bench_data){0};
    if (!text && errno) {
        fprintf(stderr, "fanal: error: %s/results.json: cannot be read: %s\n", folder, strerror(errno));
        return false;
    }
    if (!text) return true;
    data->root = json_loads(text, 0, &error);
    free(text);
    const json_t *results = json_object_get(data->root, "results"), *result;
    bool good = json_is_array(results);
    size_t i;
    json_array_foreach(results, i, result) {
        good = good && *string_of(result, "scene") && *string_of(result, "lists") && *string_of(result, "shading");
    }
    if (!good) {
        fprintf(stderr, "fanal: error: %s/results.json: these are no results of fanal bench%s%s\n", folder,
                *error.text ? ": " : "", error.text);
        return false;
    }
    json_t *pictures = load_pictures(folder);
    data->pictures = pictures ? bench_pictures_renamed(results, pictures, true) : NULL;
    json_decref(pictures);
    return true;
}
