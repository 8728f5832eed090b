/* SPDX-License-Identifier: MIT */
#include "bench_lane.h"

#include "counters.h"
#include "json_text.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static const char *const metric_names[LANE_METRIC_COUNT] = {"frame_ms", "gpu_ms",     "cpu_ms",      "wall_ms",
                                                            "lists_ms", "shading_ms", "shadows_ms", "geometry_ms",
                                                            "rest_ms",  "without_lists_ms"};

double lane_now(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + (double)now.tv_nsec * 1e-9;
}

/* ---- life ---- */

bool lane_init(struct lane *lane, const struct bench_case *where, const struct bench_candidate *candidate, uint32_t frames) {
    *lane = (struct lane){.candidate = candidate, .frame = bench_frame(), .capacity = frames};
    lane->frame.width = where->width;
    lane->frame.height = where->height;
    lane->frame.msaa = where->msaa;
    lane->frame.shading = candidate->shading;
    lane->frame.lists = candidate->lists;
    /* Metering would take tone mapping out of its scope. */
    if (candidate->shading == FNL_SHADING_MOBILE) lane->frame.exposure = FNL_EXPOSURE_NONE;
    bool good = bench_ways_apply("set", candidate->options, &lane->frame);
    for (int m = 0; m < LANE_METRIC_COUNT; m++) {
        lane->times[m] = calloc(frames, sizeof(double));
        good = good && lane->times[m];
    }
    return good;
}

void lane_finish(struct lane *lane) {
    fnl_renderer_destroy(&lane->own);
    for (int m = 0; m < LANE_METRIC_COUNT; m++) free(lane->times[m]);
    for (uint32_t i = 0; i < lane->pass_count; i++) {
        free(lane->passes[i].name);
        free(lane->passes[i].times);
    }
    free(lane->passes);
    json_decref(lane->counters);
    *lane = (struct lane){0};
}

/* ---- frames ---- */

/* The pass of this name; most often the one at the same place as in the frame before. */
static struct lane_pass *find_pass(struct lane *lane, const char *name, uint32_t place) {
    if (place < lane->pass_count && strcmp(lane->passes[place].name, name) == 0) return &lane->passes[place];
    for (uint32_t i = 0; i < lane->pass_count; i++)
        if (strcmp(lane->passes[i].name, name) == 0) return &lane->passes[i];
    struct lane_pass *bigger = realloc(lane->passes, (lane->pass_count + 1) * sizeof *bigger);
    if (!bigger) return NULL;
    lane->passes = bigger;
    struct lane_pass *pass = &bigger[lane->pass_count];
    *pass = (struct lane_pass){.name = strdup(name), .times = calloc(lane->capacity, sizeof(double))};
    if (pass->name && pass->times) {
        lane->pass_count++;
        return pass;
    }
    free(pass->name);
    free(pass->times);
    return NULL;
}

bool lane_note_times(struct lane *lane, const fnl_frame_stats *stats) {
    lane->image_bytes_read = stats->image_bytes_read; /* of frames as they are timed: those that are counted keep more */
    lane->image_bytes_written = stats->image_bytes_written;
    double sums[FNL_PASS_ROLE_COUNT] = {0};
    for (uint32_t i = 0; i < stats->pass_count; i++) {
        struct lane_pass *pass = find_pass(lane, stats->passes[i].name, i);
        if (!pass) return false;
        pass->times[lane->measured] += stats->passes[i].milliseconds;
        pass->role = stats->passes[i].role;
        sums[pass->role] += stats->passes[i].milliseconds;
    }
    double gpu = 0;
    for (int role = 0; role < FNL_PASS_ROLE_COUNT; role++) gpu += role == FNL_PASS_READ ? 0 : sums[role];
    double values[LANE_METRIC_COUNT] = {[LANE_FRAME] = fmax(gpu, stats->cpu_milliseconds),
                                        [LANE_GPU] = gpu,
                                        [LANE_CPU] = stats->cpu_milliseconds,
                                        [LANE_WALL] = lane->wall,
                                        [LANE_LISTS] = sums[FNL_PASS_LISTS],
                                        [LANE_SHADING] = sums[FNL_PASS_SHADING],
                                        [LANE_SHADOWS] = sums[FNL_PASS_SHADOWS],
                                        [LANE_GEOMETRY] = sums[FNL_PASS_GEOMETRY],
                                        [LANE_REST] = sums[FNL_PASS_REST],
                                        [LANE_WITHOUT_LISTS] = gpu - sums[FNL_PASS_LISTS]};
    for (int m = 0; m < LANE_METRIC_COUNT; m++) lane->times[m][lane->measured] = values[m];
    lane->measured++;
    return true;
}

