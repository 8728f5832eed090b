/* SPDX-License-Identifier: MIT */
/* Every kind of shadows, as lights become more: what it costs over no shadows, while the camera stands still and while it moves; its memory and
 * pages; and how much light is on the wrong side of a shadow. With many lights, what leaves shadows to chance in several ways too: which of them comes
 * nearest to rays in the same time. */
#include "bench_lane.h"
#include "counters.h"
#include "flip.h"
#include "json_text.h"
#include "leak.h"
#include "progress.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const scenes[] = {"builtin:hall", "builtin:city"};
static const uint32_t light_counts[] = {16, 64, 256, 1024, 4096}; /* the last two: with settings->all */
enum { SCENE_COUNT = sizeof scenes / sizeof *scenes, LIGHT_COUNTS = 3, ALL_LIGHT_COUNTS = sizeof light_counts / sizeof *light_counts };
enum { GROWTH_MOST = 16, PICTURE_WIDTH = 360 };
#define CELL_BYTES (128 * 128 * 4.0) /* of the counter shadows.cells */
/* Of the moving camera, in each frame: what somebody sees who walks and turns. */
#define STEP 0.05f /* metres, to the right */
#define TURN 0.0175f /* radians */

enum { EQUAL_LIGHTS = 256, EQUAL_FRAMES = 8 }; /* of scenes for the table of equal times; frames before the one whose error counts */

/* What the table of equal times has besides the kinds of shadows. */
static const struct {
    const char *name, *options;
} equal_ways[] = {{"sampled, 2 rays", "shadows=sampled,shadow.rays=2"},
                  {"sampled, 4 rays", "shadows=sampled,shadow.rays=4"},
                  {"guided, 1 ray", "shadows=sampled,shadow.guide=on"},
                  {"guided, 2 rays", "shadows=sampled,shadow.rays=2,shadow.guide=on"},
                  {"guided, 4 rays", "shadows=sampled,shadow.rays=4,shadow.guide=on"},
                  {"denoised, 1 ray", "shadows=sampled,shadow.denoise=on"},
                  {"denoised and guided, 1 ray", "shadows=sampled,shadow.denoise=on,shadow.guide=on"}};
enum { EQUAL_WAYS = sizeof equal_ways / sizeof *equal_ways };

/* One kind of shadows, or a way of the table of equal times. */
struct subject {
    const char *name;
    char options[64];
    struct bench_candidate candidate;
    struct lane lane;
    bool paged;            /* it has pages, and so depends on the frames before */
    uint64_t first_drawn;  /* pages, in the frames until there is all that the first one needs */
    double *moving;        /* milliseconds of frames of the moving camera */
    uint32_t moved;
    double moved_drawn, moved_evicted; /* pages of all those frames */
    fnl_image radiance, color;
};

/* A scene with a number of lights. */
struct shadow_part {
    int index, count;
    const char *name;
    uint32_t lights;
};

/* The names of all kinds but that which chooses one of the others. */
static const char *way_name(uint32_t index) {
    const char *name = fnl_value_name(FNL_ENUM_SHADOWS, index);
    return name && strcmp(name, "auto") != 0 ? name : NULL;
}

static bool render(struct subject *s, const fnl_frame *frame, fnl_frame_stats *stats) {
    double start = lane_now();
    bool good = !interrupt_seen() && fnl_renderer_render(s->lane.renderer, frame) == FNL_OK &&
                fnl_renderer_query_stats(s->lane.renderer, stats) == FNL_OK;
    s->lane.wall = (lane_now() - start) * 1e3;
    return good;
}

static double frame_time(const fnl_frame_stats *stats) {
    double gpu = 0;
    for (uint32_t i = 0; i < stats->pass_count; i++)
        if (stats->passes[i].role != FNL_PASS_READ) gpu += stats->passes[i].milliseconds;
    return fmax(gpu, stats->cpu_milliseconds);
}

