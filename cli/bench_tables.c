/* SPDX-License-Identifier: MIT */
/* What the suites that are a matrix make of its results: tables and sentences. */
#include "bench.h"
#include "json_text.h"
#include "print.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { CASES_MAX = 256, LABELS_MAX = 64 };
#define UNSETTLED 0.1 /* a median whose MAD is a greater part of it */

static const char *string_of(const json_t *object, const char *key) {
    const char *text = json_string_value(json_object_get(object, key));
    return text ? text : "";
}

/* "visibility (culling=triangles,occlusion=on)"; of several kinds of lists, "visibility with tiled lists". */
static void label_of(const json_t *results, const json_t *result, char *text, size_t capacity) {
    const char *lists = string_of(result, "lists"), *options = string_of(result, "options");
    bool several = false;
    const json_t *other;
    size_t i;
    json_array_foreach(results, i, other) several = several || strcmp(string_of(other, "lists"), lists) != 0;
    if (several)
        bench_describe(result, text, capacity);
    else
        snprintf(text, capacity, "%s%s%s%s", string_of(result, "shading"), *options ? " (" : "", options, *options ? ")" : "");
}

/* The names of all ways to render, in the order in which they appear; free() each. */
static uint32_t labels_of(const json_t *results, char *labels[LABELS_MAX]) {
    const json_t *result;
    size_t i;
    uint32_t count = 0;
    json_array_foreach(results, i, result) {
        char label[512];
        label_of(results, result, label, sizeof label);
        bool known = false;
        for (uint32_t k = 0; k < count; k++) known = known || strcmp(labels[k], label) == 0;
        if (!known && count < LABELS_MAX && (labels[count] = strdup(label)) != NULL) count++;
    }
    return count;
}

static uint32_t cases_of(const json_t *results, const json_t *cases[CASES_MAX]) {
    const json_t *result;
    size_t i;
    uint32_t count = 0;
    json_array_foreach(results, i, result) {
        bool known = false;
        for (uint32_t k = 0; k < count; k++) known = known || bench_same_case(cases[k], result);
        if (!known && count < CASES_MAX) cases[count++] = result;
    }
    return count;
}

static const json_t *find_label(const json_t *results, const json_t *where, const char *label) {
    const json_t *result;
    size_t i;
    json_array_foreach(results, i, result) {
        char own[512];
        label_of(results, result, own, sizeof own);
        if (bench_same_case(result, where) && strcmp(own, label) == 0) return result;
    }
    return NULL;
}

static double spread_of(const json_t *result, const char *key) {
    double median = bench_median(result, key);
    return median > 0 ? bench_number(json_object_get(result, key), "mad", 0) / median : 0;
}

static json_t *real_or_null(double value) { return isfinite(value) ? json_real(value) : json_null(); }

static json_t *add_table(json_t *tables, const char *name, const char *title) {
    json_t *table = json_pack("{s:s,s:s,s:[],s:[],s:[]}", "name", name, "title", title, "columns", "rows", "lines");
    json_array_append_new(tables, table);
    return table;
}
static void add_column(json_t *table, const char *name) {
    json_array_append_new(json_object_get(table, "columns"), json_string(name));
}
static void add_line(json_t *table, const char *text) {
    json_array_append_new(json_object_get(table, "lines"), json_text(text));
}

static json_t *row_of_case(const json_t *results, const json_t *where) {
    char size[64], scene[512];
    bench_scene_name(results, string_of(where, "scene"), scene, sizeof scene);
    snprintf(size, sizeof size, "%.0fx%.0f", bench_number(where, "width", 0), bench_number(where, "height", 0));
    return json_pack("[s,s,I]", scene, size, (json_int_t)bench_number(where, "msaa", 1));
}

/* ---- geometry ---- */

/* How a way to render grows from the scene of fewest triangles to that of most, at one size and number of samples. */
static void add_growth(json_t *table, const json_t *results, const json_t *first, const char *label) {
    const json_t *small = NULL, *large = NULL, *result;
    size_t i;
    json_array_foreach(results, i, result) {
        char own[512];
        label_of(results, result, own, sizeof own);
        if (strcmp(own, label) != 0 || !json_equal(json_object_get(result, "width"), json_object_get(first, "width")) ||
            !json_equal(json_object_get(result, "height"), json_object_get(first, "height")) ||
            !json_equal(json_object_get(result, "msaa"), json_object_get(first, "msaa")) ||
            !json_equal(json_object_get(result, "asked_lights"), json_object_get(first, "asked_lights")))
            continue;
        if (!small || bench_number(result, "triangles", 0) < bench_number(small, "triangles", 0)) small = result;
        if (!large || bench_number(result, "triangles", 0) > bench_number(large, "triangles", 0)) large = result;
    }
    if (small != first || small == large) return;
    char text[1024];
    double spread = fmax(spread_of(small, "frame_ms"), spread_of(large, "frame_ms"));
    int used =
        snprintf(text, sizeof text, "%s: %.3g times the triangles, %.3g times those drawn, %.3g times the frame's time",
                 label, bench_number(large, "triangles", 0) / bench_number(small, "triangles", 0),
                 bench_number(large, "triangles_drawn", 0) / fmax(bench_number(small, "triangles_drawn", 0), 1),
                 bench_median(large, "frame_ms") / bench_median(small, "frame_ms"));
    snprintf(text + used, sizeof text - (size_t)used, spread > UNSETTLED ? " (unsettled: times spread by %.0f %%)." : ".",
             100 * spread);
    add_line(table, text);
}

