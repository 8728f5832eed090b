/* SPDX-License-Identifier: MIT */
/* Antialiasing against supersampling: how far each method's picture is from the mean of 64 frames, and what it costs. */
#include "bench_lane.h"
#include "json_text.h"
#include "print.h"
#include "supersample.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SAMPLES = 64, COLLECTED = 16 };

static const char *const scenes[] = {"builtin:pole", "builtin:hall?lights=256", "builtin:grass"};
enum { SCENE_COUNT = sizeof scenes / sizeof *scenes };

static const struct method {
    const char *name;
    int base; /* the method without antialiasing that it is compared with */
    fnl_shading shading;
    uint32_t msaa, frames; /* frames: until its picture is looked at */
    fnl_antialiasing aa;
    fnl_msaa_method msaa_method;
} methods[] = {
    {"none", 0, FNL_SHADING_DEFERRED, 1, 1, FNL_ANTIALIASING_NONE, FNL_MSAA_COMPACT},
    {"mlaa", 0, FNL_SHADING_DEFERRED, 1, 1, FNL_ANTIALIASING_MLAA, FNL_MSAA_COMPACT},
    {"smaa", 0, FNL_SHADING_DEFERRED, 1, 1, FNL_ANTIALIASING_SMAA, FNL_MSAA_COMPACT},
    {"taa, 16 frames", 0, FNL_SHADING_DEFERRED, 1, COLLECTED, FNL_ANTIALIASING_TAA, FNL_MSAA_COMPACT},
    {"MSAA 4, compact", 0, FNL_SHADING_DEFERRED, 4, 1, FNL_ANTIALIASING_NONE, FNL_MSAA_COMPACT},
    {"MSAA 4, coverage", 0, FNL_SHADING_DEFERRED, 4, 1, FNL_ANTIALIASING_NONE, FNL_MSAA_COVERAGE},
    {"MSAA 4, aggregate", 0, FNL_SHADING_DEFERRED, 4, 1, FNL_ANTIALIASING_NONE, FNL_MSAA_AGGREGATE},
    {"none, forward", 7, FNL_SHADING_FORWARD_PREPASS, 1, 1, FNL_ANTIALIASING_NONE, FNL_MSAA_COMPACT},
    {"MSAA 4, forward", 7, FNL_SHADING_FORWARD_PREPASS, 4, 1, FNL_ANTIALIASING_NONE, FNL_MSAA_COMPACT},
};
enum { METHOD_COUNT = sizeof methods / sizeof *methods };

struct subject {
    fnl_renderer *renderer;
    fnl_frame frame;
    fnl_image picture;
    double *times, *own; /* of whole frames, and of the passes of antialiasing alone, milliseconds */
    uint32_t count;
    bool failed;
};

static double frame_time(const fnl_frame_stats *stats) {
    double gpu = 0;
    for (uint32_t i = 0; i < stats->pass_count; i++)
        if (strncmp(stats->passes[i].name, "read ", 5) != 0) gpu += stats->passes[i].milliseconds;
    return fmax(gpu, stats->cpu_milliseconds);
}

static double own_time(const fnl_frame_stats *stats) {
    static const char *const names[] = {"mlaa", "smaa", "taa", "motion"};
    double sum = 0;
    for (uint32_t i = 0; i < stats->pass_count; i++)
        for (int n = 0; n < 4; n++)
            if (strncmp(stats->passes[i].name, names[n], strlen(names[n])) == 0) sum += stats->passes[i].milliseconds;
    return sum;
}

double bench_median_of(double *values, uint32_t count) {
    for (uint32_t i = 1; i < count; i++)
        for (uint32_t j = i; j > 0 && values[j - 1] > values[j]; j--) {
            double v = values[j];
            values[j] = values[j - 1];
            values[j - 1] = v;
        }
    return count ? 0.5 * (values[(count - 1) / 2] + values[count / 2]) : NAN;
}

static bool render(struct subject *s, fnl_frame_stats *stats) {
    s->failed = s->failed || fnl_renderer_render(s->renderer, &s->frame) != FNL_OK ||
                fnl_renderer_query_stats(s->renderer, stats) != FNL_OK;
    return !s->failed;
}

bool bench_metered_frame(fnl_renderer *renderer, const fnl_scene *scene, uint32_t width, uint32_t height, fnl_frame *out) {
    fnl_frame_stats stats;
    *out = bench_frame();
    out->width = width;
    out->height = height;
    out->lists = FNL_LISTS_CLUSTERED;
    if ((fnl_scene_count(scene, FNL_ENTITY_CAMERA)
             ? fnl_scene_query_camera(scene, 0, &out->camera)
             : fnl_scene_query_framing_camera(scene, (float)width / (float)height, &out->camera)) != FNL_OK ||
        fnl_renderer_render(renderer, out) != FNL_OK || fnl_renderer_query_stats(renderer, &stats) != FNL_OK)
        return false;
    out->exposure = FNL_EXPOSURE_EV;
    out->ev = stats.ev;
    return true;
}

static void measure(struct subject *subjects, const struct bench_settings *settings) {
    fnl_frame_stats stats;
    for (int m = 0; m < METHOD_COUNT; m++) {
        struct subject *s = &subjects[m];
        for (uint32_t i = 0; i < methods[m].frames && render(s, &stats); i++) {
        }
        if (s->failed || fnl_renderer_read(s->renderer, FNL_OUTPUT_COLOR, &s->picture) != FNL_OK) s->failed = true;
    }
    for (uint32_t i = 0; i < settings->warm_up + settings->frames && !interrupt_seen(); i++)
        for (int m = 0; m < METHOD_COUNT; m++)
            if (render(&subjects[m], &stats) && i >= settings->warm_up) {
                subjects[m].own[subjects[m].count] = own_time(&stats);
                subjects[m].times[subjects[m].count++] = frame_time(&stats);
            }
}