void lane_note_counts(struct lane *lane, const fnl_frame_stats *stats) {
    lane->stats = *stats;
    lane->stats.passes = NULL;
    lane->stats.counters = NULL;
    lane->stats.counter_count = 0;
    json_decref(lane->counters);
    lane->counters = counters_json(stats);
    lane->counted++;
    lane->evaluations += (double)stats->evaluations;
    lane->useful += (double)stats->evaluations_useful;
    if (stats->max_per_pixel > lane->max_per_pixel) lane->max_per_pixel = stats->max_per_pixel;
}

/* ---- results ---- */

static double rounded(double milliseconds) { return round(milliseconds * 1e6) / 1e6; } /* to the nanosecond */

/* Median, spread; MAD is the median of the distances from the median. */
static json_t *summarise(const double *times, uint32_t count) {
    struct bench_spread s;
    if (!bench_spread_of(times, count, &s)) return NULL;
    return json_pack("{s:f,s:f,s:f,s:f,s:f,s:f,s:f}", "median", rounded(s.median), "low", rounded(s.low), "high", rounded(s.high), "min",
                     rounded(s.min), "p5", rounded(s.p5), "p95", rounded(s.p95), "mad", rounded(s.mad));
}

static void set_integer(json_t *object, const char *key, uint64_t value) {
    json_object_set_new(object, key, json_integer((json_int_t)value));
}

static void add_counts(const struct lane *lane, json_t *result) {
    const fnl_frame_stats *s = &lane->stats;
    double pixels = (double)lane->frame.width * lane->frame.height, frames = lane->counted;
    set_integer(result, "lights", s->lights_total);
    set_integer(result, "lights_in_view", s->lights_in_view);
    set_integer(result, "evaluations", (uint64_t)(lane->evaluations / frames + 0.5));
    set_integer(result, "evaluations_useful", (uint64_t)(lane->useful / frames + 0.5));
    json_object_set_new(result, "per_pixel", json_real(lane->evaluations / frames / pixels));
    json_object_set_new(result, "useful_per_pixel", json_real(lane->useful / frames / pixels));
    set_integer(result, "max_per_pixel", lane->max_per_pixel);
    set_integer(result, "list_bytes", s->list_bytes);
    set_integer(result, "list_used_bytes", s->list_used_bytes);
    set_integer(result, "list_entries", s->list_entries);
    set_integer(result, "cells", s->cells);
    set_integer(result, "overflow_cells", s->overflow_cells);
    set_integer(result, "dropped", s->lights_dropped);
    /* Of opaque surfaces and cutouts of all instances: those drawn, and how fast the scene went by. */
    uint64_t drawn = lane->frame.culling == FNL_CULLING_INSTANCES ? s->triangles_visible : s->triangles_drawn;
    double total = fmax((double)s->triangles_total, 1);
    set_integer(result, "triangles_total", s->triangles_total);
    set_integer(result, "triangles_drawn", drawn);
    json_object_set_new(result, "triangles_culled_share", json_real(1 - (double)drawn / total));
    json_object_set(result, "counters", lane->counters);
    set_integer(result, "image_bytes_read", lane->image_bytes_read);
    set_integer(result, "image_bytes_written", lane->image_bytes_written);
}

static void add_comparison(const struct lane *lane, json_t *result) {
    if (lane->checked == 0) {
        json_object_set_new(result, "equal", json_null());
        json_object_set_new(result, "unchecked", json_text(lane->unchecked));
        return;
    }
    json_object_del(result, "unchecked");
    json_object_set_new(result, "equal", json_boolean(lane->differing == 0));
    set_integer(result, "pictures_compared", lane->checked);
    set_integer(result, "differing_pixels", lane->differing);
    /* JSON knows no infinity */
    json_object_set_new(result, "max_difference", json_real(fmin(lane->max_difference, 3.4e38)));
}

/* ---- times of single frames, to go on from ---- */

static json_t *numbers_of(const double *values, uint32_t count) {
    json_t *array = json_array();
    for (uint32_t i = 0; i < count; i++) json_array_append_new(array, json_real(rounded(values[i])));
    return array;
}

