/* SPDX-License-Identifier: MIT */
/* Measures the plan: of each case one frame of every candidate in turn, again and again, so that what disturbs the machine disturbs
 * all alike; and compares every picture with the reference. */
#include "arguments.h"
#include "bench.h"
#include "bench_lane.h"
#include "json_text.h"
#include "print.h"
#include "program.h"
#include "progress.h"
#include "stereo.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum { FORMAT_VERSION = 1 }; /* of results.json: docs/bench.schema.json */

/* ---- log ---- */

/* While candidates are tried their errors are kept, not printed: they become the reason why one was left out. */
struct log_sink {
    bool keep;
    char last[512];
};

static void receive_log(void *user, fnl_log_level level, const char *line) {
    struct log_sink *sink = user;
    if (level == FNL_LOG_ERROR && sink->keep)
        snprintf(sink->last, sizeof sink->last, "%s", line);
    else if (level >= FNL_LOG_WARNING)
        fprintf(stderr, isatty(STDERR_FILENO) ? "\r\033[Kfanal: %s: %s\n" : "fanal: %s: %s\n", level == FNL_LOG_ERROR ? "error" : "warning", line);
}

/* ---- state ---- */

struct bench_run {
    const struct bench_settings *settings;
    const struct bench_plan *plan;
    struct bench_data *data;
    struct log_sink sink;
    fnl_host host;
    fnl_device *device;
    fnl_device_info info;
    /* The scene of the case at hand, kept while the next case has the same. */
    fnl_scene *scene;
    const char *scene_name;
    int64_t scene_lights;
    struct bench_path path;
    struct stereo stereo;
    fnl_camera eyes[HEADSET_EYES];
    fnl_vec3 gaze;
    struct lane *lanes;
    uint32_t lane_count, opened, case_index, wanted; /* wanted: frames of each lane, more on a busy machine */
    struct bench_busy busy; /* when the case began */
    bool shared;         /* one renderer for all lanes, because memory is short */
    double case_started, saved; /* seconds of progress */
    bool failed;
};

static bool stopped(const struct bench_run *run) { return interrupt_seen() || run->failed; }

/* ---- progress ---- */

/* Cases count by their pixels and ways. */
static double case_work(const struct bench_case *c) { return (double)c->width * c->height * c->msaa * c->candidate_count; }

/* Seconds: frames that are still to be timed, as long as those of their ways so far; ways still to be opened, as those that were; then other cases,
 * by their work. Negative: not known yet. */
static double seconds_left(const struct bench_run *run) {
    double frames = 0, walls = 0, left = 0, mean, elapsed = progress_seconds() - run->case_started, later = 0;
    for (uint32_t i = 0; i < run->lane_count; i++) {
        frames += run->lanes[i].measured > 0;
        walls += run->lanes[i].measured > 0 ? run->lanes[i].wall * 1e-3 : 0;
    }
    if (frames == 0 || run->opened == 0) return -1;
    mean = walls / frames;
    for (uint32_t i = 0; i < run->lane_count; i++) {
        const struct lane *lane = &run->lanes[i];
        uint32_t timed = run->wanted > lane->measured ? run->wanted - lane->measured : 0;
        if (!lane->failed) left += timed * (lane->measured ? lane->wall * 1e-3 : mean) * (run->shared ? 2 : 1);
    }
    if (run->opened < run->lane_count) left += elapsed / run->opened * (run->lane_count - run->opened);
    for (uint32_t i = run->case_index + 1; i < run->plan->case_count; i++) later += case_work(&run->plan->cases[i]);
    return left + (elapsed + left) * later / fmax(case_work(&run->plan->cases[run->case_index]), 1);
}

/* "case 1 of 2, way 3 of 22: deferred with tiled lists, comparing pictures" */
static void show_progress(const struct bench_run *run, const struct lane *lane, const char *what) {
    char name[256], of_case[64] = "";
    bench_describe_candidate(lane->candidate, name, sizeof name);
    if (run->plan->case_count > 1) snprintf(of_case, sizeof of_case, "case %u of %u, ", run->case_index + 1, run->plan->case_count);
    progress_tell(seconds_left(run), "%sway %u of %u: %s, %s", of_case, (unsigned)(lane - run->lanes) + 1, run->lane_count, name, what);
}