/* The first frame, and those until everything has the room that it needs; then a picture, and the counts of a frame in which nothing is new. */
static bool open_subject(struct subject *s) {
    fnl_frame_stats stats = {0};
    fnl_frame frame = s->lane.frame;
    int turns = 0;
    do {
        if (!render(s, &frame, &stats)) return false;
        s->first_drawn += counters_value(&stats, "shadows.drawn");
    } while (counters_overflow(&stats) > 0 && ++turns < GROWTH_MOST);
    for (uint32_t i = 0; i < EQUAL_FRAMES && (frame.shadow.guide || frame.shadow.denoise); i++) /* the seed counts up by itself */
        if (!render(s, &frame, &stats)) return false;
    frame.count_lights = true;
    frame.outputs |= FNL_OUTPUT_RADIANCE;
    if (!render(s, &frame, &stats)) return false;
    lane_note_counts(&s->lane, &stats);
    s->paged = json_object_get(s->lane.counters, "shadows.drawn") != NULL;
    return fnl_renderer_read(s->lane.renderer, FNL_OUTPUT_RADIANCE, &s->radiance) == FNL_OK &&
           fnl_renderer_read(s->lane.renderer, FNL_OUTPUT_COLOR, &s->color) == FNL_OK;
}

static bool time_still(struct subject *s, bool timed) {
    fnl_frame_stats stats = {0};
    return render(s, &s->lane.frame, &stats) && (!timed || lane_note_times(&s->lane, &stats));
}

/* What has no pages costs the same wherever the camera was before. */
static bool time_moving(struct subject *s, uint32_t frames) {
    fnl_frame frame = s->lane.frame;
    for (uint32_t i = 0; i < frames && s->paged; i++) {
        fnl_frame_stats stats = {0};
        fnl_vec3 *eye = &frame.camera.position, *target = &frame.camera.target;
        const float x = target->x - eye->x, z = target->z - eye->z, length = fmaxf(hypotf(x, z), 1e-6f), c = cosf(TURN), n = sinf(TURN);
        eye->x -= STEP * z / length;
        eye->z += STEP * x / length;
        target->x = eye->x + c * x - n * z;
        target->z = eye->z + n * x + c * z;
        if (!render(s, &frame, &stats)) return false;
        s->moving[s->moved++] = frame_time(&stats);
        s->moved_drawn += (double)counters_value(&stats, "shadows.drawn");
        s->moved_evicted += (double)counters_value(&stats, "shadows.evicted");
    }
    return true;
}

static bool measure(const struct bench_settings *settings, const struct shadow_part *part, struct subject *subjects, uint32_t count) {
    const uint32_t rounds = settings->warm_up + settings->frames;
    for (uint32_t i = 0; i < count; i++) {
        double done = part->index + (double)i / count / 2;
        progress_tell(done > 0 ? progress_seconds() * (part->count / done - 1) : -1, "part %d of %d: %s, %u lights, shadows %s", part->index + 1,
                      part->count, part->name, part->lights, subjects[i].name);
        if (!open_subject(&subjects[i])) return false;
    }
    for (uint32_t k = 0; k < rounds; k++) { /* in turn, so that what else the machine does falls on all */
        double done = part->index + 0.5 + (double)k / rounds / 2;
        progress_tell(progress_seconds() * (part->count / done - 1), "part %d of %d: %s, %u lights, frame %u of %u", part->index + 1,
                      part->count, part->name, part->lights, k + 1, rounds);
        for (uint32_t i = 0; i < count; i++)
            if (!time_still(&subjects[i], k >= settings->warm_up)) return false;
    }
    for (uint32_t i = 0; i < count; i++)
        if (!time_moving(&subjects[i], settings->frames)) return false;
    return true;
}

/* ---- rows ---- */

/* The picture of each way, and how far it is from that of rays, under the names that the page looks for. */
static void add_pictures(const struct bench_settings *settings, const struct bench_case *where, struct subject *subjects, uint32_t count,
                         json_t *pictures) {
    fnl_image truth = {0};
    if (fnl_renderer_read(subjects[FNL_SHADOWS_RAYS].lane.renderer, FNL_OUTPUT_COLOR, &truth) != FNL_OK) return;
    for (uint32_t i = 0; i < count; i++) {
        struct bench_candidate shown = subjects[i].candidate;
        fnl_image color = {0}, difference = {0};
        char name[2400];
        shown.lists = settings->reference;
        json_t *key = bench_key(where, &shown), *uri = NULL;
        if (fnl_renderer_read(subjects[i].lane.renderer, FNL_OUTPUT_COLOR, &color) == FNL_OK)
            uri = bench_picture_uri(&color, PICTURE_WIDTH);
        lane_picture_name(key, "reference", name, sizeof name);
        if (uri) json_object_set_new(pictures, name, uri);
        uri = NULL;
        if (i != FNL_SHADOWS_RAYS && fnl_image_difference_picture(NULL, &truth, &color, 16, &difference) == FNL_OK)
            uri = bench_picture_uri(&difference, PICTURE_WIDTH);
        lane_picture_name(key, "shading", name, sizeof name);
        if (uri) json_object_set_new(pictures, name, uri);
        fnl_image_free(NULL, &color);
        fnl_image_free(NULL, &difference);
        json_decref(key);
    }
    fnl_image_free(NULL, &truth);
}

