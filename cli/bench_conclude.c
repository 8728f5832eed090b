/* SPDX-License-Identifier: MIT */
/* What the numbers say: sentences and tables. */
#include "bench.h"
#include "json_text.h"
#include "print.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool is_unequal(const json_t *result) { return json_is_false(json_object_get(result, "equal")); }

uint32_t bench_unequal_count(const struct bench_data *data) {
    const json_t *result;
    size_t i;
    uint32_t count = 0;
    json_array_foreach(json_object_get(data->root, "results"), i, result) { count += is_unequal(result); }
    return count;
}

uint32_t bench_failed_count(const struct bench_data *data) {
    const json_t *entry;
    size_t i;
    uint32_t count = 0;
    json_array_foreach(json_object_get(data->root, "skipped"), i, entry) { count += json_is_true(json_object_get(entry, "failed")); }
    return count;
}

/* The first result of each case stands for it. */
static bool is_first(const json_t *results, size_t index) {
    const json_t *result = json_array_get(results, index);
    for (size_t i = 0; i < index; i++)
        if (bench_same_case(json_array_get(results, i), result)) return false;
    return true;
}

static int by_time(const void *a, const void *b) {
    double x = bench_median(*(json_t *const *)a, "frame_ms"), y = bench_median(*(json_t *const *)b, "frame_ms");
    return (x > y) - (x < y);
}

/* The results of one case, fastest first; free() them. */
static const json_t **sorted_case(const json_t *results, const json_t *first, size_t *count) {
    const json_t **sorted = malloc((json_array_size(results) + 1) * sizeof *sorted), *result;
    size_t i;
    *count = 0;
    if (!sorted) return NULL;
    json_array_foreach(results, i, result) {
        if (bench_same_case(result, first)) sorted[(*count)++] = result;
    }
    qsort(sorted, *count, sizeof *sorted, by_time);
    return sorted;
}

bool bench_clear(const json_t *fast, const json_t *slow) {
    return bench_number(json_object_get(slow, "frame_ms"), "low", bench_median(slow, "frame_ms")) >
           bench_number(json_object_get(fast, "frame_ms"), "high", bench_median(fast, "frame_ms"));
}

/* Three digits that count, without an exponent. */
static void format_ms(double ms, char *text, size_t capacity) { snprintf(text, capacity, ms >= 100 ? "%.0f ms" : "%.3g ms", ms); }

static bool is_brute(const json_t *result) {
    const char *lists = json_string_value(json_object_get(result, "lists"));
    return lists && strcmp(lists, fnl_value_name(FNL_ENUM_LISTS, FNL_LISTS_ALL)) == 0;
}

/* The answer of a case in words. */
static json_t *conclude_case(const json_t *results, const json_t *first) {
    char place[768], best[256], other[256], ms[32], text[2048];
    size_t count, brute = 1;
    const json_t **sorted = sorted_case(results, first, &count);
    if (!sorted || count == 0) {
        free(sorted);
        return NULL;
    }
    bench_describe_case(results, first, place, sizeof place);
    bench_describe(sorted[0], best, sizeof best);
    double time = bench_median(sorted[0], "frame_ms");
    format_ms(time, ms, sizeof ms);
    size_t used = (size_t)snprintf(text, sizeof text, "On %s, %s %s: %s", place, best, count > 1 ? "was fastest" : "alone was measured", ms);
    if (count > 1) {
        bench_describe(sorted[1], other, sizeof other);
        double ratio = bench_median(sorted[1], "frame_ms") / time;
        bool clear = bench_clear(sorted[0], sorted[1]);
        used += (size_t)snprintf(text + used, sizeof text - used,
                                 clear ? ", %.2f times as fast as %s" : ". Its lead, %.2f times as fast as %s, is within the spread", ratio, other);
        while (brute < count && !is_brute(sorted[brute])) brute++;
        if (brute > 1 && brute < count && !is_brute(sorted[0])) {
            bench_describe(sorted[brute], other, sizeof other);
            used += (size_t)snprintf(text + used, sizeof text - used, clear ? " and %.2f times as fast as %s" : ". It was %.2f times as fast as %s",
                                     bench_median(sorted[brute], "frame_ms") / time, other);
        }
    }
    used += (size_t)snprintf(text + used, sizeof text - used, ".");
    if (json_object_get(sorted[0], "over_ideal"))
        snprintf(text + used, sizeof text - used, " That is %.2f times the ideal: the same frame with perfect lists that cost nothing.",
                 bench_number(sorted[0], "over_ideal", 1));
    free(sorted);
    return json_text(text);
}

