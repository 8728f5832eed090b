/* SPDX-License-Identifier: MIT */
/* Deferred attribute interpolation against a G-buffer, pass by pass, as triangles get smaller: where one overtakes the other. */
#include "bench_lane.h"
#include "counters.h"
#include "json_text.h"
#include "progress.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/*
 * The publication has Sponza, San Miguel, and Sponza tessellated more and more: here the hall stands for a scene as scenes are, and spheres of ever
 * smaller triangles say where the orders cross, which is what the suite is for.
 */
static const struct dais_scene {
    const char *source;
    const char *series; /* scenes with one name differ by the size of their triangles alone, which becomes smaller; "": none */
    uint32_t divisor;   /* not 0: the source ends with a number, the width divided by this */
} scenes[] = {{"builtin:hall?lights=64", "", 0},
              {"builtin:spheres?lights=4&segments=", "spheres", 80},
              {"builtin:spheres?lights=4&segments=", "spheres", 27},
              {"builtin:spheres?lights=4&segments=", "spheres", 9},
              {"builtin:spheres?lights=4&segments=", "spheres", 3}};
static const uint32_t sample_counts[] = {1, 4};

enum subject { TARGET, DEFERRED, DEFERRED_PREPASS, LIST, MULTIRATE, SUBJECT_COUNT, CROSSING_COUNT = LIST /* the first three say where they cross */ };
enum part { PREPASS, VISIBILITY, DERIVATIVES, SHARED, SHADE, PART_COUNT };
enum { SCENE_COUNT = sizeof scenes / sizeof *scenes, SAMPLE_COUNTS = sizeof sample_counts / sizeof *sample_counts, GROWTH_MOST = 16 };
static const char *const part_names[PART_COUNT] = {"prepass", "visibility", "derivatives", "shared", "shade"};

/* Parts of a frame of dais by the start of a pass's name, the first that fits. */
static const struct {
    const char *start;
    enum part part;
} passes[] = {{"depth prepass", PREPASS},      {"dais clear", VISIBILITY},  {"dais visibility", VISIBILITY}, {"dais arguments", DERIVATIVES},
              {"dais derivatives", DERIVATIVES}, {"dais shared", SHARED}, {"dais ", SHADE}};

/* A scene with one number of samples. */
struct dais_part {
    const char *source;
    int index, count, subject_count;
};

struct dais_subject {
    fnl_frame frame;
    fnl_frame_stats stats;
    uint64_t triangles, bytes;         /* stored; of all that is kept, or of the G-buffer */
    double *parts[PART_COUNT], *total; /* milliseconds */
    uint32_t count;
};

static void note(struct dais_subject *s) {
    double parts[PART_COUNT] = {0}, total = 0;
    for (uint32_t i = 0; i < s->stats.pass_count; i++) {
        const char *name = s->stats.passes[i].name;
        total += s->stats.passes[i].milliseconds;
        for (size_t k = 0; k < sizeof passes / sizeof *passes; k++) {
            if (strncmp(name, passes[k].start, strlen(passes[k].start)) != 0) continue;
            parts[passes[k].part] += s->stats.passes[i].milliseconds;
            break;
        }
    }
    for (int p = 0; p < PART_COUNT; p++) s->parts[p][s->count] = parts[p];
    s->total[s->count++] = total;
}

static bool render(fnl_renderer *renderer, struct dais_subject *s) {
    if (fnl_renderer_render(renderer, &s->frame) != FNL_OK || fnl_renderer_query_stats(renderer, &s->stats) != FNL_OK)
        return false;
    s->triangles = counters_value(&s->stats, "dais.triangles");
    s->bytes = counters_value(&s->stats, s->frame.shading == FNL_SHADING_DAIS ? "dais.bytes" : "gbuffer.bytes");
    return true;
}

