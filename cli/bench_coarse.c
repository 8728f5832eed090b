/* SPDX-License-Identifier: MIT */
/* Coarse shading against the full rate, as shading becomes dearer: what it saves, what its G-buffer costs, what is left of the picture. */
#include "bench_lane.h"
#include "counters.h"
#include "json_text.h"
#include "print.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The publication has the Power Plant (large smooth surfaces) and Sponza, 1024 lights, and loops of 0, 100 and 500 turns. */
static const struct coarse_scene {
    const char *source;
    uint32_t lights;   /* scattered */
    double savings[3]; /* per cent, of the publication's scene of the same sort */
} scenes[] = {
    {"builtin:interior?lights=96", 928, {50.7, 58.1, 60.2}},
    {"builtin:hall?lights=1024", 0, {24.9, 34.3, 36.5}},
};
static const uint32_t costs[] = {0, 100, 500};
/* The settings of the publication; and looser ones, with what their base colours lose kept for each pixel. */
static const struct coarse_way {
    const char *name;
    uint32_t size;
    float normal_degrees;
    fnl_coarse_split split;
} ways[] = {{"2x2, 2 degrees", 2, 2, FNL_COARSE_SPLIT_NONE},
            {"2x2, 8 degrees, albedo", 2, 8, FNL_COARSE_SPLIT_ALBEDO},
            {"4x4, 8 degrees, albedo", 4, 8, FNL_COARSE_SPLIT_ALBEDO}};
enum {
    SCENE_COUNT = sizeof scenes / sizeof *scenes,
    COST_COUNT = sizeof costs / sizeof *costs,
    WAY_COUNT = sizeof ways / sizeof *ways,
    SUBJECT_COUNT = 1 + WAY_COUNT /* the first is the full rate */
};

struct coarse_subject {
    fnl_frame frame;
    fnl_image picture;
    fnl_frame_stats stats;
    double shared, shaded;     /* parts of its blocks, and of its pixels */
    double *shading, *gbuffer; /* milliseconds of the passes */
    uint32_t count;
};

/* Of all passes whose names begin so. */
static double pass_time(const fnl_frame_stats *stats, const char *start) {
    double sum = 0;
    for (uint32_t i = 0; i < stats->pass_count; i++)
        if (strncmp(stats->passes[i].name, start, strlen(start)) == 0) sum += stats->passes[i].milliseconds;
    return sum;
}

static double part_of(const fnl_frame_stats *stats, const char *part, const char *whole) {
    return (double)counters_value(stats, part) / fmax((double)counters_value(stats, whole), 1);
}

static double least_of(const double *values, uint32_t count) {
    double least = INFINITY;
    for (uint32_t i = 0; i < count; i++) least = fmin(least, values[i]);
    return least;
}

static bool prepare(fnl_renderer *renderer, const fnl_scene *scene, uint32_t width, uint32_t height,
                    struct coarse_subject subjects[SUBJECT_COUNT]) {
    fnl_frame frame;
    if (!bench_metered_frame(renderer, scene, width, height, &frame)) return false;
    frame.lists = FNL_LISTS_TILED; /* as in the publication: tiles of 16x16 pixels with a range of depths */
    for (int i = 0; i < SUBJECT_COUNT; i++) {
        subjects[i].frame = frame;
        if (i == 0) continue;
        const struct coarse_way *way = &ways[i - 1];
        fnl_coarse_options *o = &subjects[i].frame.coarse;
        subjects[i].frame.shading = FNL_SHADING_COARSE;
        o->size = way->size;
        o->normal_degrees = way->normal_degrees;
        o->split = way->split;
    }
    return true;
}

/* All ways in turn, so that what else the machine does falls on all. */
static bool measure(fnl_renderer *renderer, const struct bench_settings *settings, uint32_t cost,
                    struct coarse_subject subjects[SUBJECT_COUNT]) {
    for (int i = 0; i < SUBJECT_COUNT; i++) subjects[i].count = 0;
    for (uint32_t k = 0; k < settings->warm_up + settings->frames; k++)
        for (int i = 0; i < SUBJECT_COUNT; i++) {
            struct coarse_subject *s = &subjects[i];
            s->frame.shade_cost = cost;
            if (interrupt_seen() || fnl_renderer_render(renderer, &s->frame) != FNL_OK ||
                fnl_renderer_query_stats(renderer, &s->stats) != FNL_OK)
                return false;
            if (!s->picture.pixels && fnl_renderer_read(renderer, FNL_OUTPUT_COLOR, &s->picture) != FNL_OK) return false;
            if (k < settings->warm_up) continue;
            s->gbuffer[s->count] = pass_time(&s->stats, "gbuffer");
            s->shading[s->count++] = pass_time(&s->stats, i ? "coarse" : "deferred");
            s->shared = part_of(&s->stats, "coarse.shared", "coarse.blocks");
            s->shaded = part_of(&s->stats, "coarse.shaded", "coarse.pixels");
        }
    return true;
}