static bool is_measured(const struct bench_run *run, const struct bench_case *c, const struct bench_candidate *candidate) {
    return json_is_true(json_object_get(bench_find(run->data, c, candidate), "complete"));
}

/* ---- the scene ---- */

static bool prepare_scene(struct bench_run *run, const struct bench_case *c) {
    if (run->scene && strcmp(run->scene_name, c->scene) == 0 && run->scene_lights == c->lights) return true;
    fnl_scene_destroy(&run->scene);
    run->scene_name = c->scene;
    run->scene_lights = c->lights;
    return bench_scene_load(&run->host, run->settings, c->scene, c->lights, &run->scene);
}

static bool prepare_path(struct bench_run *run, const struct bench_case *c) {
    bench_path_destroy(&run->path);
    return bench_scene_path(run->scene, run->settings, c->camera, (float)c->width / (float)c->height, &run->path);
}

/* ---- lanes ---- */

static void lane_fail(struct bench_run *run, struct lane *lane, fnl_result result) {
    snprintf(lane->reason, sizeof lane->reason, "%s", *run->sink.last ? run->sink.last : fnl_result_name(result));
    lane->failed = true;
    lane->unsupported = result == FNL_ERROR_UNSUPPORTED;
    if (result == FNL_ERROR_DEVICE_LOST) {
        fprintf(stderr, "fanal: error: the device was lost: %s\n", lane->reason);
        run->failed = true;
    }
}

static bool render(struct bench_run *run, struct lane *lane, const fnl_frame *frame, fnl_frame_stats *stats) {
    run->sink.last[0] = 0;
    double start = lane_now();
    fnl_result result = fnl_renderer_render(lane->renderer, frame);
    if (result == FNL_OK) result = fnl_renderer_query_stats(lane->renderer, stats);
    lane->wall = (lane_now() - start) * 1e3;
    if (result != FNL_OK) lane_fail(run, lane, result);
    return result == FNL_OK;
}

static fnl_frame frame_at(struct bench_run *run, const struct lane *lane, uint32_t index) {
    fnl_frame frame = lane->frame;
    const struct bench_point *point = &run->path.points[index % run->path.count];
    if (!bench_path_camera(&run->path, run->scene, index, &frame.camera)) run->failed = true;
    if (!run->settings->stereo) return frame;
    frame.views = run->eyes;
    frame.view_count = HEADSET_EYES;
    if (!lane->frame.stereo.eyes) frame.stereo.eyes = HEADSET_EYES;
    if (!stereo_cameras(&run->stereo, &frame.camera, point->time, frame.width, frame.height, run->eyes)) run->failed = true;
    frame.gaze = stereo_gaze(&run->stereo, &frame.camera, point->time, &run->gaze);
    return frame;
}

/* Poses the scene as the path's point says; where nothing moves this changes nothing. */
static void pose(struct bench_run *run, uint32_t index) {
    fnl_scene_info info;
    if (run->settings->camera_path && fnl_scene_query_info(run->scene, &info) == FNL_OK && info.animation_count > 0)
        fnl_scene_set_time(run->scene, 0, run->path.points[index % run->path.count].time);
}

/* A renderer for each lane, so that none finds the memory and caches of another's frame; where these do not fit, one for all, and a frame to
 * settle before each timed one. The first one is made here and tells what one takes. */
static bool make_first_renderer(struct bench_run *run) {
    struct lane *first = &run->lanes[0];
    fnl_frame_stats stats = {0};
    run->sink.last[0] = 0;
    fnl_result result = fnl_renderer_create(run->device, run->scene, &first->own);
    first->renderer = first->own;
    if (result != FNL_OK) {
        fprintf(stderr, "fanal: error: %s\n", *run->sink.last ? run->sink.last : fnl_result_name(result));
        return false;
    }
    fnl_frame frame = frame_at(run, first, 0);
    if (!render(run, first, &frame, &stats)) stats.device_bytes = 256 << 20;
    uint64_t budget = run->info.memory_bytes / 4;
    if (run->info.type == FNL_DEVICE_CPU && budget > (uint64_t)2 << 30) budget = (uint64_t)2 << 30;
    run->shared = stats.device_bytes * run->lane_count > budget;
    return true;
}