static void add_rows(json_t *rows, const char *scene, struct subject *subjects, const fnl_image *reference) {
    double times[METHOD_COUNT];
    fnl_image_difference errors[METHOD_COUNT] = {{0}};
    for (int m = 0; m < METHOD_COUNT; m++) {
        struct subject *s = &subjects[m];
        times[m] = bench_median_of(s->times, s->count);
        if (!s->failed) s->failed = fnl_image_compare(NULL, &s->picture, reference, &errors[m]) != FNL_OK;
    }
    for (int m = 0; m < METHOD_COUNT; m++) {
        const struct subject *base = &subjects[methods[m].base];
        if (subjects[m].failed || base->failed) continue;
        double removed = (errors[methods[m].base].mean - errors[m].mean) * 255;
        /* A pass that comes on top is timed by itself; samples are in every pass, so whole frames are compared. */
        double cost = methods[m].msaa == methods[methods[m].base].msaa ? bench_median_of(subjects[m].own, subjects[m].count)
                                                                       : times[m] - times[methods[m].base];
        json_t *row = json_pack("{s:o,s:s,s:f,s:f,s:f,s:f,s:f}", "scene", json_text(scene), "method", methods[m].name, "frame_ms",
                                times[m], "extra_ms", cost, "mean_error", errors[m].mean * 255, "psnr",
                                fmin(errors[m].psnr, 999), "ssim", errors[m].ssim);
        json_object_set_new(row, "removed_per_ms",
                            methods[m].base == m || !(cost > 0) ? json_null() : json_real(removed / cost));
        json_array_append_new(rows, row);
    }
}

static bool run_scene(fnl_device *device, const char *source, uint32_t width, uint32_t height,
                      const struct bench_settings *settings, json_t *rows) {
    fnl_scene *scene = NULL;
    fnl_renderer *renderer = NULL;
    struct subject subjects[METHOD_COUNT] = {{0}};
    struct supersample mean = {0};
    fnl_image reference = {0};
    fnl_frame frame;
    bool good = fnl_scene_load(NULL, source, NULL, &scene) == FNL_OK &&
                fnl_renderer_create(device, scene, &renderer) == FNL_OK &&
                bench_metered_frame(renderer, scene, width, height, &frame) &&
                supersample_render(&mean, renderer, &frame, SAMPLES) &&
                fnl_renderer_read(renderer, FNL_OUTPUT_COLOR, &reference) == FNL_OK;
    if (good) supersample_store(&mean, &reference);
    for (int m = 0; m < METHOD_COUNT && good; m++) {
        struct subject *s = &subjects[m];
        s->frame = frame;
        s->frame.shading = methods[m].shading;
        s->frame.msaa = methods[m].msaa;
        s->frame.aa = methods[m].aa;
        s->frame.deferred.msaa_method = methods[m].msaa_method;
        s->times = calloc(settings->frames + 1, sizeof *s->times);
        s->own = calloc(settings->frames + 1, sizeof *s->own);
        good = s->times && s->own && fnl_renderer_create(device, scene, &s->renderer) == FNL_OK;
    }
    if (good) {
        measure(subjects, settings);
        if (!interrupt_seen()) add_rows(rows, source, subjects, &reference);
    }
    for (int m = 0; m < METHOD_COUNT; m++) {
        fnl_image_free(NULL, &subjects[m].picture);
        free(subjects[m].times);
        free(subjects[m].own);
        fnl_renderer_destroy(&subjects[m].renderer);
    }
    fnl_image_free(NULL, &reference);
    supersample_free(&mean);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
    return good;
}

bool bench_aa_measure(const struct bench_settings *settings, uint32_t width, uint32_t height, struct bench_data *data) {
    fnl_device *device = NULL;
    json_t *rows = json_array();
    bool good = bench_create_device(settings, NULL, &device);
    for (int i = 0; i < SCENE_COUNT && good && !interrupt_seen(); i++) {
        if (!settings->quiet) fprintf(stderr, "scene %d of %d: %s\n", i + 1, SCENE_COUNT, scenes[i]);
        good = run_scene(device, scenes[i], width ? width : 640, height ? height : 360, settings, rows);
    }
    if (good && settings->validate && fnl_device_validation_count(device)) {
        fputs("fanal: error: Vulkan validation sent messages\n", stderr);
        good = false;
    }
    fnl_device_destroy(&device);
    json_object_set_new(data->root, "antialiasing", rows);
    return good;
}

void bench_aa_print(const struct bench_data *data) {
    const json_t *rows = json_object_get(data->root, "antialiasing"), *row;
    const char *scene = "";
    size_t i;
    json_array_foreach(rows, i, row) {
        const char *name = json_string_value(json_object_get(row, "scene"));
        if (strcmp(scene, name) != 0)
            printf("\n%s, against %d samples a pixel\n  %-28s %10s %10s %12s %9s %8s %14s\n", name, SAMPLES, "method",
                   "frame, ms", "extra, ms", "error, /255", "PSNR, dB", "SSIM", "removed per ms");
        scene = name;
        char per_ms[32] = "-";
        if (json_is_real(json_object_get(row, "removed_per_ms")))
            snprintf(per_ms, sizeof per_ms, "%.3g", bench_number(row, "removed_per_ms", 0));
        printf("  %-28s %10.3f %10.3f %12.3f %9.2f %8.4f %14s\n", json_string_value(json_object_get(row, "method")),
               bench_number(row, "frame_ms", 0), bench_number(row, "extra_ms", 0), bench_number(row, "mean_error", 0),
               bench_number(row, "psnr", 0), bench_number(row, "ssim", 0), per_ms);
    }
}