static json_t *samples_of(const struct lane *lane) {
    json_t *samples = json_object(), *passes = json_object();
    for (int m = 0; m < LANE_METRIC_COUNT; m++) json_object_set_new(samples, metric_names[m], numbers_of(lane->times[m], lane->measured));
    for (uint32_t i = 0; i < lane->pass_count; i++)
        json_object_set_new(passes, lane->passes[i].name, numbers_of(lane->passes[i].times, lane->measured));
    json_object_set_new(samples, "passes", passes);
    return samples;
}

static bool read_numbers(const json_t *array, double *values, size_t count) {
    if (json_array_size(array) != count) return false;
    for (size_t i = 0; i < count; i++) values[i] = json_number_value(json_array_get(array, i));
    return true;
}

void lane_restore(struct lane *lane, const json_t *result, uint32_t checks) {
    const json_t *samples = json_object_get(result, "samples"), *pass;
    size_t count = json_array_size(json_object_get(samples, metric_names[LANE_FRAME]));
    const char *name;
    bool good = count > 0 && count < lane->capacity;
    for (int m = 0; m < LANE_METRIC_COUNT && good; m++) good = read_numbers(json_object_get(samples, metric_names[m]), lane->times[m], count);
    json_object_foreach(json_object_get(samples, "passes"), name, pass) {
        struct lane_pass *own = good ? find_pass(lane, name, lane->pass_count) : NULL;
        good = own && read_numbers(pass, own->times, count);
    }
    for (uint32_t i = 0; i < lane->pass_count && !good; i++) memset(lane->passes[i].times, 0, lane->capacity * sizeof(double));
    if (!good) return;
    lane->measured = (uint32_t)count;
    lane->wall = lane->times[LANE_WALL][count - 1];
    lane->image_bytes_read = (uint64_t)bench_number(result, "image_bytes_read", 0);
    lane->image_bytes_written = (uint64_t)bench_number(result, "image_bytes_written", 0);
    bool unchecked = json_is_string(json_object_get(result, "unchecked"));
    lane->kept = unchecked || bench_number(result, "pictures_compared", 0) >= checks;
}

void lane_add_result(const struct lane *lane, json_t *result, const fnl_scene_info *scene, bool shared,
                     uint32_t wanted_frames) {
    set_integer(result, "triangles", scene->triangle_count);
    set_integer(result, "instances", scene->instance_count);
    bench_ways_describe(lane->candidate, result);
    if (lane->counted) add_counts(lane, result);
    if (!lane->kept) add_comparison(lane, result);
    set_integer(result, "frames", lane->measured);
    json_object_set_new(result, "complete", json_boolean(lane->measured >= wanted_frames));
    json_object_del(result, "samples");
    if (lane->measured < wanted_frames) json_object_set_new(result, "samples", samples_of(lane));
    json_object_set_new(result, "shared_renderer", json_boolean(shared));
    for (int m = 0; m < LANE_METRIC_COUNT; m++)
        json_object_set_new(result, metric_names[m], summarise(lane->times[m], lane->measured));
    double median = json_real_value(json_object_get(json_object_get(result, metric_names[LANE_FRAME]), "median"));
    if (median > 0)
        json_object_set_new(result, "triangles_per_second", json_real(1000 / median * bench_number(result, "triangles_total", 0)));
    json_t *passes = json_array();
    for (uint32_t i = 0; i < lane->pass_count; i++) {
        json_t *pass = summarise(lane->passes[i].times, lane->measured);
        json_object_set_new(pass, "name", json_string(lane->passes[i].name));
        json_object_set_new(pass, "role", json_string(fnl_value_name(FNL_ENUM_PASS_ROLE, (uint32_t)lane->passes[i].role)));
        json_array_append_new(passes, pass);
    }
    json_object_set_new(result, "passes", passes);
}

void lane_picture_name(const json_t *key, const char *kind, char *text, size_t capacity) {
    const json_t *lights = json_object_get(key, "asked_lights");
    snprintf(text, capacity, "%s|%lld|%lldx%lld|%lld|%s|%s|%s|%s", json_string_value(json_object_get(key, "scene")),
             json_is_integer(lights) ? (long long)json_integer_value(lights) : -1LL,
             (long long)json_integer_value(json_object_get(key, "width")),
             (long long)json_integer_value(json_object_get(key, "height")),
             (long long)json_integer_value(json_object_get(key, "msaa")), json_string_value(json_object_get(key, "shading")),
             json_string_value(json_object_get(key, "lists")), json_string_value(json_object_get(key, "options")), kind);
}
