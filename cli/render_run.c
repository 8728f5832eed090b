/* SPDX-License-Identifier: MIT */
#include "render.h"

#include "arguments.h"
#include "counters.h"
#include "output.h"
#include "pixel.h"
#include "print.h"
#include "progress.h"
#include "stream.h"
#include "supersample.h"
#include "trace_file.h"
#include "views.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <strings.h>
#include <unistd.h>

enum { EXIT_INTERRUPTED = 130 };

/* ---- device ---- */

static void choose_device(const struct render_options *o, fnl_device_params *params) {
    params->validate = o->validate;
    if (o->no_cache) params->cache_folder = "";
    argument_device(o->device, params);
}

/* ---- outputs ---- */

bool render_has_extension(const char *path, const char *extension) {
    const char *dot = strrchr(path, '.');
    return dot && strcasecmp(dot + 1, extension) == 0;
}

bool render_is_stdout(const char *path) { return strcmp(path, "-") == 0; }

enum render_format render_format_of(const struct render_options *o, const char *path) {
    if (render_is_stdout(path)) return o->has_format ? o->format : render_makes_sequence(o) ? RENDER_Y4M : RENDER_PNG;
    return render_has_extension(path, "png") ? RENDER_PNG : RENDER_EXR;
}

const char *render_format_name(int format) {
    static const char *const names[] = {"png", "exr", "raw", "y4m", "y4m444"};
    return format >= 0 && format <= RENDER_Y4M444 ? names[format] : NULL;
}

const char *render_plan_name(int plan) { return plan == RENDER_PLAN_TEXT ? "text" : plan == RENDER_PLAN_JSON ? "json" : NULL; }

const char *render_aov_name(int aov) {
    static const char *const names[] = {"depth", "normal", "albedo", "roughness", "id", "position", "motion", "object"};
    return aov >= 0 && aov < RENDER_AOV_COUNT ? names[aov] : NULL;
}

uint32_t render_wanted_outputs(const struct render_options *o) {
    uint32_t outputs = o->output_count ? 0 : FNL_OUTPUT_COLOR; /* numbers alone still need the whole frame */
    for (int i = 0; i < o->output_count; i++)
        outputs |= render_format_of(o, o->outputs[i]) == RENDER_EXR ? FNL_OUTPUT_RADIANCE : FNL_OUTPUT_COLOR;
    if (o->aovs & (1u << RENDER_AOV_ALBEDO | 1u << RENDER_AOV_ROUGHNESS)) outputs |= FNL_OUTPUT_SURFACE;
    if (o->aovs & (1u << RENDER_AOV_DEPTH | 1u << RENDER_AOV_NORMAL)) outputs |= FNL_OUTPUT_NORMAL;
    if (o->aovs & (1u << RENDER_AOV_ID | 1u << RENDER_AOV_POSITION)) outputs |= FNL_OUTPUT_POSITION;
    if (o->aovs & 1u << RENDER_AOV_MOTION) outputs |= FNL_OUTPUT_MOTION;
    if (o->aovs & 1u << RENDER_AOV_OBJECT) outputs |= FNL_OUTPUT_OBJECT;
    return outputs;
}

uint32_t render_linear_outputs(const struct render_options *o) {
    const uint32_t wanted = render_wanted_outputs(o);
    return wanted & FNL_OUTPUT_COLOR && wanted & FNL_OUTPUT_RADIANCE ? wanted & ~(uint32_t)FNL_OUTPUT_COLOR : 0;
}