/* Until the pools of lists and of culling have grown to what they need, auto has decided, and at least the frames asked for. */
static void warm_up(struct bench_run *run, struct lane *lane, uint32_t frames) {
    fnl_frame_stats stats = {.overflow_cells = 1};
    fnl_frame frame = frame_at(run, lane, 0);
    for (uint32_t i = 0; i < frames || stats.choosing || (stats.overflow_cells + stats.items_whole > 0 && i < frames + 4); i++) {
        if (stopped(run) || lane->failed || !render(run, lane, &frame, &stats)) return;
        show_progress(run, lane, "warming up");
        if (stats.pipelines_pending) nanosleep(&(struct timespec){.tv_nsec = 50000000}, NULL); /* rather than hold that up */
    }
}

static void open_lane(struct bench_run *run, struct lane *lane) {
    if (!lane->renderer && !run->shared && fnl_renderer_create(run->device, run->scene, &lane->own) != FNL_OK) run->shared = true;
    if (!lane->renderer) lane->renderer = lane->own ? lane->own : run->lanes[0].own;
    warm_up(run, lane, 1);
    run->opened++;
}

/* ---- comparing pictures ---- */

static void add_picture(struct bench_run *run, const json_t *key, const char *kind, const fnl_image *picture) {
    char name[2400];
    lane_picture_name(key, kind, name, sizeof name);
    json_t *uri = bench_picture_uri(picture, 360);
    if (uri) json_object_set_new(run->data->pictures, name, uri);
}

/* Pictures of every case would make a page of many megabytes: the one with most lights of each scene shows its own. */
static bool wants_pictures(const struct bench_run *run, const struct bench_case *c) {
    for (uint32_t i = 0; i < run->plan->case_count; i++) {
        const struct bench_case *other = &run->plan->cases[i];
        if (strcmp(other->scene, c->scene) != 0 || other == c) continue;
        if (other->lights > c->lights || (other->lights == c->lights && other < c)) return false;
    }
    return true;
}

static void add_difference(struct bench_run *run, const json_t *key, const char *kind, const fnl_image *a,
                           const fnl_image *b, float gain) {
    fnl_image picture = {0};
    if (fnl_image_difference_picture(&run->host, a, b, gain, &picture) == FNL_OK) add_picture(run, key, kind, &picture);
    fnl_image_free(&run->host, &picture);
}

struct reference {
    bool made;
    char reason[256];
    fnl_image radiance, color;
};

static bool read_pictures(struct bench_run *run, struct lane *lane, fnl_image *radiance, fnl_image *color) {
    fnl_result result = fnl_renderer_read(lane->renderer, FNL_OUTPUT_RADIANCE, radiance);
    if (result == FNL_OK) result = fnl_renderer_read(lane->renderer, FNL_OUTPUT_COLOR, color);
    if (result != FNL_OK) lane_fail(run, lane, result);
    return result == FNL_OK;
}

/* The reference picture of one shading path, drawn by the renderer of a lane that has it. */
static void make_reference(struct bench_run *run, struct lane *lane, uint32_t point, struct reference *out) {
    fnl_frame_stats stats;
    struct lane drawn = *lane; /* a failure is the reference's, not the lane's */
    fnl_frame frame = frame_at(run, lane, point);
    frame.lists = run->settings->reference;
    const fnl_frame usual = bench_frame();
    bench_ways_reset_lists(&frame);
    /* Vertex and mesh shaders may differ in the last bits of places, so the latter are compared with their own. */
    frame.culling = frame.geometry == FNL_GEOMETRY_VERTEX ? usual.culling : FNL_CULLING_CLUSTERS;
    frame.occlusion = FNL_OCCLUSION_OFF;
    frame.outputs |= FNL_OUTPUT_RADIANCE;
    out->made = render(run, &drawn, &frame, &stats) && read_pictures(run, &drawn, &out->radiance, &out->color);
    if (!out->made) snprintf(out->reason, sizeof out->reason, "%.255s", drawn.reason);
}