static void add_paged(const struct subject *s, double frame, json_t *row) {
    static const char *const counts[] = {"wanted", "pages", "drawn", "evicted", "coarsened", "traced"};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        char key[64];
        snprintf(key, sizeof key, "shadows.%s", counts[i]);
        json_object_set(row, counts[i], json_object_get(s->lane.counters, key));
    }
    double cells = bench_number(s->lane.counters, "shadows.cells", 0), moving = bench_median_of(s->moving, s->moved);
    json_object_set_new(row, "mebibytes", json_real(cells * CELL_BYTES / 1048576));
    json_object_set_new(row, "first_drawn", json_integer((json_int_t)s->first_drawn));
    json_object_set_new(row, "moving_ms", json_real(moving));
    json_object_set_new(row, "moving_of_still", json_real(moving / frame));
    json_object_set_new(row, "moving_drawn", json_real(s->moved_drawn / s->moved));
    json_object_set_new(row, "moving_evicted", json_real(s->moved_evicted / s->moved));
}

static bool add_rows(const struct bench_settings *settings, const struct bench_case *where, const fnl_scene *scene, struct subject *subjects,
                     uint32_t count, struct bench_data *data) {
    json_t *rows = json_object_get(data->root, "shadows"), *results = json_object_get(data->root, "results");
    fnl_scene_info info = {0};
    double frame = NAN, shading = NAN;
    fnl_scene_query_info(scene, &info);
    for (uint32_t i = 0; i < count; i++) {
        struct subject *s = &subjects[i];
        json_t *result = bench_key(where, &s->candidate);
        snprintf(s->lane.unchecked, sizeof s->lane.unchecked, "kinds of shadows differ");
        lane_add_result(&s->lane, result, &info, false, settings->frames);
        if (i == FNL_SHADOWS_OFF) {
            frame = bench_median(result, "frame_ms");
            shading = bench_median(result, "shading_ms");
        }
        double leak = leak_compare(&s->radiance, &subjects[FNL_SHADOWS_RAYS].radiance, &subjects[FNL_SHADOWS_OFF].radiance);
        json_t *row = json_pack("{s:o,s:I,s:i,s:i,s:s,s:f,s:f,s:f,s:f,s:f}", "scene", json_text(where->scene), "lights", (json_int_t)where->lights, "width",
                                (int)where->width, "height", (int)where->height, "shadows", way_name(i), "frame_ms", bench_median(result, "frame_ms"),
                                "frame_of_off", bench_median(result, "frame_ms") / frame, "shading_ms", bench_median(result, "shading_ms"),
                                "shading_of_off", bench_median(result, "shading_ms") / shading, "shadows_ms", bench_median(result, "shadows_ms"));
        if (!row) return false;
        json_object_set_new(row, "leak", isfinite(leak) ? json_real(leak) : json_null());
        if (s->paged) add_paged(s, bench_median(result, "frame_ms"), row);
        json_array_append_new(rows, row);
        json_array_append_new(results, result);
    }
    return true;
}

/* ---- equal times ---- */

static double luminance_at(const fnl_image *image, size_t i) {
    const float *p = (const float *)image->pixels + 4 * i;
    return 0.2126 * (double)p[0] + 0.7152 * (double)p[1] + 0.0722 * (double)p[2];
}

