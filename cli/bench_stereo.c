/* SPDX-License-Identifier: MIT */
/*
 * Stereo: what two eyes cost over one, and what the savings of the literature save here. Each figure is the ratio of two ways
 * to render the same pair of pictures within one run.
 */
#include "bench.h"
#include "json_text.h"
#include "stereo.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char source_scene[] = "builtin:city?lights=64";
static const float MONO_DISTANCE = 10; /* meters, as in the source */

enum { ONE_EYE, EYE_AFTER_EYE, DISPLAY, MONO, WAYS };
static const char *const way_names[WAYS] = {"one eye", "eye after eye", "both eyes of a display", "mono beyond 10 m"};

struct way {
    fnl_renderer *renderer;
    fnl_frame frame;
    fnl_camera cameras[HEADSET_EYES];
    double *times; /* ms of the GPU */
    uint32_t count;
};

static const struct row {
    const char *quantity, *source;
    int over, under;
    bool at_least;
    double limit;
} rows[] = {
    {"eye after eye / one eye", "below 2", EYE_AFTER_EYE, ONE_EYE, false, 2},
    {"both eyes of a display / eye after eye", "", DISPLAY, EYE_AFTER_EYE, false, 1},
    {"mono beyond 10 m / both eyes of a display", "0.75", MONO, DISPLAY, false, 0.75},
    {"both eyes of a display / one eye: most that a second device can give", "1.30 to 1.35", DISPLAY, ONE_EYE, true, 1.3},
};

static bool open_way(fnl_device *device, fnl_scene *scene, const struct stereo *stereo, const fnl_frame *frame, int number, uint32_t frames, struct way *way) {
    way->frame = *frame;
    way->frame.occlusion = FNL_OCCLUSION_OFF; /* mono cannot use it, so none does */
    way->times = calloc(frames, sizeof *way->times);
    if (!way->times || fnl_renderer_create(device, scene, &way->renderer) != FNL_OK) return false;
    if (!stereo_cameras(stereo, &frame->camera, 0, frame->width, frame->height, way->cameras)) return false;
    way->frame.camera = way->cameras[0];
    if (number == ONE_EYE) return true;
    way->frame.views = way->cameras;
    way->frame.view_count = HEADSET_EYES;
    way->frame.stereo.eyes = number == EYE_AFTER_EYE ? 0 : HEADSET_EYES;
    way->frame.stereo.mono_distance = number == MONO ? MONO_DISTANCE : 0;
    return true;
}

/* Each way draws a frame in turn, so that what else the machine does strikes all alike. */
static bool measure(struct way *ways, const struct bench_settings *settings) {
    fnl_frame_stats stats;
    for (uint32_t i = 0; i < settings->warm_up + settings->frames && !interrupt_seen(); i++)
        for (int k = 0; k < WAYS; k++) {
            struct way *way = &ways[k];
            if (fnl_renderer_render(way->renderer, &way->frame) != FNL_OK || fnl_renderer_query_stats(way->renderer, &stats) != FNL_OK) return false;
            if (i >= settings->warm_up) way->times[way->count++] = stats.gpu_milliseconds;
        }
    return !interrupt_seen();
}

static bool add_results(struct way *ways, struct bench_data *data) {
    json_t *found = json_array();
    for (int k = 0; k < WAYS; k++) {
        struct bench_spread spread;
        if (!bench_spread_of(ways[k].times, ways[k].count, &spread)) return false;
        json_array_append_new(found, json_pack("{s:s,s:s,s:i,s:i,s:f,s:f,s:i}", "scene", source_scene, "way", way_names[k], "width", (int)ways[k].frame.width,
                                               "height", (int)ways[k].frame.height, "gpu_ms", spread.median, "mad", spread.mad, "frames", (int)ways[k].count));
    }
    json_object_set_new(data->root, "stereo", found);
    return true;
}

bool bench_stereo_measure(const struct bench_settings *settings, uint32_t width, uint32_t height, struct bench_data *data) {
    const struct stereo_options options = {.kind = STEREO_LAYERS, .ipd = NAN};
    fnl_device *device = NULL;
    fnl_device_info info = {0};
    fnl_scene *scene = NULL;
    fnl_renderer *renderer = NULL;
    struct stereo stereo;
    struct way ways[WAYS] = {{0}};
    fnl_frame frame;
    if (!stereo_open(&options, settings->quiet, &stereo)) return false;
    bool good = bench_create_device(settings, NULL, &device) && fnl_device_query_info(device, &info) == FNL_OK;
    const bool cpu = info.type == FNL_DEVICE_CPU;
    if (width == 0) {
        width = cpu ? 320 : 1440;
        height = cpu ? 180 : 1600;
    }
    good = good && fnl_scene_load(NULL, source_scene, NULL, &scene) == FNL_OK && fnl_renderer_create(device, scene, &renderer) == FNL_OK &&
           bench_metered_frame(renderer, scene, width, height, &frame);
    for (int k = 0; k < WAYS && good; k++) good = open_way(device, scene, &stereo, &frame, k, settings->frames, &ways[k]);
    good = good && measure(ways, settings) && add_results(ways, data);
    if (good && settings->validate && fnl_device_validation_count(device)) {
        fputs("fanal: error: Vulkan validation sent messages\n", stderr);
        good = false;
    }
    for (int k = 0; k < WAYS; k++) {
        fnl_renderer_destroy(&ways[k].renderer);
        free(ways[k].times);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
    fnl_device_destroy(&device);
    stereo_close(&stereo);
    return good;
}

void bench_table_stereo(const struct bench_data *data, json_t *tables) {
    const json_t *found = json_object_get(data->root, "stereo");
    json_t *table = json_pack("{s:s,s:s,s:[s,s,s,s,s],s:[],s:[s,s]}", "name", "stereo", "title", "Two eyes of the city with 64 lights: times on the GPU", "columns",
                              "<quantity", "<source", "ours", "+-", "<verdict", "rows", "lines",
                              "Sources: Quilez, Efficient Stereo and VR Rendering; Real-Time Rendering, 4th edition, chapter 21.",
                              "A second device draws the other eye meanwhile. The ratio leaves out copying its picture, so it is a bound.");
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const json_t *over = json_array_get(found, (size_t)rows[i].over), *under = json_array_get(found, (size_t)rows[i].under);
        const double a = bench_number(over, "gpu_ms", NAN), b = bench_number(under, "gpu_ms", NAN), ratio = a / b;
        const double spread = ratio * (bench_number(over, "mad", 0) / a + bench_number(under, "mad", 0) / b);
        if (!isfinite(ratio)) continue;
        json_array_append_new(json_object_get(table, "rows"), json_pack("[s,s,f,f,s]", rows[i].quantity, rows[i].source, ratio, spread,
                                                                        bench_verdict(ratio, spread, rows[i].limit, rows[i].at_least)));
    }
    json_array_append_new(tables, table);
}