static void free_reference(struct bench_run *run, struct reference *reference) {
    fnl_image_free(&run->host, &reference->radiance);
    fnl_image_free(&run->host, &reference->color);
    *reference = (struct reference){0};
}

static void show_heat(struct bench_run *run, struct lane *lane, const json_t *key, uint32_t point) {
    fnl_frame_stats stats;
    fnl_image heat = {0};
    struct lane drawn = *lane;
    fnl_frame frame = frame_at(run, lane, point);
    frame.debug = FNL_DEBUG_LIGHTS;
    if (render(run, &drawn, &frame, &stats) && fnl_renderer_read(drawn.renderer, FNL_OUTPUT_COLOR, &heat) == FNL_OK)
        add_picture(run, key, "lights", &heat);
    fnl_image_free(&run->host, &heat);
}

/* Draws a point of the path, counting evaluations, and compares it with the reference. */
static void check_lane(struct bench_run *run, struct lane *lane, uint32_t point, const struct reference *reference) {
    const struct bench_case *c = &run->plan->cases[run->case_index];
    fnl_frame_stats stats;
    fnl_image radiance = {0}, color = {0};
    fnl_frame frame = frame_at(run, lane, point);
    frame.count_lights = true;
    frame.timers = false;
    frame.outputs |= FNL_OUTPUT_RADIANCE;
    if (!render(run, lane, &frame, &stats)) return;
    lane_note_counts(lane, &stats);
    json_t *key = bench_key(c, lane->candidate);
    bool first = lane->checked == 0, pictures = wants_pictures(run, c);
    /* With samples, Mesa's CPU driver tests depth after shaders that count, and takes other centroids: what is timed is compared. */
    frame.count_lights = false;
    bool compares = reference->made && (c->msaa == 1 || render(run, lane, &frame, &stats));
    if (compares && read_pictures(run, lane, &radiance, &color)) {
        uint64_t differing;
        double max;
        bench_picture_compare(&reference->radiance, &radiance, &differing, &max);
        if (differing && lane->differing == 0) {
            add_picture(run, key, "picture", &color);
            add_difference(run, key, "difference", &reference->radiance, &radiance, 0);
        }
        lane->differing += differing;
        lane->max_difference = fmax(lane->max_difference, max);
        lane->checked++;
    } else if (!reference->made) {
        snprintf(lane->unchecked, sizeof lane->unchecked, "%s", *reference->reason ? reference->reason : "not asked for");
    }
    if (first && pictures && run->settings->checks && !lane->failed) show_heat(run, lane, key, point);
    fnl_image_free(&run->host, &radiance);
    fnl_image_free(&run->host, &color);
    json_decref(key);
}

/* The picture of each shading path and way, and how far it is from the first one's. */
static void show_reference(struct bench_run *run, const struct lane *lane, const struct reference *reference,
                           fnl_image *first) {
    const struct bench_case *c = &run->plan->cases[run->case_index];
    char ways[256];
    bench_ways_of(lane->candidate->options, ways, sizeof ways);
    struct bench_candidate shown = {lane->candidate->shading, run->settings->reference, ways};
    json_t *key = bench_key(c, &shown);
    add_picture(run, key, "reference", &reference->color);
    if (first->pixels)
        add_difference(run, key, "shading", first, &reference->color, 16);
    else {
        size_t size = (size_t)reference->color.width * reference->color.height * 4;
        *first = reference->color;
        first->pixels = malloc(size);
        if (first->pixels) memcpy(first->pixels, reference->color.pixels, size);
    }
    json_decref(key);
}