/* Root mean square of the difference in x / (x + m) of luminances x, with m the mean of the truth: few bright pixels would decide otherwise. */
static double error_of(const fnl_image *seen, const fnl_image *truth) {
    const size_t count = (size_t)truth->width * truth->height;
    double square = 0, mean = 0;
    for (size_t i = 0; i < count; i++) mean += luminance_at(truth, i) / (double)count;
    if (!(mean > 0)) return NAN;
    for (size_t i = 0; i < count; i++) {
        const double a = luminance_at(seen, i), b = luminance_at(truth, i), e = a / (a + mean) - b / (b + mean);
        square += e * e / (double)count;
    }
    return sqrt(square);
}

static json_t *real_or_null(double value) { return isfinite(value) ? json_real(value) : json_null(); }

/* Rows for `rays`, `maps`, `sampled` and all that follow the kinds. Noise falls with the root of the time that is spent on it, so that time times the square of
   the error says what a way is worth, whatever it takes. */
static bool add_equal_rows(const struct bench_case *where, struct subject *subjects, uint32_t count, struct bench_data *data) {
    json_t *rows = json_object_get(data->root, "equal_time");
    const struct subject *rays = &subjects[FNL_SHADOWS_RAYS];
    double off = NAN, first = NAN;
    for (uint32_t i = 0; i < count; i++) {
        struct subject *s = &subjects[i];
        const uint32_t measured = s->lane.measured;
        const double frame = bench_median_of(s->lane.times[LANE_FRAME], measured), error = error_of(&s->radiance, &rays->radiance);
        const double passes = bench_median_of(s->lane.times[LANE_SHADING], measured) + bench_median_of(s->lane.times[LANE_SHADOWS], measured);
        if (i == FNL_SHADOWS_OFF) off = passes;
        if (i != FNL_SHADOWS_RAYS && i != FNL_SHADOWS_MAPS && i != FNL_SHADOWS_SAMPLED && way_name(i)) continue;
        const double over = passes - off, cost = over > 0 ? over * error * error : NAN;
        if (i == FNL_SHADOWS_SAMPLED) first = cost;
        json_t *row = json_pack("{s:o,s:I,s:i,s:i,s:s,s:f,s:f}", "scene", json_text(where->scene), "lights", (json_int_t)where->lights, "width", (int)where->width, "height",
                                (int)where->height, "way", i == FNL_SHADOWS_SAMPLED ? "sampled, 1 ray" : s->name, "frame_ms", frame, "over_off_ms", over);
        if (!row) return false;
        json_object_set_new(row, "rmse", real_or_null(error));
        json_object_set_new(row, "flip", real_or_null(flip_compare(&s->color, &rays->color, FLIP_PIXELS_PER_DEGREE, NULL)));
        json_object_set_new(row, "cost", real_or_null(cost));
        json_object_set_new(row, "gain", cost > 0 ? real_or_null(first / cost) : json_null());
        json_array_append_new(rows, row);
    }
    return true;
}

/* ---- a scene ---- */

static bool open_lanes(fnl_device *device, fnl_scene *scene, const struct bench_settings *settings, const struct bench_case *where,
                       const fnl_camera *camera, struct subject *subjects, uint32_t kinds, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) {
        struct subject *s = &subjects[i];
        const char *kind = way_name(i);
        s->name = kind ? kind : equal_ways[i - kinds].name;
        if (i != FNL_SHADOWS_OFF) snprintf(s->options, sizeof s->options, "%s%s", kind ? "shadows=" : "", kind ? kind : equal_ways[i - kinds].options);
        s->candidate = (struct bench_candidate){FNL_SHADING_DEFERRED, FNL_LISTS_TILED, s->options};
        s->moving = calloc(settings->frames + 1, sizeof *s->moving);
        if (!lane_init(&s->lane, where, &s->candidate, settings->frames) || !s->moving ||
            fnl_renderer_create(device, scene, &s->lane.own) != FNL_OK)
            return false;
        s->lane.renderer = s->lane.own;
        s->lane.frame.camera = *camera;
    }
    return true;
}