/* Why times are not to be trusted; an empty array where they are. */
static json_t *warnings_of(const json_t *root) {
    const json_t *results = json_object_get(root, "results"), *result;
    const uint32_t cores = (uint32_t)bench_number(json_object_get(root, "machine"), "cores", 1);
    json_t *warnings = json_array();
    char text[512];
    double others = 0;
    size_t i, unsteady = 0;
    json_array_foreach(results, i, result) {
        const json_t *times = json_object_get(result, "frame_ms");
        const struct bench_spread spread = {.p5 = bench_number(times, "p5", 0), .p95 = bench_number(times, "p95", 0)};
        unsteady += bench_is_unsteady(&spread);
        others = fmax(others, bench_number(result, "others", 0));
    }
    if (bench_is_busy(others, cores)) {
        snprintf(text, sizeof text, "The machine was busy: other programs used up to %.1f of its %u processors while frames were timed.", others, cores);
        json_array_append_new(warnings, json_text(text));
    }
    if (unsteady) {
        snprintf(text, sizeof text,
                 "In %zu of %zu results the slow frames took more than 1.5 times as long as the fast ones (95th and 5th percentile). Trust a lead only if "
                 "the intervals of both medians do not overlap, or measure again on an idle machine.",
                 unsteady, json_array_size(results));
        json_array_append_new(warnings, json_text(text));
    }
    return warnings;
}

void bench_conclude(struct bench_data *data) {
    json_t *results = json_object_get(data->root, "results"), *lines = json_array(), *result;
    size_t i;
    json_array_foreach(results, i, result) {
        json_t *line = is_first(results, i) ? conclude_case(results, result) : NULL;
        if (line) json_array_append_new(lines, line);
    }
    json_array_foreach(results, i, result) {
        char place[512], what[256], text[1024];
        if (!is_unequal(result)) continue;
        bench_describe_case(results, result, place, sizeof place);
        bench_describe(result, what, sizeof what);
        snprintf(text, sizeof text, "WRONG PICTURE on %s: with %s %.0f pixels differ from the reference, by up to %.4g.",
                 place, what, bench_number(result, "differing_pixels", 0), bench_number(result, "max_difference", 0));
        json_array_append_new(lines, json_text(text));
    }
    json_object_set_new(data->root, "conclusions", lines);
    json_object_set_new(data->root, "warnings", warnings_of(data->root));
}

/* ---- for the terminal ---- */

/* A row for each ideal of a case: the paths and options, whatever their lists. A file that is read again may lack the options. */
static void print_ideals(const json_t **sorted, size_t count, int width) {
    for (size_t i = 0; i < count; i++) {
        const json_t *r = sorted[i];
        const char *options = json_string_value(json_object_get(r, "options"));
        char frame[1024], name[1200];
        bool shown = !json_object_get(r, "ideal_ms");
        for (size_t k = 0; k < i && !shown; k++) shown = bench_same_frame(sorted[k], r);
        if (shown) continue;
        bench_ways_without_lists(options ? options : "", frame, sizeof frame);
        snprintf(name, sizeof name, "%s, ideal%s%s%s", json_string_value(json_object_get(r, "shading")), *frame ? " (" : "", frame, *frame ? ")" : "");
        printf("  %-*s %10.3f\n", width, name, bench_number(r, "ideal_ms", NAN));
    }
}