/* Of different orders the last bits differ, of other ways more: each has a reference of its own. */
static bool same_reference(const struct lane *a, const struct lane *b) {
    char ways_a[256], ways_b[256];
    bench_ways_of(a->candidate->options, ways_a, sizeof ways_a);
    bench_ways_of(b->candidate->options, ways_b, sizeof ways_b);
    return a->candidate->shading == b->candidate->shading && strcmp(ways_a, ways_b) == 0;
}

/* ---- results ---- */

/* Of what should have been measured, such as one for which memory ran out: the others are compared without it. */
static void tell_failure(const struct bench_run *run, const struct lane *lane) {
    char name[256];
    bench_describe_candidate(lane->candidate, name, sizeof name);
    fprintf(stderr, isatty(STDERR_FILENO) ? "\r\033[Kfanal: error: %s, %s: not measured: %s\n" : "fanal: error: %s, %s: not measured: %s\n",
            run->plan->cases[run->case_index].scene, name, lane->reason);
}

/* What was measured of a lane by now replaces what stood there before. */
static void keep_result(struct bench_run *run, struct lane *lane) {
    const struct bench_case *c = &run->plan->cases[run->case_index];
    json_t *results = json_object_get(run->data->root, "results"), *skipped = json_object_get(run->data->root, "skipped");
    json_t *key = bench_key(c, lane->candidate), *before = bench_find(run->data, c, lane->candidate);
    fnl_scene_info info = {0};
    fnl_scene_query_info(run->scene, &info);
    if (lane->failed) {
        json_object_set_new(key, "reason", json_text(lane->reason));
        if (!lane->unsupported) json_object_set_new(key, "failed", json_true());
        if (!lane->told && !lane->unsupported) tell_failure(run, lane);
        if (!lane->told) json_array_append(skipped, key);
        for (size_t i = json_array_size(results); i-- > 0 && !lane->told;)
            if (json_array_get(results, i) == before) json_array_remove(results, i);
        lane->told = true;
    } else if (lane->measured > 0) {
        if (before) json_object_update_missing(key, before); /* counts and comparison of an earlier run */
        const struct bench_busy now = bench_busy_now();
        lane_add_result(lane, key, &info, run->shared, run->wanted);
        json_object_set_new(key, "others", json_real(bench_others(&run->busy, &now)));
        if (before) {
            json_object_clear(before);
            json_object_update(before, key);
        } else {
            json_array_append(results, key);
        }
    }
    json_decref(key);
}

/* Once a second is enough: between frames that take milliseconds writing would be what is measured. */
static void save_results(struct bench_run *run, bool now) {
    if (json_array_size(json_object_get(run->data->root, "results")) == 0) return;
    if (!now && progress_seconds() - run->saved < 1) return;
    run->saved = progress_seconds();
    if (!bench_save(run->settings->output, run->data, false)) run->failed = true;
}

/* ---- one case ---- */

static void time_frame(struct bench_run *run, struct lane *lane, uint32_t round) {
    fnl_frame_stats stats;
    fnl_frame frame = frame_at(run, lane, round);
    if (run->shared) render(run, lane, &frame, &stats);
    if (!lane->failed && render(run, lane, &frame, &stats) && !lane_note_times(lane, &stats)) {
        snprintf(lane->reason, sizeof lane->reason, "memory ran out");
        lane->failed = true;
    }
}

/* The first time a lane is seen: after the comparison its first frame is timed at once, so that whatever ends the run finds a result of it. */
static void begin_lane(struct bench_run *run, struct lane *lane) {
    warm_up(run, lane, run->settings->warm_up > 1 ? run->settings->warm_up - 1 : 1);
    if (!lane->failed && !stopped(run) && lane->measured == 0) time_frame(run, lane, 0);
    keep_result(run, lane);
    save_results(run, false);
}