static bool save_exr(const struct render_options *o, const fnl_host *host, const char *path, const struct render_pictures *p) {
    static const struct {
        const char *name;
        int aov, picture, component;
    } layout[] = {{"R", -1, 1, 0},
                  {"G", -1, 1, 1},
                  {"B", -1, 1, 2},
                  {"A", -1, 1, 3},
                  {"depth.Z", RENDER_AOV_DEPTH, 3, 3},
                  {"normal.X", RENDER_AOV_NORMAL, 3, 0},
                  {"normal.Y", RENDER_AOV_NORMAL, 3, 1},
                  {"normal.Z", RENDER_AOV_NORMAL, 3, 2},
                  {"albedo.R", RENDER_AOV_ALBEDO, 2, 0},
                  {"albedo.G", RENDER_AOV_ALBEDO, 2, 1},
                  {"albedo.B", RENDER_AOV_ALBEDO, 2, 2},
                  {"roughness.Y", RENDER_AOV_ROUGHNESS, 2, 3},
                  {"id.Y", RENDER_AOV_ID, 4, 3},
                  {"position.X", RENDER_AOV_POSITION, 4, 0},
                  {"position.Y", RENDER_AOV_POSITION, 4, 1},
                  {"position.Z", RENDER_AOV_POSITION, 4, 2},
                  {"motion.X", RENDER_AOV_MOTION, 5, 0},
                  {"motion.Y", RENDER_AOV_MOTION, 5, 1},
                  {"object.instance", RENDER_AOV_OBJECT, 6, 0},
                  {"object.primitive", RENDER_AOV_OBJECT, 6, 1},
                  {"object.material", RENDER_AOV_OBJECT, 6, 2},
                  {"object.triangle", RENDER_AOV_OBJECT, 6, 3}};
    fnl_exr_channel channels[sizeof layout / sizeof *layout];
    uint32_t count = 0;
    for (size_t i = 0; i < sizeof layout / sizeof *layout; i++)
        if (layout[i].aov < 0 || (o->aovs & 1u << layout[i].aov))
            channels[count++] = (fnl_exr_channel){
                layout[i].name, (const float *)p->images[layout[i].picture].pixels + layout[i].component, 4};
    return fnl_exr_save(host, path, p->images[1].width, p->images[1].height, channels, count) == FNL_OK;
}

bool render_save_picture(const struct render_options *o, const fnl_host *host, const char *path, const struct render_pictures *p) {
    return render_has_extension(path, "png") ? fnl_image_save(host, path, &p->images[0]) == FNL_OK
                                             : save_exr(o, host, path, p);
}

/* PNG and EXR are written to a file in a folder of its own, which is then copied: their writers want a file. */
static bool save_stdout(const struct render_options *o, const fnl_host *host, const struct render_pictures *p) {
    enum render_format format = render_format_of(o, "-");
    if (format == RENDER_RAW) return stream_raw(&p->images[0]);
    if (format >= RENDER_Y4M) return stream_y4m(&p->images[0], format == RENDER_Y4M ? Y4M_420 : Y4M_444, o->frame_time);
    char folder[PATH_MAX], path[PATH_MAX + 16];
    if (!output_make_folder(folder)) return false;
    snprintf(path, sizeof path, "%s/picture.%s", folder, render_format_name(format));
    bool good = render_save_picture(o, host, path, p) && stream_file(path);
    unlink(path);
    rmdir(folder);
    return good;
}

/* What a pattern without a field names: each "%%" is a percent sign. */
static const char *whole_path(const char *pattern, char path[4096]) {
    output_append(path, 0, 4096, pattern, strlen(pattern));
    return path;
}

static const char *numbered_path(const char *pattern, uint32_t number, char path[4096]) {
    char numbered[4096];
    render_number_path(pattern, number, numbered, sizeof numbered);
    return whole_path(numbered, path);
}

/* File `index` of a run: those of the first view, then those of the next. */
static const char *file_path(const struct render_options *o, uint32_t index, uint32_t view_count, char path[4096]) {
    const char *pattern = o->outputs[index % (uint32_t)o->output_count];
    return view_count ? numbered_path(pattern, index / (uint32_t)o->output_count, path) : whole_path(pattern, path);
}