/* All in turn, so that what else the machine does falls on all; not before the pools have grown. */
static bool measure(fnl_renderer *renderer, const struct bench_settings *settings, const struct dais_part *part,
                    struct dais_subject subjects[SUBJECT_COUNT]) {
    uint32_t rounds = settings->warm_up + settings->frames;
    for (uint32_t k = 0; k < rounds; k++)
        for (int i = 0; i < part->subject_count; i++) {
            int turns = 0;
            if (k == 0) subjects[i].count = 0;
            do {
                if (interrupt_seen() || !render(renderer, &subjects[i])) return false;
            } while (k == 0 && counters_overflow(&subjects[i].stats) && ++turns < GROWTH_MOST);
            double done = (part->index + (double)(k + 1) / rounds) / part->count;
            progress_tell(progress_seconds() * (1 - done) / done, "part %d of %d: %s, MSAA %u, frame %u of %u", part->index + 1,
                                part->count, part->source, subjects[i].frame.msaa, k + 1, rounds);
            if (k >= settings->warm_up) note(&subjects[i]);
        }
    return true;
}

static void prepare(const fnl_frame *frame, struct dais_subject subjects[SUBJECT_COUNT]) {
    for (int i = 0; i < SUBJECT_COUNT; i++) {
        fnl_frame *f = &subjects[i].frame;
        *f = *frame;
        f->shading = i == DEFERRED || i == DEFERRED_PREPASS ? FNL_SHADING_DEFERRED : FNL_SHADING_DAIS;
        f->gbuffer.prepass = i == DEFERRED_PREPASS;
        f->dais.mode = i == LIST ? FNL_DAIS_LIST : FNL_DAIS_TARGET;
        f->dais.multirate = i == MULTIRATE;
    }
}

static bool add_row(json_t *rows, const char *source, const char *series, const struct dais_part *part,
                    struct dais_subject subjects[SUBJECT_COUNT]) {
    const fnl_frame *frame = &subjects[TARGET].frame;
    const struct dais_subject *target = &subjects[TARGET];
    double samples = (double)frame->width * frame->height * frame->msaa, triangles = fmax((double)target->triangles, 1);
    double totals[SUBJECT_COUNT];
    for (int i = 0; i < part->subject_count; i++) totals[i] = bench_median_of(subjects[i].total, subjects[i].count);
    /* The cache is as large for any picture: bytes are compared without it. What a stored triangle takes says at how many samples to one
       they are even. */
    double cache = 16.0 * frame->dais.cache_buckets, record = ((double)target->bytes - cache - 4 * samples) / triangles;
    double gbuffer = (double)subjects[DEFERRED].bytes;
    json_t *row =
        json_pack("{s:o,s:s,s:i,s:i,s:i,s:I,s:f,s:f,s:f,s:f,s:f,s:f,s:f}", "scene", json_text(source), "series", series, "width",
                  (int)frame->width, "height", (int)frame->height, "msaa", (int)frame->msaa, "triangles",
                  (json_int_t)target->triangles, "samples_per_triangle", samples / triangles, "record_bytes", record,
                  "bytes_even_at", record / (gbuffer / samples - 4), "bytes_of_deferred",
                  ((double)target->bytes - cache) / gbuffer, "frame_ms", totals[TARGET], "of_deferred",
                  totals[TARGET] / totals[DEFERRED], "of_deferred_prepass", totals[TARGET] / totals[DEFERRED_PREPASS]);
    bool every = row && part->subject_count == SUBJECT_COUNT;
    if (every) {
        json_object_set_new(row, "list_of_target", json_real(totals[LIST] / totals[TARGET]));
        json_object_set_new(row, "multirate_of_target", json_real(totals[MULTIRATE] / totals[TARGET]));
    }
    /* The time of shared samples is the multirate frame's, all others are of the plain one. */
    for (int p = 0; row && p < PART_COUNT; p++) {
        if (p == SHARED && !every) continue;
        struct dais_subject *from = &subjects[p == SHARED ? MULTIRATE : TARGET];
        char key[32];
        snprintf(key, sizeof key, "%s_ms", part_names[p]);
        json_object_set_new(row, key, json_real(bench_median_of(from->parts[p], from->count)));
    }
    return row && json_array_append_new(rows, row) == 0;
}