/* All lanes that `first` shares its reference with. */
static void check_group(struct bench_run *run, struct lane *first, uint32_t point, bool compare, bool begin, fnl_image *base) {
    struct reference reference = {0};
    const struct lane *end = run->lanes + run->lane_count;
    bool wanted = false;
    for (const struct lane *lane = first; lane < end; lane++) wanted = wanted || (!lane->kept && same_reference(first, lane));
    if (strcmp(fnl_value_name(FNL_ENUM_SHADING, first->candidate->shading), "auto") == 0) { /* it may choose another for the reference */
        snprintf(reference.reason, sizeof reference.reason, "the shading path is chosen");
    } else if (compare && wanted) {
        show_progress(run, first, "drawing the reference picture");
        make_reference(run, first, point, &reference);
        if (reference.made && begin && wants_pictures(run, &run->plan->cases[run->case_index])) show_reference(run, first, &reference, base);
    }
    for (struct lane *lane = first; lane < end && !stopped(run); lane++) {
        if (lane->visited || lane->failed || !same_reference(first, lane)) continue;
        lane->visited = true;
        if (begin && lane != first) open_lane(run, lane);
        show_progress(run, lane, "comparing pictures");
        if (!lane->failed && !lane->kept && !stopped(run)) check_lane(run, lane, point, &reference);
        if (begin && !stopped(run)) begin_lane(run, lane);
    }
    free_reference(run, &reference);
}

static void check_point(struct bench_run *run, uint32_t point, bool compare, bool begin) {
    fnl_image base = {0};
    pose(run, point);
    for (uint32_t i = 0; i < run->lane_count; i++) run->lanes[i].visited = false;
    for (uint32_t i = 0; i < run->lane_count && !stopped(run); i++) {
        struct lane *lane = &run->lanes[i];
        if (lane->visited || lane->failed) continue;
        if (begin) open_lane(run, lane);
        if (!lane->failed && !stopped(run)) check_group(run, lane, point, compare, begin, &base);
        if (lane->failed) keep_result(run, lane);
    }
    free(base.pixels);
}

/* Each round renders the lanes in another order, so that none always follows the same one. */
static void time_round(struct bench_run *run, uint32_t round) {
    char what[64];
    bool any = false;
    snprintf(what, sizeof what, "frame %u of %u", round + 1, run->wanted);
    pose(run, round);
    for (uint32_t i = 0; i < run->lane_count && !stopped(run); i++) {
        uint32_t turn = round % 2 ? run->lane_count - 1 - i : i;
        struct lane *lane = &run->lanes[(turn + round / 2) % run->lane_count];
        if (lane->failed || lane->measured > round) continue;
        show_progress(run, lane, what);
        time_frame(run, lane, round);
        any = true;
    }
    if (!any || progress_seconds() - run->saved < 1) return;
    for (uint32_t i = 0; i < run->lane_count; i++) keep_result(run, &run->lanes[i]);
    save_results(run, false);
}

/* Of all lanes, so that they go on taking turns. */
static uint32_t frames_wanted(const struct bench_run *run) {
    const struct bench_busy now = bench_busy_now();
    const bool busy = bench_is_busy(bench_others(&run->busy, &now), (uint32_t)sysconf(_SC_NPROCESSORS_ONLN));
    uint32_t wanted = run->wanted;
    for (uint32_t i = 0; i < run->lane_count && run->settings->more; i++) {
        struct bench_spread spread;
        const struct lane *lane = &run->lanes[i];
        if (lane->failed || !bench_spread_of(lane->times[LANE_FRAME], lane->measured, &spread)) continue;
        const uint32_t own = bench_frames_wanted(&spread, lane->measured, run->settings->frames, busy);
        if (own > wanted) wanted = own;
    }
    return wanted;
}

static void run_lanes(struct bench_run *run) {
    const struct bench_settings *s = run->settings;
    run->sink.keep = true;
    if (!make_first_renderer(run)) {
        run->failed = true;
        return;
    }
    uint32_t points = run->path.count < s->frames ? run->path.count : s->frames;
    uint32_t checks = s->checks < points ? s->checks : points, before = UINT32_MAX;
    const struct bench_case *c = &run->plan->cases[run->case_index];
    for (uint32_t i = 0; i < run->lane_count; i++)
        lane_restore(&run->lanes[i], bench_find(run->data, c, run->lanes[i].candidate), checks);
    for (uint32_t i = 0; i < (checks ? checks : 1) && !stopped(run); i++) {
        uint32_t point = checks > 1 ? (uint32_t)((uint64_t)i * (points - 1) / (checks - 1)) : 0;
        if (point != before) check_point(run, point, checks > 0, i == 0);
        before = point;
    }
    for (uint32_t i = 0; i < run->lane_count; i++)
        if (run->lanes[i].measured > run->wanted) run->wanted = run->lanes[i].measured;
    for (uint32_t round = 0; round < run->wanted && !stopped(run); round++) {
        time_round(run, round);
        if (round + 1 == run->wanted) run->wanted = frames_wanted(run);
    }
    run->sink.keep = false;
}