static void remove_files(const struct render_options *o, uint32_t count, uint32_t view_count) {
    char path[4096];
    for (uint32_t i = 0; i < count; i++) {
        const char *file = file_path(o, i, view_count, path);
        if (!render_is_stdout(file)) unlink(file);
    }
}

static void print_wrote(const char *path) {
    if (path && !render_is_stdout(path)) printf("wrote %s\n", path);
}

/* FIRST to LAST of a pattern's numbers, or the one path. */
static void print_pictures(const char *pattern, uint32_t first, uint32_t end) {
    char low[4096], high[4096];
    if (end == 0) print_wrote(whole_path(pattern, low));
    else if (end - first == 1 || render_is_stdout(pattern)) print_wrote(numbered_path(pattern, first, low));
    else printf("wrote %s to %s\n", numbered_path(pattern, first, low), numbered_path(pattern, end - 1, high));
}

void render_print_wrote(const struct render_options *o, uint32_t first, uint32_t end) {
    for (int i = 0; i < o->output_count; i++) print_pictures(o->outputs[i], first, end);
    print_wrote(o->stats);
    print_wrote(o->trace_file);
    print_wrote(o->save_scene);
}

/* The pictures of one view, which stay where they are. */
static struct render_pictures pictures_of(const struct render_pictures *all, uint32_t height, uint32_t view) {
    struct render_pictures own = *all;
    for (int i = 0; i < RENDER_PICTURES; i++) {
        fnl_image *image = &own.images[i];
        if (!image->pixels) continue;
        image->height = height;
        image->pixels = (char *)image->pixels + view * (size_t)image->width * height * fnl_pixel_size(image->format);
    }
    return own;
}

bool render_save_outputs(const struct render_options *o, const fnl_host *host, fnl_renderer *renderer, fnl_renderer *linear,
                         const struct supersample *mean, uint32_t view_count) {
    struct render_pictures p = {0};
    uint32_t outputs = render_wanted_outputs(o);
    bool good = true;
    for (int i = 0; i < RENDER_PICTURES && good; i++)
        if (outputs & 1u << i) good = fnl_renderer_read(linear && i > 0 ? linear : renderer, (fnl_output)(1 << i), &p.images[i]) == FNL_OK;
    for (int i = 0; i < 2 && good && mean->count; i++)
        if (p.images[i].pixels) supersample_store(mean, &p.images[i]);
    if (good && o->screen && o->display.given) good = display_show(o->screen, host, &p.images[0]);
    for (int i = o->display.given; i < RENDER_PICTURES && good && stereo_joins(o->stereo.kind); i++) good = stereo_join(o->stereo.kind, i < 2, &p.images[i]);
    uint32_t written = 0, total = (uint32_t)o->output_count * (view_count ? view_count : 1);
    for (; written < total && good; written++) {
        char numbered[4096];
        const char *path = file_path(o, written, view_count, numbered);
        struct render_pictures own = view_count ? pictures_of(&p, o->frame.height, written / (uint32_t)o->output_count) : p;
        good = render_is_stdout(path) ? save_stdout(o, host, &own) : render_save_picture(o, host, path, &own);
    }
    if (!good && written > 0) remove_files(o, written - 1, view_count); /* all or nothing: the last one counted was not written */
    for (int i = 0; i < RENDER_PICTURES; i++) fnl_image_free(host, &p.images[i]);
    return good;
}

/* ---- frames ---- */