static bool run_case(fnl_device *device, const struct bench_settings *settings, const struct bench_case *where, const struct shadow_part *part,
                     struct bench_data *data) {
    uint32_t kinds = 0;
    while (way_name(kinds)) kinds++;
    const bool equal = where->lights >= EQUAL_LIGHTS && (settings->all || strcmp(where->scene, scenes[0]) == 0);
    const uint32_t count = kinds + (equal ? EQUAL_WAYS : 0);
    struct subject *subjects = calloc(count, sizeof *subjects);
    const fnl_host host = fnl_host_default();
    struct bench_path path = {0};
    fnl_camera camera;
    fnl_scene *scene = NULL;
    bool good = subjects && bench_scene_load(&host, settings, where->scene, where->lights, &scene) &&
                bench_scene_path(scene, settings, NULL, (float)where->width / (float)where->height, &path) && bench_path_camera(&path, scene, 0, &camera) &&
                open_lanes(device, scene, settings, where, &camera, subjects, kinds, count) &&
                measure(settings, part, subjects, count) && add_rows(settings, where, scene, subjects, kinds, data) &&
                (!equal || add_equal_rows(where, subjects, count, data));
    if (good) add_pictures(settings, where, subjects, kinds, data->pictures);
    for (uint32_t i = 0; i < count && subjects; i++) {
        fnl_image_free(NULL, &subjects[i].radiance);
        fnl_image_free(NULL, &subjects[i].color);
        free(subjects[i].moving);
        lane_finish(&subjects[i].lane);
    }
    free(subjects);
    bench_path_destroy(&path);
    fnl_scene_destroy(&scene);
    return good;
}

bool bench_shadows_measure(const struct bench_settings *settings, uint32_t width, uint32_t height, struct bench_data *data) {
    fnl_device *device = NULL;
    fnl_device_info info = {0};
    const int numbers = settings->all ? ALL_LIGHT_COUNTS : LIGHT_COUNTS;
    struct shadow_part part = {.count = SCENE_COUNT * numbers};
    bool good = bench_create_device(settings, NULL, &device) && fnl_device_query_info(device, &info) == FNL_OK, cpu = info.type == FNL_DEVICE_CPU;
    json_object_set_new(data->root, "shadows", json_array());
    json_object_set_new(data->root, "equal_time", json_array());
    json_object_set_new(data->root, "results", json_array());
    progress_begin(settings->quiet, PROGRESS_SECONDS);
    for (; part.index < part.count && good; part.index++) {
        part.name = scenes[part.index / numbers];
        part.lights = light_counts[part.index % numbers];
        const struct bench_case where = {.scene = part.name, .lights = part.lights, .width = width ? width : cpu ? 320 : 1280,
                                         .height = width ? height : cpu ? 180 : 720, .msaa = 1};
        good = run_case(device, settings, &where, &part, data);
    }
    progress_end();
    if (good && settings->validate && fnl_device_validation_count(device)) {
        fputs("fanal: error: Vulkan validation sent messages\n", stderr);
        good = false;
    }
    fnl_device_destroy(&device);
    return good;
}

/* ---- the tables ---- */

/* Of ways without bias in one scene the one that takes least time for an error. */
static void add_best(const json_t *rows, size_t first, json_t *lines) {
    const json_t *begin = json_array_get(rows, first), *best = NULL, *row;
    for (size_t i = first; (row = json_array_get(rows, i)); i++) {
        const char *way = json_string_value(json_object_get(row, "way"));
        if (!json_equal(json_object_get(row, "scene"), json_object_get(begin, "scene")) || !json_equal(json_object_get(row, "lights"), json_object_get(begin, "lights"))) break;
        if (strncmp(way, "sampled", 7) != 0 && strncmp(way, "guided", 6) != 0) continue;
        if (bench_number(row, "gain", 0) > bench_number(best, "gain", 0)) best = row;
    }
    if (!best) return;
    char text[320];
    snprintf(text, sizeof text, "%s, %.0f lights: for the same noise \"%s\" takes %.2f of the time of one sampled ray.", json_string_value(json_object_get(best, "scene")),
             bench_number(best, "lights", 0), json_string_value(json_object_get(best, "way")), 1 / bench_number(best, "gain", NAN));
    json_array_append_new(lines, json_text(text));
}