static void announce_case(const struct bench_run *run, const struct bench_case *c) {
    char lights[32] = "";
    if (run->settings->quiet || isatty(STDERR_FILENO)) return;
    if (c->lights >= 0) snprintf(lights, sizeof lights, ", lights %lld", (long long)c->lights);
    fprintf(stderr, "case %u of %u: %s%s, %ux%u, MSAA %u: %u ways%s\n", run->case_index + 1, run->plan->case_count, c->scene,
            lights, c->width, c->height, c->msaa, run->lane_count, run->plan->likely ? ", the likely ones (--all: every one)" : "");
}

static void run_case(struct bench_run *run, const struct bench_case *c) {
    run->lanes = calloc(c->candidate_count + 1, sizeof *run->lanes);
    run->lane_count = run->opened = 0;
    run->wanted = run->settings->frames;
    run->busy = bench_busy_now();
    run->case_started = progress_seconds();
    if (!run->lanes) {
        run->failed = true;
        return;
    }
    for (uint32_t i = 0; i < c->candidate_count; i++)
        if (!is_measured(run, c, &c->candidates[i]) &&
            !lane_init(&run->lanes[run->lane_count++], c, &c->candidates[i], run->settings->frames * (run->settings->more ? BENCH_FRAMES_FACTOR : 1)))
            run->failed = true;
    if (run->lane_count > 0 && !run->failed) {
        if (!prepare_scene(run, c) || !prepare_path(run, c)) {
            run->failed = true;
        } else {
            announce_case(run, c);
            run_lanes(run);
            for (uint32_t i = 0; i < run->lane_count; i++) keep_result(run, &run->lanes[i]);
            save_results(run, true);
        }
    }
    for (uint32_t i = 0; i < run->lane_count; i++) lane_finish(&run->lanes[i]);
    free(run->lanes);
    run->lanes = NULL;
}

/* ---- the whole ---- */

static json_t *describe_device(const fnl_device_info *info) {
    char api[32];
    snprintf(api, sizeof api, "%u.%u", info->api_version_major, info->api_version_minor);
    return json_pack("{s:s,s:s,s:s,s:s,s:I}", "name", info->name, "driver", info->driver, "type",
                     fnl_value_name(FNL_ENUM_DEVICE_TYPE, info->type), "vulkan", api, "memory_bytes", (json_int_t)info->memory_bytes);
}

static json_t *describe_settings(const struct bench_run *run) {
    const struct bench_settings *s = run->settings;
    const char *camera = run->plan->case_count && run->plan->cases[0].camera ? run->plan->cases[0].camera : "";
    json_t *settings = json_pack("{s:I,s:I,s:I,s:s,s:s,s:o,s:o,s:o}", "frames", (json_int_t)s->frames, "warm_up", (json_int_t)s->warm_up,
                     "checks", (json_int_t)s->checks, "reference", fnl_value_name(FNL_ENUM_LISTS, s->reference), "camera", camera,
                     "camera_path", json_text(s->camera_path ? s->camera_path : ""), "variant", json_text(s->variant ? s->variant : ""),
                     "environment", json_text(s->environment ? s->environment : ""));
    if (s->stereo) json_object_set_new(settings, "stereo", json_text(s->hmd ? s->hmd : "camera"));
    return settings;
}