/* Lets auto decide before anything is timed, but not for long; a single frame takes what is remembered or likely. */
static bool settle_choice(const struct render_options *o, fnl_renderer *renderer, fnl_frame *frame) {
    double start = trace_now();
    if (frame->shading != FNL_SHADING_AUTO && frame->lists != FNL_LISTS_AUTO) return true;
    fnl_frame_stats stats = {.choosing = true};
    fnl_frame trial = *frame;
    trial.outputs &= FNL_OUTPUT_COLOR | FNL_OUTPUT_RADIANCE;
    trial.pixel.asked = false;
    uint32_t count = 0;
    for (; o->frame_count > 1 && stats.choosing && trace_now() < start + o->choose_seconds; count++) {
        progress_show("choosing", count, 60);
        if (fnl_renderer_render(renderer, &trial) != FNL_OK || fnl_renderer_query_stats(renderer, &stats) != FNL_OK)
            return false;
        /* Frames would only take time from the making of pipelines. */
        if (stats.pipelines_pending) nanosleep(&(struct timespec){.tv_nsec = 50000000}, NULL);
    }
    frame->pin_choice = true;
    if (o->frame_count > 1 && stats.choosing && !o->quiet)
        fprintf(
            stderr,
            "fanal: warning: auto has not decided within %g s (%u frames, pipelines to be made yet: %u): it takes "
            "the best that it knows. Run it again to go on from there, raise --choose-seconds, or name %s\n",
            o->choose_seconds, count, stats.pipelines_pending, frame->lists == FNL_LISTS_AUTO ? "--lists" : "--shading");
    return true;
}

bool render_settle_pools(fnl_renderer *renderer, const fnl_frame *frame, fnl_frame_stats *stats) {
    uint64_t before = UINT64_MAX;
    for (uint64_t now; (now = counters_overflow(stats)) > 0 && now < before; before = now) /* until memory allows no more */
        if (fnl_renderer_render(renderer, frame) != FNL_OK || fnl_renderer_query_stats(renderer, stats) != FNL_OK)
            return false;
    return true;
}

enum { TAA_FRAMES = 16 }; /* that a picture is collected from, unless --frames says so */

/* The picture alone: no frame more than it takes. */
static bool run_picture(const struct render_options *o, fnl_renderer *renderer, fnl_frame frame, struct render_report *report) {
    uint32_t count = frame.aa == FNL_ANTIALIASING_TAA ? TAA_FRAMES : 1;
    if (!settle_choice(o, renderer, &frame)) return false;
    for (uint32_t i = 0; i < count; i++) {
        progress_show("rendering", i, count);
        if (fnl_renderer_render(renderer, &frame) != FNL_OK || fnl_renderer_query_stats(renderer, &report->stats) != FNL_OK)
            return false;
    }
    return render_settle_pools(renderer, &frame, &report->stats);
}

/*
 * One frame to warm up and the timed ones; then, where numbers are wanted, one more that counts light evaluations, which is also the one that is
 * saved; with samples another, since Mesa's CPU driver tests depth after cutouts whose shader counts, and takes other centroids then.
 */
static bool run_frames(const struct render_options *o, fnl_renderer *renderer, fnl_frame frame, struct render_report *report,
                       struct trace_history *trace) {
    report->frame_count = o->frame_count;
    if (o->frame_count == 0) return run_picture(o, renderer, frame, report);
    if (!settle_choice(o, renderer, &frame)) return false;
    bool counts = o->stats || !o->quiet;
    uint32_t collected = frame.aa == FNL_ANTIALIASING_TAA && !o->has_frames ? TAA_FRAMES - 1 : 0;
    uint32_t warm_up = counts + collected, total = o->frame_count + warm_up + counts + (counts && frame.msaa != 1);
    fnl_frame timed = frame;
    if (counts) timed.outputs &= FNL_OUTPUT_COLOR | FNL_OUTPUT_RADIANCE;
    if (counts) timed.pixel.asked = false;
    for (uint32_t i = 0; i < o->frame_count + warm_up; i++) {
        progress_show("rendering", i, total);
        const double called = trace_now();
        trace_mark(trace, "render");
        if (fnl_renderer_render(renderer, counts ? &timed : &frame) != FNL_OK) return false;
        trace_mark(trace, "wait for the frame");
        if (fnl_renderer_query_stats(renderer, &report->stats) != FNL_OK) return false;
        trace_end_frame(trace, i >= warm_up ? &report->stats : NULL, called);
        if (i >= warm_up && !report_note(report, i - warm_up, &report->stats)) return false;
    }
    if (counts) {
        progress_show("rendering", o->frame_count + warm_up, total);
        frame.count_lights = true;
        frame.timers = false;
        if (fnl_renderer_render(renderer, &frame) != FNL_OK || fnl_renderer_query_stats(renderer, &report->stats) != FNL_OK)
            return false;
    }
    if (!render_settle_pools(renderer, &frame, &report->stats)) return false;
    if (counts && frame.msaa != 1) {
        fnl_frame_stats plain;
        progress_show("rendering", total - 1, total);
        frame.count_lights = false;
        if (fnl_renderer_render(renderer, &frame) != FNL_OK || fnl_renderer_query_stats(renderer, &plain) != FNL_OK)
            return false;
    }
    return true;
}

