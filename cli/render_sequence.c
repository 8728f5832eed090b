/* SPDX-License-Identifier: MIT */
/* The pictures of a sequence, in which the animation goes on and the camera follows a path. */
#include "bench.h" /* camera paths */
#include "interrupt.h"
#include "output.h"
#include "print.h"
#include "progress.h"
#include "render.h"
#include "stream.h"
#include "supersample.h"
#include "trace_file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool render_is_sequence(const char *path) {
    const char *percent, *field, *second;
    int width;
    field = output_next_field(path, &percent, &width);
    return field && *field == 'd' && field - percent <= 3 && !output_next_field(field, &second, &width);
}

bool render_makes_sequence(const struct render_options *o) {
    bool sequence = o->camera_path || (o->has_format && o->format >= RENDER_RAW);
    const char *percent;
    int width;
    for (int i = 0; i < o->output_count && !o->views && o->stereo.kind != STEREO_LAYERS; i++)
        sequence = sequence || output_next_field(o->outputs[i], &percent, &width);
    return sequence;
}

/* Written by hand, as the format is the user's. */
void render_number_path(const char *pattern, uint32_t index, char *out, size_t capacity) {
    const char *percent, *field;
    int width;
    if ((field = output_next_field(pattern, &percent, &width)))
        snprintf(out, capacity, "%.*s%0*u%s", (int)(percent - pattern), pattern, width, index, field + 1);
    else
        snprintf(out, capacity, "%s", pattern);
}

/* Pictures that show something of earlier ones: how many of those are rendered first when a sequence begins in the middle. */
static uint32_t earlier_pictures(const fnl_frame *frame) {
    if (frame->aa == FNL_ANTIALIASING_TAA) return 16;
    if (frame->shading == FNL_SHADING_VIRTUAL_TEXTURING) return 2;
    return frame->outputs & FNL_OUTPUT_MOTION || frame->debug == FNL_DEBUG_MOTION;
}

struct sequence {
    const struct render_options *o;
    fnl_camera eyes[HEADSET_EYES];
    fnl_vec3 gaze;
    const fnl_host *host;
    fnl_scene *scene;
    fnl_renderer *renderer, *linear; /* the second: of what is not the picture, where both are wanted; or NULL */
    fnl_frame frame;
    fnl_frame_stats stats;
    struct trace_history *trace;
    struct bench_path path;
    uint32_t end;
    double time; /* of the animation */
};

/* The scene and the camera of picture `index`. */
static bool pose(struct sequence *s, uint32_t index) {
    const struct render_options *o = s->o;
    const struct bench_point *point = &s->path.points[index % s->path.count];
    uint32_t ignored;
    bool file_time = o->camera_path && !bench_path_is_circle(o->camera_path, &ignored) && !o->has_frame_time;
    s->time = o->world.time + (file_time ? point->time : index * o->frame_time);
    if (!bench_path_camera(&s->path, s->scene, index, &s->frame.camera)) return false;
    if (o->world.fov > 0) s->frame.camera.vertical_fov = o->world.fov;
    if (o->eyes && !stereo_cameras(o->eyes, &s->frame.camera, s->time, s->frame.width, s->frame.height, s->eyes)) return false;
    if (o->eyes) s->frame.gaze = stereo_gaze(o->eyes, &s->frame.camera, s->time, &s->gaze);
    return world_set_time(&o->world, s->scene, s->time);
}

static bool render_linear(struct sequence *s, struct supersample *mean) {
    fnl_frame frame = s->frame;
    fnl_frame_stats stats;
    frame.outputs = render_linear_outputs(s->o);
    if (s->o->supersample > 1) {
        struct supersample radiance = {0};
        const bool good = supersample_render(&radiance, s->linear, &frame, s->o->supersample);
        supersample_join(mean, &radiance);
        return good;
    }
    if (fnl_renderer_render(s->linear, &frame) != FNL_OK || fnl_renderer_query_stats(s->linear, &stats) != FNL_OK) return false;
    return earlier_pictures(&frame) > 0 || render_settle_pools(s->linear, &frame, &stats);
}

static bool render_picture(struct sequence *s, struct supersample *mean) {
    const double called = trace_now();
    trace_mark(s->trace, "render");
    if (s->o->supersample > 1 ? !supersample_render(mean, s->renderer, &s->frame, s->o->supersample)
                              : fnl_renderer_render(s->renderer, &s->frame) != FNL_OK)
        return false;
    trace_mark(s->trace, "wait for the frame");
    if (fnl_renderer_query_stats(s->renderer, &s->stats) != FNL_OK) return false;
    trace_end_frame(s->trace, s->o->supersample > 1 ? NULL : &s->stats, called);
    if (earlier_pictures(&s->frame) > 0) return true; /* rendered again it would show no motion */
    return s->o->supersample > 1 || render_settle_pools(s->renderer, &s->frame, &s->stats);
}