static bool run_scene(fnl_device *device, int index, const uint32_t size[2], const struct bench_settings *settings, json_t *rows) {
    const struct dais_scene *from = &scenes[index];
    fnl_scene *scene = NULL;
    fnl_renderer *renderer = NULL;
    struct dais_subject subjects[SUBJECT_COUNT] = {0};
    fnl_device_info info;
    char source[64];
    fnl_frame frame;
    uint32_t number = from->divisor ? size[0] / from->divisor : 0;
    if (from->divisor)
        snprintf(source, sizeof source, "%s%u", from->source, number < 4 ? 4 : number > 1024 ? 1024 : number);
    else
        snprintf(source, sizeof source, "%s", from->source);
    bool good = fnl_device_query_info(device, &info) == FNL_OK && fnl_scene_load(NULL, source, NULL, &scene) == FNL_OK &&
                fnl_renderer_create(device, scene, &renderer) == FNL_OK &&
                bench_metered_frame(renderer, scene, size[0], size[1], &frame);
    for (int i = 0; i < SUBJECT_COUNT && good; i++) {
        subjects[i].total = calloc(settings->frames + 1, sizeof(double));
        good = subjects[i].total;
        for (int p = 0; p < PART_COUNT && good; p++) {
            subjects[i].parts[p] = calloc(settings->frames + 1, sizeof(double));
            good = subjects[i].parts[p];
        }
    }
    for (int s = 0; s < SAMPLE_COUNTS && good; s++) {
        struct dais_part part = {source, index * SAMPLE_COUNTS + s, SCENE_COUNT * SAMPLE_COUNTS, *from->series ? CROSSING_COUNT : SUBJECT_COUNT};
        if (!(info.msaa_counts & sample_counts[s])) continue;
        frame.msaa = sample_counts[s];
        prepare(&frame, subjects);
        good = measure(renderer, settings, &part, subjects) && add_row(rows, source, from->series, &part, subjects);
    }
    for (int i = 0; i < SUBJECT_COUNT; i++) {
        free(subjects[i].total);
        for (int p = 0; p < PART_COUNT; p++) free(subjects[i].parts[p]);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
    return good;
}

bool bench_dais_measure(const struct bench_settings *settings, uint32_t width, uint32_t height, struct bench_data *data) {
    fnl_device *device = NULL;
    fnl_device_info info = {0};
    json_t *rows = json_array();
    bool good = bench_create_device(settings, NULL, &device) && fnl_device_query_info(device, &info) == FNL_OK;
    uint32_t size[2] = {info.type == FNL_DEVICE_CPU ? 640 : 3840, info.type == FNL_DEVICE_CPU ? 360 : 2160};
    if (width) memcpy(size, (uint32_t[2]){width, height}, sizeof size);
    progress_begin(settings->quiet, PROGRESS_SECONDS);
    for (int i = 0; i < SCENE_COUNT && good; i++) good = run_scene(device, i, size, settings, rows);
    progress_end();
    if (good && settings->validate && fnl_device_validation_count(device)) {
        fputs("fanal: error: Vulkan validation sent messages\n", stderr);
        good = false;
    }
    fnl_device_destroy(&device);
    json_object_set_new(data->root, "dais", rows);
    return good;
}

/* ---- crossings ---- */

static bool one_line(const json_t *a, const json_t *b) {
    return strcmp(json_string_value(json_object_get(a, "series")), json_string_value(json_object_get(b, "series"))) == 0 &&
           bench_number(a, "width", 0) == bench_number(b, "width", 0) && bench_number(a, "msaa", 0) == bench_number(b, "msaa", 0);
}

double bench_dais_crossing(const json_t *rows, const json_t *first, const char *ratio) {
    const json_t *row, *last = NULL;
    double at = NAN;
    size_t i;
    json_array_foreach(rows, i, row) {
        if (!one_line(row, first)) continue;
        double y = log(bench_number(row, ratio, NAN)), x = log(bench_number(row, "samples_per_triangle", NAN));
        if (last) {
            double y0 = log(bench_number(last, ratio, NAN)), x0 = log(bench_number(last, "samples_per_triangle", NAN));
            if ((y0 < 0) != (y < 0)) at = exp(x0 + (x - x0) * y0 / (y0 - y));
        }
        last = row;
    }
    return at;
}

/* ---- the table ---- */

static size_t describe_crossing(const json_t *rows, const json_t *first, const char *what, const char *ratio, char *text, size_t capacity) {
    double at = bench_dais_crossing(rows, first, ratio);
    int length = isfinite(at) ? snprintf(text, capacity, "; %s even at %.3g samples a triangle", what, at)
                              : snprintf(text, capacity, "; %s: %s ahead throughout", what,
                                         bench_number(first, ratio, NAN) < 1 ? "dais" : "deferred");
    return (size_t)length;
}

static void add_crossings(json_t *lines, const json_t *rows) {
    const json_t *row;
    size_t i;
    json_array_foreach(rows, i, row) {
        const char *series = json_string_value(json_object_get(row, "series"));
        bool seen = !*series;
        char text[512];
        for (size_t k = 0; k < i && !seen; k++) seen = one_line(json_array_get(rows, k), row);
        if (seen) continue;
        size_t used = (size_t)snprintf(text, sizeof text, "%s, %.0fx%.0f, %.0f samples", series, bench_number(row, "width", 0),
                                       bench_number(row, "height", 0), bench_number(row, "msaa", 0));
        used += describe_crossing(rows, row, "time", "of_deferred", text + used, sizeof text - used);
        used += describe_crossing(rows, row, "time, both with a depth prepass", "of_deferred_prepass", text + used, sizeof text - used);
        used += describe_crossing(rows, row, "bytes", "bytes_of_deferred", text + used, sizeof text - used);
        snprintf(text + used, sizeof text - used, ".");
        json_array_append_new(lines, json_text(text));
    }
}

void bench_table_dais(const struct bench_data *data, json_t *tables) {
    static const struct {
        const char *name, *key; /* a key of a row */
    } columns[] = {{"MSAA", "msaa"},
                   {"triangles", "triangles"},
                   {"samples of each", "samples_per_triangle"},
                   {"prepass, ms", "prepass_ms"},
                   {"visibility, ms", "visibility_ms"},
                   {"derivatives, ms", "derivatives_ms"},
                   {"shared, ms", "shared_ms"},
                   {"shade, ms", "shade_ms"},
                   {"/ deferred", "of_deferred"},
                   {"with prepass", "of_deferred_prepass"},
                   {"list / target", "list_of_target"},
                   {"multirate / target", "multirate_of_target"},
                   {"bytes / deferred", "bytes_of_deferred"},
                   {"even at", "bytes_even_at"}};
    const json_t *rows = json_object_get(data->root, "dais"), *row;
    json_t *names = json_pack("[s,s]", "<scene", "<size"), *cells = json_array(), *lines = json_array();
    size_t i, count = sizeof columns / sizeof *columns;
    for (size_t c = 0; c < count; c++) json_array_append_new(names, json_string(columns[c].name));
    json_array_foreach(rows, i, row) {
        char size[64];
        snprintf(size, sizeof size, "%.0fx%.0f", bench_number(row, "width", 0), bench_number(row, "height", 0));
        json_t *line = json_pack("[O,s]", json_object_get(row, "scene"), size);
        for (size_t c = 0; c < count; c++) {
            json_t *value = json_object_get(row, columns[c].key);
            json_array_append_new(line, value ? json_incref(value) : json_null());
        }
        json_array_append_new(cells, line);
    }
    add_crossings(lines, rows);
    json_array_append_new(tables, json_pack("{s:s,s:s,s:o,s:o,s:o}", "name", "dais", "title",
                                            "Passes of attribute interpolation, and its frames and bytes against those of deferred shading",
                                            "columns", names, "rows", cells, "lines", lines));
}