/* The frames of `linear`: as those of an .exr without a picture beside it. */
static bool run_linear(const struct render_options *o, fnl_renderer *linear, fnl_frame frame, struct supersample *mean) {
    struct render_report unused = {.options = o};
    struct supersample radiance = {0};
    frame.outputs = render_linear_outputs(o);
    frame.pixel.asked = false;
    bool good = run_frames(o, linear, frame, &unused, NULL);
    frame.pin_choice = true;
    if (good && o->supersample > 1) good = supersample_render(&radiance, linear, &frame, o->supersample);
    supersample_join(mean, &radiance);
    report_finish(&unused);
    return good;
}

static void print_text(const fnl_renderer *renderer, fnl_print what) {
    size_t length = fnl_renderer_print(renderer, what, NULL, 0);
    char *text = malloc(length + 1);
    if (!text) return;
    fnl_renderer_print(renderer, what, text, length + 1);
    fputs(text, stdout); /* own text */
    free(text);
}

static bool takes_stdout(const struct render_options *o) {
    bool takes = o->stats && render_is_stdout(o->stats);
    for (int i = 0; i < o->output_count; i++) takes = takes || render_is_stdout(o->outputs[i]);
    return takes;
}

/* The work before the first frame, under names of its own. */
static bool warm_up(fnl_renderer *renderer, const fnl_frame *frame) {
    progress_show("uploading the scene", 0, 0);
    if (fnl_renderer_warm(renderer, frame, NULL, false, NULL) != FNL_OK) return false;
    progress_show("compiling pipelines", 0, 0);
    return fnl_renderer_warm(renderer, frame, NULL, true, NULL) == FNL_OK;
}

bool render_shows_nothing(const struct render_options *o) { return o->output_count == 0 && !o->stats && !o->plan && !o->traffic && !o->trace_file && !o->frame.pixel.asked; }

/* Each of several frames has its part of a pixel's textures. Pages of virtual ones are filled at levels of their own. */
static bool sharpen(const struct render_options *o, fnl_scene *scene) {
    const bool pages = o->frame.shading == FNL_SHADING_VIRTUAL_TEXTURING;
    return o->supersample <= 1 || pages || fnl_scene_set_texture_bias(scene, -0.5f * log2f((float)o->supersample)) == FNL_OK;
}

/* Without a device, where nothing is rendered. */
static bool load_and_save(const struct render_options *o, const fnl_host *host, fnl_scene **scene, fnl_camera *camera) {
    return world_load(&o->world, host, o->frame.width, o->frame.height, o->quiet, scene, camera) &&
           (!o->save_scene || fnl_scene_save(*scene, o->save_scene, NULL) == FNL_OK);
}

static bool save_stats(const struct render_options *o, const struct render_report *report) {
    char *text = report_text(report, false);
    if (!text) fputs("fanal: error: --stats: memory ran out\n", stderr);
    bool good = text && (render_is_stdout(o->stats) ? stream_write(text, strlen(text)) : output_save(o->stats, text, strlen(text)));
    free(text);
    return good;
}