void bench_table_geometry(const struct bench_data *data, json_t *tables) {
    const json_t *results = json_object_get(data->root, "results"), *result;
    json_t *table = add_table(tables, "geometry", "What is left out, and what the rest takes");
    static const char *const names[] = {
        "<scene",    "<size",     "MSAA",  "<drawn by",    "triangles",           "drawn",
        "culled, %", "frame, ms", "+-, %", "geometry, ms", "million triangles/s", "ns/drawn"};
    for (size_t c = 0; c < sizeof names / sizeof *names; c++) add_column(table, names[c]);
    size_t i;
    json_array_foreach(results, i, result) {
        char label[512];
        label_of(results, result, label, sizeof label);
        double total = bench_number(result, "triangles", 0), drawn = bench_number(result, "triangles_drawn", NAN),
               frame = bench_median(result, "frame_ms"), geometry = bench_median(result, "geometry_ms");
        json_t *row = row_of_case(results, result);
        json_array_append_new(row, json_text(label));
        json_array_append_new(row, json_integer((json_int_t)total));
        json_array_append_new(row, isfinite(drawn) ? json_integer((json_int_t)drawn) : json_null());
        json_array_append_new(row, real_or_null(100 * bench_number(result, "triangles_culled_share", NAN)));
        json_array_append_new(row, real_or_null(frame));
        json_array_append_new(row, real_or_null(100 * spread_of(result, "frame_ms")));
        json_array_append_new(row, real_or_null(geometry));
        json_array_append_new(row, real_or_null(bench_number(result, "triangles_per_second", NAN) / 1e6));
        json_array_append_new(row, real_or_null(drawn > 0 ? geometry * 1e6 / drawn : NAN));
        json_array_append_new(json_object_get(table, "rows"), row);
    }
    json_array_foreach(results, i, result) {
        char label[512];
        label_of(results, result, label, sizeof label);
        add_growth(table, results, result, label);
    }
}

/* ---- shading paths over sizes and samples ---- */

/* A statistic of a pass by its name; NaN where it did not run. */
static double pass_number(const json_t *result, const char *name, const char *statistic) {
    const json_t *pass;
    size_t i;
    json_array_foreach(json_object_get(result, "passes"), i, pass) {
        if (strcmp(string_of(pass, "name"), name) == 0) return bench_number(pass, statistic, NAN);
    }
    return NAN;
}

struct wins {
    char text[1024];
    uint32_t clear, close;
};

static void note_win(struct wins *wins, const json_t *results, const json_t *where, bool clear) {
    size_t used = strlen(wins->text);
    char scene[512];
    bench_scene_name(results, string_of(where, "scene"), scene, sizeof scene);
    snprintf(wins->text + used, sizeof wins->text - used, "%s%s %.0fx%.0f %.0fx%s", used ? ", " : "",
             scene, bench_number(where, "width", 0), bench_number(where, "height", 0),
             bench_number(where, "msaa", 1), clear ? "" : " (within the spread)");
    *(clear ? &wins->clear : &wins->close) += 1;
}

static void add_fastest(json_t *table, const json_t *results, const json_t *where, char *const *labels, uint32_t count,
                        struct wins *wins) {
    json_t *row = row_of_case(results, where);
    const json_t *found[LABELS_MAX];
    uint32_t best = LABELS_MAX, second = LABELS_MAX;
    for (uint32_t i = 0; i < count; i++) {
        found[i] = find_label(results, where, labels[i]);
        double time = bench_median(found[i], "frame_ms");
        json_array_append_new(row, real_or_null(time));
        if (!isfinite(time)) continue;
        if (best == LABELS_MAX || time < bench_median(found[best], "frame_ms")) {
            second = best;
            best = i;
        } else if (second == LABELS_MAX || time < bench_median(found[second], "frame_ms")) {
            second = i;
        }
    }
    if (best < count) {
        bool clear = second == LABELS_MAX || bench_clear(found[best], found[second]);
        note_win(&wins[best], results, where, clear);
        json_array_append_new(row, json_text(labels[best]));
        json_array_append_new(row, real_or_null(second == LABELS_MAX ? NAN
                                                                     : bench_median(found[second], "frame_ms") /
                                                                           bench_median(found[best], "frame_ms")));
        json_array_append_new(row, json_string(second == LABELS_MAX ? "" : labels[second]));
        json_array_append_new(row, json_string(clear ? "" : "within the spread"));
    }
    json_array_append_new(json_object_get(table, "rows"), row);
}