static bool add_rows(json_t *rows, const struct coarse_scene *scene, int cost,
                     const struct coarse_subject subjects[SUBJECT_COUNT]) {
    double pixel = least_of(subjects[0].shading, subjects[0].count),
           gbuffer = least_of(subjects[0].gbuffer, subjects[0].count);
    for (int i = 1; i < SUBJECT_COUNT; i++) {
        const struct coarse_subject *s = &subjects[i];
        fnl_image_difference difference;
        if (fnl_image_compare(NULL, &s->picture, &subjects[0].picture, &difference) != FNL_OK) return false;
        double coarse = least_of(s->shading, s->count), more = least_of(s->gbuffer, s->count) - gbuffer;
        json_t *row = json_pack("{s:o,s:s,s:i,s:f,s:f,s:f,s:f,s:f,s:f,s:f,s:f,s:f}", "scene", json_text(scene->source), "way",
                                ways[i - 1].name, "cost", (int)costs[cost], "pixel_ms", pixel, "coarse_ms", coarse, "saving",
                                100 * (1 - coarse / pixel), "source_saving", scene->savings[cost], "shared", 100 * s->shared,
                                "evaluations_saved", 100 * (1 - s->shaded), "gbuffer_ms", more, "net",
                                100 * (1 - (coarse + more) / pixel), "psnr", fmin(difference.psnr, 999));
        if (!row || json_array_append_new(rows, row)) return false;
    }
    return true;
}

static bool run_scene(fnl_device *device, const struct coarse_scene *from, uint32_t width, uint32_t height,
                      const struct bench_settings *settings, json_t *rows) {
    fnl_scene *scene = NULL;
    fnl_renderer *renderer = NULL;
    struct coarse_subject subjects[SUBJECT_COUNT] = {0};
    bool good = fnl_scene_load(NULL, from->source, NULL, &scene) == FNL_OK &&
                fnl_scene_scatter_lights(scene, from->lights, 1) == FNL_OK &&
                fnl_renderer_create(device, scene, &renderer) == FNL_OK && prepare(renderer, scene, width, height, subjects);
    for (int i = 0; i < SUBJECT_COUNT && good; i++) {
        subjects[i].shading = calloc(settings->frames + 1, sizeof(double));
        subjects[i].gbuffer = calloc(settings->frames + 1, sizeof(double));
        good = subjects[i].shading && subjects[i].gbuffer;
    }
    for (int cost = 0; cost < COST_COUNT && good; cost++)
        good = measure(renderer, settings, costs[cost], subjects) && add_rows(rows, from, cost, subjects);
    for (int i = 0; i < SUBJECT_COUNT; i++) {
        fnl_image_free(NULL, &subjects[i].picture);
        free(subjects[i].shading);
        free(subjects[i].gbuffer);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
    return good;
}

bool bench_coarse_measure(const struct bench_settings *settings, uint32_t width, uint32_t height, struct bench_data *data) {
    fnl_device *device = NULL;
    json_t *rows = json_array();
    bool good = bench_create_device(settings, NULL, &device);
    for (int i = 0; i < SCENE_COUNT && good; i++) {
        if (!settings->quiet) fprintf(stderr, "scene %d of %d: %s\n", i + 1, SCENE_COUNT, scenes[i].source);
        good = run_scene(device, &scenes[i], width ? width : 1920, height ? height : 1080, settings, rows);
    }
    if (good && settings->validate && fnl_device_validation_count(device)) {
        fputs("fanal: error: Vulkan validation sent messages\n", stderr);
        good = false;
    }
    fnl_device_destroy(&device);
    json_object_set_new(data->root, "coarse", rows);
    return good;
}

void bench_coarse_print(const struct bench_data *data) {
    const json_t *rows = json_object_get(data->root, "coarse"), *row;
    const char *scene = "";
    size_t i;
    json_array_foreach(rows, i, row) {
        const char *name = json_string_value(json_object_get(row, "scene"));
        if (strcmp(scene, name) != 0)
            printf("\n%s\n  %-24s %5s %9s %10s %9s %8s %9s %11s %12s %7s %9s\n", name, "way", "turns", "pixel, ms",
                   "coarse, ms", "saving, %", "source", "blocks, %", "lit less, %", "G-buffer, ms", "net, %", "PSNR, dB");
        scene = name;
        printf("  %-24s %5.0f %9.2f %10.2f %9.1f %8.1f %9.1f %11.1f %+12.2f %7.1f %9.2f\n",
               json_string_value(json_object_get(row, "way")), bench_number(row, "cost", 0),
               bench_number(row, "pixel_ms", 0), bench_number(row, "coarse_ms", 0), bench_number(row, "saving", 0),
               bench_number(row, "source_saving", 0), bench_number(row, "shared", 0),
               bench_number(row, "evaluations_saved", 0), bench_number(row, "gbuffer_ms", 0), bench_number(row, "net", 0),
               bench_number(row, "psnr", 0));
    }
}