/* Numbers of different devices or settings must not stand side by side. */
static bool agrees(const json_t *root, const char *part, const json_t *now) {
    const json_t *before = json_object_get(root, part);
    const char *key;
    json_t *value;
    bool good = true;
    json_object_foreach((json_t *)now, key, value) {
        const json_t *old = json_object_get(before, key);
        if (json_equal(old, value)) continue;
        char *a = old ? json_text_write(old, JSON_ENCODE_ANY) : NULL, *b = json_text_write(value, JSON_ENCODE_ANY);
        fprintf(stderr, "fanal: error: --resume: %s %s was %s, now it is %s\n", part, key, a ? a : "unknown", b ? b : "?");
        free(a);
        free(b);
        good = false;
    }
    return good;
}

static bool begin_data(struct bench_run *run) {
    json_t *root = run->data->root, *device = describe_device(&run->info), *settings = describe_settings(run);
    char program[64], date[64];
    time_t now = time(NULL);
    struct tm utc;
    snprintf(program, sizeof program, "fanal %s", fnl_version());
    strftime(date, sizeof date, "%Y-%m-%d %H:%M UTC", gmtime_r(&now, &utc));
    json_t *version = json_pack("{s:s,s:s}", "version", program, "commit", program_commit);
    bool good = json_object_size(root) == 0 || (json_object_get(root, "results") && agrees(root, "device", device) &&
                                                agrees(root, "settings", settings) && agrees(root, "program", version));
    if (good) {
        json_object_set_new(root, "format", json_integer(FORMAT_VERSION));
        json_object_set(root, "program", version);
        json_object_set_new(root, "command", json_text(run->settings->command));
        json_object_set_new(root, "machine", bench_machine());
        json_object_set_new(root, "date", json_string(date));
        json_object_set(root, "device", device);
        json_object_set(root, "settings", settings);
        json_object_set(root, "skipped", run->plan->skipped);
        json_object_set_new(root, "likely", json_boolean(run->plan->likely));
        if (!json_object_get(root, "results")) json_object_set_new(root, "results", json_array());
    }
    json_decref(version);
    json_decref(device);
    json_decref(settings);
    return good;
}

bool bench_create_device(const struct bench_settings *settings, const fnl_host *host, fnl_device **out) {
    fnl_device_params params = fnl_device_params_default();
    if (host) params.host = *host;
    params.validate = settings->validate;
    if (settings->no_cache) params.cache_folder = "";
    argument_device(settings->device, &params);
    return fnl_device_create(&params, out) == FNL_OK;
}

static bool create_device(struct bench_run *run) {
    return bench_create_device(run->settings, &run->host, &run->device) &&
           fnl_device_query_info(run->device, &run->info) == FNL_OK;
}

enum bench_end bench_measure(const struct bench_settings *settings, const struct bench_plan *plan, struct bench_data *data) {
    struct bench_run run = {.settings = settings, .plan = plan, .data = data, .host = fnl_host_default()};
    run.host.user = &run.sink;
    run.host.log = receive_log;
    enum bench_end end = BENCH_REFUSED;
    const struct stereo_options eyes = {STEREO_LAYERS, settings->hmd, NAN};
    if ((!settings->stereo || stereo_open(&eyes, settings->quiet, &run.stereo)) && create_device(&run) && begin_data(&run)) {
        if (!settings->resume) bench_drop_page(settings->output);
        progress_begin(settings->quiet, PROGRESS_SECONDS);
        for (run.case_index = 0; run.case_index < plan->case_count && !stopped(&run); run.case_index++)
            run_case(&run, &plan->cases[run.case_index]);
        progress_end();
        end = run.failed ? BENCH_FAILED : interrupt_seen() ? BENCH_INTERRUPTED : BENCH_DONE;
        if (settings->validate && fnl_device_validation_count(run.device)) {
            fprintf(stderr, "fanal: error: Vulkan validation sent %llu messages\n",
                    (unsigned long long)fnl_device_validation_count(run.device));
            end = BENCH_FAILED;
        }
    }
    bench_path_destroy(&run.path);
    stereo_close(&run.stereo);
    fnl_device_destroy(&run.device);
    fnl_scene_destroy(&run.scene);
    return end;
}