static void print_case(const json_t *results, const json_t *first) {
    char text[512];
    size_t count;
    const json_t **sorted = sorted_case(results, first, &count);
    int width = 24;
    for (size_t i = 0; sorted && i < count; i++) {
        bench_describe(sorted[i], text, sizeof text);
        if ((int)strlen(text) > width) width = (int)strlen(text);
    }
    bench_describe_case(results, first, text, sizeof text);
    printf("\n%s\n  %-*s %10s %19s %10s %10s %10s %10s %10s  %s\n", text, width, "medians", "frame, ms", "between", "of ideal",
           "lists, ms", "shade, ms", "lights/px", "of least", "picture");
    for (size_t i = 0; sorted && i < count; i++) {
        const json_t *r = sorted[i];
        double useful = bench_number(r, "useful_per_pixel", 0), per_pixel = bench_number(r, "per_pixel", 0);
        const json_t *equal = json_object_get(r, "equal");
        char ratio[32] = "-", ideal[32] = "-";
        if (useful > 0) snprintf(ratio, sizeof ratio, "%.2fx", per_pixel / useful);
        if (json_object_get(r, "over_ideal")) snprintf(ideal, sizeof ideal, "%.2fx", bench_number(r, "over_ideal", 0));
        bench_describe(r, text, sizeof text);
        char between[48];
        snprintf(between, sizeof between, "%.3f..%.3f", bench_number(json_object_get(r, "frame_ms"), "low", NAN),
                 bench_number(json_object_get(r, "frame_ms"), "high", NAN));
        printf("  %-*s %10.3f %19s %10s %10.3f %10.3f %10.2f %10s  %s\n", width, text, bench_median(r, "frame_ms"),
               between, ideal, bench_median(r, "lists_ms"),
               bench_median(r, "shading_ms"), per_pixel, ratio,
               json_is_true(equal)    ? "equal"
               : json_is_false(equal) ? "DIFFERS"
                                      : "not compared");
    }
    if (sorted) print_ideals(sorted, count, width);
    free(sorted);
}

/* One line for each pair, however many cases it is missing from. */
static void print_skipped(const json_t *skipped) {
    const json_t *entry;
    size_t i;
    if (json_array_size(skipped)) puts("\nLeft out:");
    json_array_foreach(skipped, i, entry) {
        char what[256], other[256];
        uint32_t count = 0;
        bool shown = false;
        bench_describe(entry, what, sizeof what);
        for (size_t j = 0; j < json_array_size(skipped); j++) {
            const json_t *against = json_array_get(skipped, j);
            bench_describe(against, other, sizeof other);
            if (strcmp(what, other) != 0 ||
                !json_equal(json_object_get(entry, "reason"), json_object_get(against, "reason")))
                continue;
            shown = shown || j < i;
            count++;
        }
        if (!shown)
            printf("  %s (%u case%s): %s\n", what, count, count == 1 ? "" : "s",
                   json_string_value(json_object_get(entry, "reason")));
    }
}

static void print_suite(const json_t *suite) {
    const json_t *row;
    size_t i;
    if (!suite) return;
    printf("\n%s\n  %-60s %10s %10s %8s  %s\n", json_string_value(json_object_get(suite, "title")), "quantity", "source", "ours", "+-",
           "verdict");
    json_array_foreach(json_object_get(suite, "rows"), i, row) {
        char source[32] = "-", ours[32] = "-", spread[32] = "-";
        double value = bench_number(row, "ours", NAN), theirs = bench_number(row, "source", NAN);
        if (isfinite(theirs))
            snprintf(source, sizeof source, "%s %.3g", json_string_value(json_object_get(row, "comparison")), theirs);
        if (isfinite(value)) {
            snprintf(ours, sizeof ours, "%.3f", value);
            snprintf(spread, sizeof spread, "%.3f", bench_number(row, "spread", 0));
        }
        printf("  %-60s %10s %10s %8s  %s\n", json_string_value(json_object_get(row, "quantity")), source, ours, spread,
               json_string_value(json_object_get(row, "verdict")));
    }
    printf("\n%s\n", json_string_value(json_object_get(suite, "headline")));
    const char *warning = json_string_value(json_object_get(suite, "warning"));
    if (warning) printf("%s\n", warning);
}

void bench_print(const struct bench_data *data) {
    const json_t *results = json_object_get(data->root, "results"), *result, *line;
    const json_t *device = json_object_get(data->root, "device");
    size_t i;
    printf("%s, %s\n", json_string_value(json_object_get(device, "name")),
           json_string_value(json_object_get(device, "driver")));
    json_array_foreach(results, i, result) {
        if (is_first(results, i)) print_case(results, result);
    }
    print_skipped(json_object_get(data->root, "skipped"));
    print_suite(json_object_get(data->root, "suite"));
    fflush(stdout);
    json_array_foreach(json_object_get(data->root, "warnings"), i, line) fprintf(stderr, "fanal: warning: %s\n", json_string_value(line));
    putchar('\n');
    json_array_foreach(json_object_get(data->root, "conclusions"), i, line) printf("%s\n", json_string_value(line));
}