static void tabulate_equal(const struct bench_data *data, json_t *tables) {
    static const struct {
        const char *name, *key; /* a key of a row */
    } columns[] = {{"<scene", "scene"}, {"lights", "lights"}, {"<shadows", "way"}, {"frame, ms", "frame_ms"}, {"shadows, ms", "over_off_ms"},
                   {"RMSE, %", "rmse"}, {"FLIP", "flip"},     {"time x MSE", "cost"}, {"gain", "gain"}};
    const json_t *rows = json_object_get(data->root, "equal_time"), *row, *before = NULL;
    if (json_array_size(rows) == 0) return;
    json_t *names = json_array(), *cells = json_array(), *lines = json_array();
    size_t i;
    for (size_t c = 0; c < sizeof columns / sizeof *columns; c++) json_array_append_new(names, json_string(columns[c].name));
    json_array_foreach(rows, i, row) {
        json_t *line = json_array();
        for (size_t c = 0; c < sizeof columns / sizeof *columns; c++) {
            json_t *value = json_object_get(row, columns[c].key);
            json_array_append_new(line, strcmp(columns[c].key, "rmse") == 0 && json_is_real(value) ? json_real(100 * json_real_value(value)) : json_incref(value));
        }
        json_array_append_new(cells, line);
        if (!before || !json_equal(json_object_get(row, "scene"), json_object_get(before, "scene")) || !json_equal(json_object_get(row, "lights"), json_object_get(before, "lights")))
            add_best(rows, i, lines);
        before = row;
    }
    json_array_append_new(tables, json_pack("{s:s,s:s,s:o,s:o,s:o}", "name", "equal time", "title",
                                            "How near to rays in the same time: error of a frame, guided and denoised after eight others; time of its shading and shadow passes over that without shadows", "columns", names,
                                            "rows", cells, "lines", lines));
}

void bench_table_shadows(const struct bench_data *data, json_t *tables) {
    static const struct {
        const char *name, *key; /* a key of a row */
    } columns[] = {{"<scene", "scene"},
                   {"lights", "lights"},
                   {"<shadows", "shadows"},
                   {"frame, ms", "frame_ms"},
                   {"/ off", "frame_of_off"},
                   {"shading, ms", "shading_ms"},
                   {"/ off", "shading_of_off"},
                   {"maps, ms", "shadows_ms"},
                   {"leak, %", "leak"},
                   {"MiB", "mebibytes"},
                   {"wanted", "wanted"},
                   {"coarsened", "coarsened"},
                   {"traced", "traced"},
                   {"drawn first", "first_drawn"},
                   {"still", "drawn"},
                   {"moving", "moving_drawn"},
                   {"evicted", "moving_evicted"},
                   {"moving / still", "moving_of_still"}};
    const json_t *rows = json_object_get(data->root, "shadows"), *row;
    json_t *names = json_array(), *cells = json_array(), *lines = json_array();
    size_t i, count = sizeof columns / sizeof *columns;
    uint64_t lights = 0, traced = 0;
    for (size_t c = 0; c < count; c++) json_array_append_new(names, json_string(columns[c].name));
    json_array_foreach(rows, i, row) {
        json_t *line = json_array();
        for (size_t c = 0; c < count; c++) {
            json_t *value = json_object_get(row, columns[c].key);
            if (strcmp(columns[c].key, "leak") == 0 && json_is_real(value))
                json_array_append_new(line, json_real(100 * json_real_value(value)));
            else
                json_array_append_new(line, value ? json_incref(value) : json_null());
        }
        json_array_append_new(cells, line);
        if (!json_object_get(row, "traced") || strcmp(json_string_value(json_object_get(row, "shadows")), "maps") != 0) continue;
        lights += (uint64_t)bench_number(row, "lights", 0);
        traced += (uint64_t)bench_number(row, "traced", 0);
    }
    char text[256];
    snprintf(text, sizeof text, "Of %llu lights with shadow maps %llu found no room for a map: rays found their shadows.",
             (unsigned long long)lights, (unsigned long long)traced);
    if (lights) json_array_append_new(lines, json_text(text));
    json_array_append_new(tables, json_pack("{s:s,s:s,s:o,s:o,s:o}", "name", "shadows", "title",
                                            "Shadows of more and more lights: medians; pages of shadow maps in the first frames, in a still one, and "
                                            "in each frame of a moving camera",
                                            "columns", names, "rows", cells, "lines", lines));
    tabulate_equal(data, tables);
}