/* The bound holds where about four fragments of a pixel pass the depth test. */
static void add_ids(json_t *table, const json_t *results, const json_t *where) {
    const double limit = 0.6;
    const json_t *ids = NULL, *gbuffer = NULL, *result;
    size_t i;
    json_array_foreach(results, i, result) {
        bool plain = bench_same_case(result, where) && !*string_of(result, "options");
        if (plain && !ids && strcmp(string_of(result, "shading"), "visibility") == 0) ids = result;
        if (plain && !gbuffer && strcmp(string_of(result, "shading"), "deferred") == 0) gbuffer = result;
    }
    double a = pass_number(ids, "visibility", "median"), b = pass_number(gbuffer, "gbuffer", "median");
    if (!isfinite(a / b)) return;
    double spread = pass_number(ids, "visibility", "mad") / a + pass_number(gbuffer, "gbuffer", "mad") / b;
    bool bound = strstr(string_of(where, "scene"), "overdraw=1") && bench_number(where, "msaa", 1) == 1;
    json_t *row = row_of_case(results, where);
    json_array_append_new(row, json_real(a));
    json_array_append_new(row, json_real(b));
    json_array_append_new(row, json_real(a / b));
    json_array_append_new(row, bound ? json_real(limit) : json_null());
    json_array_append_new(row, json_string(bound ? bench_verdict(a / b, isfinite(spread) ? spread * a / b : 0, limit, false) : ""));
    json_array_append_new(json_object_get(table, "rows"), row);
}

void bench_table_orders(const struct bench_data *data, json_t *tables) {
    const json_t *results = json_object_get(data->root, "results"), *cases[CASES_MAX];
    char *labels[LABELS_MAX];
    uint32_t case_count = cases_of(results, cases), count = labels_of(results, labels);
    struct wins *wins = calloc(count + 1, sizeof *wins);
    json_t *table = add_table(tables, "orders", "Where each shading path wins: medians of the frame, ms");
    static const char *const head[] = {"<scene", "<size", "MSAA"}, *const tail[] = {"<fastest", "lead", "<over", "<"};
    for (size_t c = 0; c < 3; c++) add_column(table, head[c]);
    for (uint32_t i = 0; i < count; i++) add_column(table, labels[i]);
    for (size_t c = 0; c < 4; c++) add_column(table, tail[c]);
    for (uint32_t i = 0; i < case_count && wins; i++) add_fastest(table, results, cases[i], labels, count, wins);
    for (uint32_t i = 0; i < count && wins; i++) {
        char text[1600];
        if (*wins[i].text)
            snprintf(text, sizeof text, "%s wins %u of %u: %s.", labels[i], wins[i].clear + wins[i].close, case_count,
                     wins[i].text);
        else
            snprintf(text, sizeof text, "%s wins nowhere.", labels[i]);
        add_line(table, text);
    }
    table = add_table(tables, "ids", "Drawing ids against drawing a G-buffer; the bound is for four fragments a pixel");
    static const char *const names[] = {"<scene",       "<size", "MSAA",    "ids, ms",
                                        "G-buffer, ms", "ratio", "at most", "<verdict"};
    for (size_t c = 0; c < sizeof names / sizeof *names; c++) add_column(table, names[c]);
    for (uint32_t i = 0; i < case_count; i++) add_ids(table, results, cases[i]);
    for (uint32_t i = 0; i < count; i++) free(labels[i]);
    free(wins);
}

/* ---- for the terminal ---- */

static void cell_text(const json_t *cell, char *text, size_t capacity) {
    double value = json_number_value(cell);
    if (json_is_string(cell))
        snprintf(text, capacity, "%s", json_string_value(cell));
    else if (json_is_integer(cell))
        snprintf(text, capacity, "%" JSON_INTEGER_FORMAT, json_integer_value(cell));
    else if (json_is_real(cell))
        snprintf(text, capacity, "%.*f", fabs(value) >= 100 ? 1 : fabs(value) >= 1 ? 2 : 3, value);
    else
        snprintf(text, capacity, "-");
}

static void print_table(const json_t *table) {
    const json_t *columns = json_object_get(table, "columns"), *rows = json_object_get(table, "rows"), *row, *line;
    size_t i, count = json_array_size(columns);
    char text[1600];
    printf("\n%s\n", string_of(table, "title"));
    for (int pass = -1; pass < (int)json_array_size(rows); pass++) {
        putchar(' ');
        for (size_t c = 0; c < count; c++) {
            const char *name = json_string_value(json_array_get(columns, c));
            bool left = *name == '<';
            int width = (int)strlen(name + left);
            json_array_foreach(rows, i, row) {
                cell_text(json_array_get(row, c), text, sizeof text);
                if ((int)strlen(text) > width) width = (int)strlen(text);
            }
            if (pass < 0)
                snprintf(text, sizeof text, "%s", name + left);
            else
                cell_text(json_array_get(json_array_get(rows, (size_t)pass), c), text, sizeof text);
            printf(left ? " %-*s " : " %*s ", width, text);
        }
        putchar('\n');
    }
    json_array_foreach(json_object_get(table, "lines"), i, line) printf("%s\n", json_string_value(line));
}

void bench_tables_print(const struct bench_data *data) {
    const json_t *table;
    size_t i;
    json_array_foreach(json_object_get(data->root, "tables"), i, table) { print_table(table); }
}
