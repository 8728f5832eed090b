/* SPDX-License-Identifier: MIT */
/* The ideal frame: what a frame would take if its lists cost nothing to build and named only lights that reach the surface. */
#include "bench.h"

#include <math.h>
#include <string.h>

/* Evaluations over those that reach the surface, up to which lists count as perfect: fine-pruned ones reach 1.00 to 1.02. */
#define PERFECT 1.05

static const char *string_of(const json_t *object, const char *key) {
    const char *text = json_string_value(json_object_get(object, key));
    return text ? text : "";
}

bool bench_same_frame(const json_t *a, const json_t *b) {
    char frame_a[1024], frame_b[1024];
    if (!bench_same_case(a, b) || strcmp(string_of(a, "shading"), string_of(b, "shading")) != 0) return false;
    if (strcmp(string_of(a, "options"), string_of(b, "options")) == 0) return true;
    bench_ways_without_lists(string_of(a, "options"), frame_a, sizeof frame_a);
    bench_ways_without_lists(string_of(b, "options"), frame_b, sizeof frame_b);
    return strcmp(frame_a, frame_b) == 0;
}

static bool is_perfect(const json_t *result) {
    double evaluations = bench_number(result, "evaluations", NAN), useful = bench_number(result, "evaluations_useful", NAN);
    return evaluations <= PERFECT * useful;
}

/*
 * Shading is fastest with perfect lists as a rule, but not always: walking them has a price too. So the least of all candidates counts, provided
 * that one of them had perfect lists.
 */
static double ideal_of(const json_t *results, const json_t *of) {
    const json_t *result;
    size_t i;
    bool perfect = false;
    double least = NAN;
    json_array_foreach(results, i, result) {
        if (!bench_same_frame(result, of)) continue;
        perfect = perfect || is_perfect(result);
        least = fmin(least, bench_median(result, "without_lists_ms"));
    }
    return perfect ? least : NAN;
}

void bench_add_ideals(struct bench_data *data) {
    json_t *results = json_object_get(data->root, "results"), *result;
    size_t i;
    json_array_foreach(results, i, result) {
        double ideal = ideal_of(results, result);
        json_object_del(result, "ideal_ms");
        json_object_del(result, "over_ideal");
        if (!(ideal > 0)) continue;
        json_object_set_new(result, "ideal_ms", json_real(ideal));
        json_object_set_new(result, "over_ideal", json_real(bench_median(result, "frame_ms") / ideal));
    }
}