/* The exposure of picture 0, which has just been rendered, is that of the others: a turntable whose background comes and goes would flicker. */
static void keep_exposure(struct sequence *s) {
    if (s->frame.exposure != FNL_EXPOSURE_AUTO || s->o->has_exposure) return;
    s->frame.exposure = FNL_EXPOSURE_EV;
    s->frame.ev = s->stats.ev;
}

static bool render(struct sequence *s, struct supersample *mean) { return render_picture(s, mean) && (!s->linear || render_linear(s, mean)); }

static bool save(struct sequence *s, uint32_t index, const struct supersample *mean) {
    char paths[RENDER_MAX_OUTPUTS][4096];
    struct render_options single = *s->o;
    for (int k = 0; k < single.output_count; k++) {
        if (render_is_stdout(single.outputs[k])) continue;
        render_number_path(single.outputs[k], index, paths[k], sizeof paths[k]);
        single.outputs[k] = paths[k];
    }
    return render_save_outputs(&single, s->host, s->renderer, s->linear, mean, 0);
}

/* One line for each picture: as they come to stdout, all together at the end to a file. */
static bool note(const struct sequence *s, uint32_t index, struct render_report *report, FILE *lines) {
    if (!lines) return true;
    report->picture = index;
    report->time = s->time;
    report->frame = s->frame;
    report->stats = s->stats;
    report->frame_count = 1;
    char *text = report_note(report, 0, &s->stats) ? report_text(report, true) : NULL;
    bool good = text && (render_is_stdout(s->o->stats) ? stream_write(text, strlen(text)) : fputs(text, lines) >= 0); /* own text */
    if (!text) fputs("fanal: error: --stats: memory ran out\n", stderr);
    free(text);
    report_finish(report);
    return good;
}

static bool run(struct sequence *s, struct render_report *report, FILE *lines) {
    const struct render_options *o = s->o;
    const uint32_t first = o->start_frame, earlier = earlier_pictures(&s->frame), begin = first < earlier ? 0 : first - earlier;
    struct supersample mean = {0};
    if (begin > 0 && s->frame.exposure == FNL_EXPOSURE_AUTO && !o->has_exposure) {
        const bool good = pose(s, 0) && render(s, &mean);
        supersample_free(&mean);
        if (!good) return false;
        keep_exposure(s);
    }
    for (uint32_t i = begin; i < s->end; i++) {
        report->interrupted = interrupt_seen();
        if (report->interrupted) return true;
        progress_show("rendering", i < first ? 0 : i - first, s->end - first);
        trace_mark(s->trace, "pose");
        bool good = pose(s, i) && render(s, &mean) && (i < first || (save(s, i, &mean) && note(s, i, report, lines)));
        supersample_free(&mean);
        if (!good) return false;
        if (i == 0) keep_exposure(s);
        report->picture_count += i >= first;
    }
    return true;
}

bool render_sequence(const struct render_options *o, const fnl_host *host, fnl_scene *scene, fnl_renderer *renderer, fnl_renderer *linear,
                     const fnl_frame *frame, struct render_report *report, struct trace_history *trace) {
    struct sequence s = {.o = o, .host = host, .scene = scene, .renderer = renderer, .linear = linear, .frame = *frame, .trace = trace};
    if (o->eyes) s.frame.views = s.eyes;
    s.frame.pin_choice = true;
    char *text = NULL;
    size_t length;
    if (!bench_path_create(&s.path, o->camera_path, scene, &frame->camera, o->frame_count,
                           (float)frame->width / (float)frame->height))
        return false;
    s.end = o->has_frames || !o->camera_path ? o->frame_count : s.path.count;
    FILE *lines = o->stats ? open_memstream(&text, &length) : NULL;
    bool good = (!o->stats || lines) && (o->start_frame < s.end);
    if (o->start_frame >= s.end)
        fprintf(stderr, "fanal: error: --start-frame: the sequence has no picture %u; it ends after %u\n", o->start_frame, s.end - 1);
    interrupt_catch(true);
    good = good && run(&s, report, lines);
    interrupt_catch(false);
    report->stats = s.stats;
    if (lines && fclose(lines) != 0) good = false;
    if (good && lines && report->picture_count > 0 && !render_is_stdout(o->stats)) good = output_save(o->stats, text, length);
    free(text);
    bench_path_destroy(&s.path);
    return good;
}