/* Of the last frame; the lights are copied, as the renderer keeps them only until the next call. */
static bool query_pixel(fnl_renderer *renderer, struct render_report *report) {
    if (fnl_renderer_query_pixel(renderer, &report->pixel) != FNL_OK) return false;
    if (report->pixel.light_count) memcpy(report->pixel_lights, report->pixel.lights, report->pixel.light_count * sizeof *report->pixel_lights);
    report->pixel.lights = report->pixel_lights;
    return true;
}

/* Before anything is rendered; the display of a headset, whose size is not known yet, is left to stream_y4m(). */
static bool check_video(const struct render_options *o) {
    for (int i = 0; i < o->output_count && !o->display.given; i++)
        if (render_format_of(o, o->outputs[i]) == RENDER_Y4M && !y4m_check_size(o->frame.width, o->frame.height, Y4M_420)) return false;
    return true;
}

static int run(const struct render_options *o) {
    fnl_host host = fnl_host_default();
    fnl_scene *scene = NULL;
    fnl_device *device = NULL;
    fnl_renderer *renderer = NULL, *linear = NULL;
    struct render_report report = {.options = o, .time = o->world.time, .picture = UINT32_MAX};
    fnl_frame frame = o->frame;
    const bool both = render_linear_outputs(o) != 0;
    frame.outputs = both ? FNL_OUTPUT_COLOR : render_wanted_outputs(o);
    fnl_device_params device_params = fnl_device_params_default();
    choose_device(o, &device_params);
    if (!check_video(o) || (takes_stdout(o) && !stream_open())) return 2;
    progress_begin(o->quiet, PROGRESS_SECONDS);
    progress_show("loading the scene", 0, 0);
    if (render_shows_nothing(o)) {
        const bool saved = load_and_save(o, &host, &scene, &frame.camera);
        progress_end();
        fnl_scene_destroy(&scene);
        if (saved && !o->quiet) render_print_wrote(o, 0, 0);
        return saved ? 0 : 2;
    }
    bool sequence = render_makes_sequence(o);
    fnl_camera cameras[FNL_VIEWS_MAX];
    fnl_vec3 gaze;
    uint32_t view_count = 0;
    bool good = load_and_save(o, &host, &scene, &frame.camera) && sharpen(o, scene) &&
                (!o->views || views_choose(o->views, scene, &frame.camera, cameras, &view_count)) &&
                (!o->eyes || stereo_cameras(o->eyes, &frame.camera, o->world.time, frame.width, frame.height, cameras)) && fnl_device_create(&device_params, &device) == FNL_OK &&
                fnl_renderer_create(device, scene, &renderer) == FNL_OK && (!both || fnl_renderer_create(device, scene, &linear) == FNL_OK) &&
                fnl_device_query_info(device, &report.device) == FNL_OK && fnl_scene_query_info(scene, &report.scene) == FNL_OK;
    if (good && o->screen) good = display_open(o->screen, &o->display, o->eyes, device, frame.width, frame.height);
    if (good && o->screen) frame.hidden_areas = display_hidden(o->screen);
    if (good && o->lit_casts) frame.shadows = world_usual_shadows(&report.scene, &report.device, o->quiet);
    if (view_count > 0) frame.camera = cameras[0];
    if (o->eyes) view_count = stereo_view_count(o->eyes), frame.gaze = stereo_gaze(o->eyes, &frame.camera, o->world.time, &gaze);
    if (o->eyes && !render_was_given(o, "stereo.eyes")) frame.stereo.eyes = view_count > 1 ? view_count : 0;
    frame.views = cameras;
    frame.view_count = view_count;
    if (o->eyes && o->stereo.kind != STEREO_LAYERS) view_count = 0; /* of the files */
    struct supersample mean = {0};
    struct trace_history *trace = good && o->trace_file ? trace_create() : NULL;
    if (good && o->trace_file && !trace) {
        fputs("fanal: error: --trace-file: memory ran out\n", stderr);
        good = false;
    }
    /* A single picture ends before auto can measure anything, so the pipelines of its other candidates are not compiled. */
    if (!sequence && o->frame_count <= 1) frame.pin_choice = true;
    if (good) good = warm_up(renderer, &frame);
    if (good && sequence) good = render_sequence(o, &host, scene, renderer, linear, &frame, &report, trace);
    if (good && !sequence) good = run_frames(o, renderer, frame, &report, trace);
    if (good && !sequence && o->supersample > 1) {
        frame.pin_choice = true;
        good = supersample_render(&mean, renderer, &frame, o->supersample);
    }
    if (good && !sequence && linear) good = run_linear(o, linear, frame, &mean);
    report.frame = frame;
    report.shown = scene;
    if (good && frame.pixel.asked) good = query_pixel(renderer, &report);
    if (good && o->validate && fnl_device_validation_count(device)) {
        fprintf(stderr, "fanal: error: Vulkan validation sent %llu messages\n",
                (unsigned long long)fnl_device_validation_count(device));
        good = false;
    }
    if (good && o->plan) print_text(renderer, o->plan == RENDER_PLAN_JSON ? FNL_PRINT_PLAN_JSON : FNL_PRINT_PLAN);
    if (good && o->traffic) print_text(renderer, FNL_PRINT_TRAFFIC);
    progress_end();
    const bool table = good && !o->quiet && !o->plan && !o->traffic;
    if (table && sequence) report_print_sequence(&report, report.picture_count, progress_seconds());
    if (table && !sequence && o->frame_count == 0) report_print_picture(&report, progress_seconds());
    if (table && !sequence && o->frame_count > 0) report_print(&report);
    if (table && frame.pixel.asked) putchar('\n');
    if (good && frame.pixel.asked) pixel_print(scene, &report.pixel);
    good = good && output_flush(); /* before anything is written: all or nothing */
    const uint32_t first = sequence ? o->start_frame : 0, end = sequence ? first + report.picture_count : view_count;
    if (good && o->output_count && !sequence) good = render_save_outputs(o, &host, renderer, linear, &mean, view_count);
    supersample_free(&mean);
    const bool traced = good && trace && trace_save(trace, o->trace_file), failed = good && trace && !traced;
    if (failed || (good && o->stats && !sequence && !save_stats(o, &report))) {
        if (!sequence) remove_files(o, (uint32_t)o->output_count * (view_count ? view_count : 1), view_count); /* all or nothing */
        if (traced) unlink(o->trace_file);
        good = false;
    }
    if (good && !o->quiet && (!sequence || end > first)) render_print_wrote(o, first, end);
    if (good && report.interrupted)
        fprintf(stderr, "fanal: interrupted: continue with --start-frame %u%s\n", end, o->stats && !render_is_stdout(o->stats) ? " and another --stats file" : "");
    trace_destroy(&trace);
    report_finish(&report);
    if (o->screen) display_close(o->screen);
    fnl_renderer_destroy(&linear);
    fnl_renderer_destroy(&renderer);
    fnl_device_destroy(&device);
    fnl_scene_destroy(&scene);
    return !good ? 2 : report.interrupted ? EXIT_INTERRUPTED : 0;
}

int render_run(const struct render_options *options) {
    struct render_options o = *options;
    struct stereo stereo;
    if (!o.stereo.kind) return run(&o);
    if (!stereo_open(&o.stereo, o.quiet, &stereo)) return 2;
    if (!o.has_size) stereo_size(&stereo, &o.frame.width, &o.frame.height);
    o.eyes = &stereo;
    struct display display = {0};
    if (o.stereo.hmd) o.screen = &display;
    const int status = run(&o);
    stereo_close(&stereo);
    return status;
}
