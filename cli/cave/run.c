/* SPDX-License-Identifier: MIT */
/* One run: every process of it does this. */
#include "cave/ranks.h"

#include "cave/hash.h"
#include "input.h"
#include "json_text.h"
#include "loading.h"
#include "origin.h"
#include "output.h"
#include "print.h"
#include "program.h"
#include "progress.h"
#include "stream.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum { EXIT_INTERRUPTED = 130 };

struct run {
    const struct cave_options *o;
    const struct cave_displays *d;
    fnl_host host;
    struct cave_ranks ranks;
    struct cave_view views[CAVE_VIEWS];
    uint32_t view_count;
    fnl_scene *scene;
    struct cave_stage *stage;
    struct cave_place place;
    double ev;
    json_t *frames;
    double copied; /* milliseconds of all frames */
};

/* ---- what ranks compare ---- */

static uint64_t hash_file(const char *path, uint64_t hash) {
    char buffer[65536];
    const char *problem; /* loading tells of it */
    FILE *file = input_try(path, UINT64_MAX, &problem);
    for (size_t got; file && (got = fread(buffer, 1, sizeof buffer, file)) > 0;) hash = cave_hash(buffer, got, hash);
    if (file) fclose(file);
    return hash;
}

static struct cave_greeting greet(const struct run *run) {
    struct cave_greeting g = {.program = CAVE_HASH_SEED, .displays = run->d->hash, .settings = run->o->hash, .scene = CAVE_HASH_SEED};
    const char *source = run->o->render.world.scene;
    g.program = cave_hash(fnl_version(), strlen(fnl_version()), g.program);
    g.program = cave_hash(program_commit, strlen(program_commit), g.program);
    if (loading_is_builtin(source)) g.scene = cave_hash(source, strlen(source), g.scene);
    for (uint32_t i = 0; run->scene && (source = fnl_scene_source(run->scene, i)); i++) g.scene = hash_file(source, g.scene);
    return g;
}

/* ---- the start ---- */

/* Before the first picture: a wall that cannot be seen in the last one would end the run there. */
static bool check_track(const struct run *run) {
    const uint32_t first = run->o->render.start_frame;
    for (uint32_t frame = first; frame < run->o->render.frame_count; frame++) {
        const struct cave_moment m = cave_predict(run->o, run->d, frame, 0);
        fnl_camera camera;
        for (uint32_t v = 0; v < run->view_count; v++)
            if (!cave_view_camera(run->d, &run->place, &m, &run->views[v], &camera)) return false;
    }
    return true;
}

/* Of what this process writes. */
static bool check_outputs(const struct run *run) {
    const struct render_options *o = &run->o->render;
    bool good = true;
    for (int i = 0; i < o->output_count && good && (run->ranks.rank == 0 || !run->o->gather); i++) good = output_check_pattern(o->outputs[i]);
    return good && (run->ranks.rank > 0 || !o->stats || render_is_stdout(o->stats) || output_check(o->stats));
}

/* A drill that cannot happen would look as if it had been passed. */
static bool check_fault(const struct run *run) {
    const struct cave_fault *fault = &run->o->fault;
    const uint32_t first = run->o->render.start_frame, end = run->o->render.frame_count, ranks = run->ranks.transport ? run->ranks.count : 1;
    if (fault->kind == CAVE_FAULT_NONE || (fault->rank < ranks && fault->frame >= first && fault->frame < end)) return true;
    if (run->ranks.rank > 0) return false;
    if (fault->rank >= ranks) fprintf(stderr, "fanal: error: --fault: there is no rank %u; there %s %u, from 0\n", fault->rank, ranks == 1 ? "is" : "are", ranks);
    else fprintf(stderr, "fanal: error: --fault: there is no frame %llu; there are %u to %u\n", (unsigned long long)fault->frame, first, end - 1);
    return false;
}

/* A place in file coordinates becomes one that is relative to the scene's origin, which moves there. */
static bool come_near(fnl_scene *scene, struct cave_place *place) {
    const double at[3] = {place->pose.position.x, place->pose.position.y, place->pose.position.z};
    double origin[3];
    if (!origin_follow(scene, at) || fnl_scene_query_origin(scene, origin) != FNL_OK) return false;
    place->pose.position = (struct cave_vector){at[0] - origin[0], at[1] - origin[1], at[2] - origin[2]};
    return true;
}

static bool prepare(struct run *run, double *ev, bool *meters) {
    const struct cave_options *o = run->o;
    fnl_camera camera;
    const struct cave_moment first = cave_predict(o, run->d, o->render.start_frame, 0);
    run->view_count = cave_list_views(o, run->d, run->ranks.transport ? run->ranks.count : 0, run->views);
    if (run->view_count == 0 || !check_fault(run) || !check_outputs(run)) return false;
    progress_show("loading the scene", 0, 0);
    if (!world_load(&o->render.world, &run->host, run->views[0].width, run->views[0].height, o->render.quiet || run->ranks.rank > 0, &run->scene, &camera)) return false;
    run->place = cave_find_place(run->d, &first, &camera, o->places_by_camera);
    if (run->d->has_origin && !o->places_by_camera && !come_near(run->scene, &run->place)) return false;
    if (run->ranks.rank == 0 && !check_track(run)) return false;
    if (!cave_stage_create(o, run->d, &run->host, run->scene, run->views, run->view_count, run->ranks.rank, &run->stage)) return false;
    *meters = o->render.frame.exposure == FNL_EXPOSURE_AUTO && run->views[0].rank == run->ranks.rank;
    if (*meters) progress_show("metering", 0, 0);
    return !*meters || cave_stage_meter(run->stage, &run->place, &first, ev);
}

/* ---- pictures ---- */

/* Of all that this process writes. With --gather rank 0 writes those of others too. */
static void remove_pictures(const struct run *run, uint64_t frame) {
    const struct render_options *o = &run->o->render;
    char path[4096];
    for (uint32_t v = 0; v < run->view_count; v++)
        for (int i = 0; i < o->output_count; i++) {
            if (run->views[v].rank != run->ranks.rank && !(run->o->gather && run->ranks.rank == 0)) continue;
            cave_path(o->outputs[i], run->d, &run->views[v], frame, path, sizeof path);
            unlink(path);
        }
}

static bool save_view(const struct run *run, uint32_t v, uint64_t frame, const struct render_pictures *pictures) {
    struct render_options o = run->o->render;
    char path[4096];
    o.frame.width = run->views[v].width;
    o.frame.height = run->views[v].height;
    for (int i = 0; i < o.output_count; i++) {
        cave_path(run->o->render.outputs[i], run->d, &run->views[v], frame, path, sizeof path);
        if (!render_save_picture(&o, &run->host, path, pictures)) return false;
    }
    return true;
}

/* What a rank sends before the pixels of each picture. */
static bool pass_on(struct run *run, const struct render_pictures *pictures) {
    for (uint32_t p = 0; p < RENDER_PICTURES; p++) {
        const fnl_image *image = &pictures->images[p];
        if (image->pixels && !cave_ranks_send(&run->ranks, image->pixels, (size_t)image->width * image->height * fnl_pixel_size(image->format))) return false;
    }
    return true;
}

/* Takes the pictures of another rank's view in any case, so that what it says next is found; with `keeps` writes them. */
static bool save_of_other(struct run *run, uint32_t v, uint64_t frame, bool keeps) {
    const uint32_t outputs = render_wanted_outputs(&run->o->render);
    struct render_pictures pictures = {0};
    bool good = true;
    for (uint32_t p = 0; p < RENDER_PICTURES && good; p++) {
        if (!(outputs >> p & 1)) continue;
        const fnl_pixel_format format = p == 0 ? FNL_PIXEL_FORMAT_RGBA8 : FNL_PIXEL_FORMAT_RGBA32F;
        const size_t size = (size_t)run->views[v].width * run->views[v].height * fnl_pixel_size(format);
        pictures.images[p] = (fnl_image){run->views[v].width, run->views[v].height, format, malloc(size)};
        good = pictures.images[p].pixels && cave_ranks_receive(&run->ranks, run->views[v].rank, pictures.images[p].pixels, size);
    }
    good = good && keeps && save_view(run, v, frame, &pictures);
    for (uint32_t p = 0; p < RENDER_PICTURES; p++) free(pictures.images[p].pixels);
    return good;
}

static bool save(struct run *run, uint64_t frame) {
    const bool gather = run->o->gather && run->ranks.transport;
    bool good = true;
    if (run->o->render.output_count == 0) return true;
    for (uint32_t v = 0; v < run->view_count && run->ranks.state == CAVE_RANKS_RUN; v++) {
        struct render_pictures pictures = {0};
        if (run->views[v].rank != run->ranks.rank) {
            if (gather && run->ranks.rank == 0) good = save_of_other(run, v, frame, good) && good;
            continue;
        }
        for (uint32_t p = 0; p < RENDER_PICTURES; p++) (void)cave_stage_picture(run->stage, v, p, &pictures.images[p]);
        if (gather && run->ranks.rank > 0)
            good = pass_on(run, &pictures) && good;
        else
            good = good && save_view(run, v, frame, &pictures);
    }
    return good;
}

/* ---- frames ---- */

/* What goes wrong on purpose. */
static void drill(const struct run *run, struct cave_moment *m) {
    const struct cave_fault *fault = &run->o->fault;
    if (fault->kind == CAVE_FAULT_NONE || fault->rank != run->ranks.rank || fault->frame != m->frame) return;
    const double whole = (double)(time_t)fault->seconds;
    if (fault->kind == CAVE_FAULT_LATE) nanosleep(&(struct timespec){(time_t)fault->seconds, (long)((fault->seconds - whole) * 1e9)}, NULL);
    if (fault->kind == CAVE_FAULT_LOST) raise(SIGKILL);
    if (fault->kind == CAVE_FAULT_POSE) m->head.position.x += 0.01;
}

static json_t *vector_json(struct cave_vector v) { return json_pack("[f,f,f]", v.x, v.y, v.z); }

static void note_frame(struct run *run, const struct cave_moment *m, json_t *renderers) {
    const struct cave_quaternion q = m->head.rotation;
    char hash[24];
    json_t *ranks = json_array();
    size_t i;
    json_t *one;
    json_array_foreach(renderers, i, one) run->copied += json_real_value(json_object_get(one, "copy_ms"));
    snprintf(hash, sizeof hash, "%016llx", (unsigned long long)cave_moment_hash(m));
    for (uint32_t r = 0; r < run->ranks.count; r++) json_array_append_new(ranks, json_real(run->ranks.milliseconds[r]));
    json_array_append_new(run->frames, json_pack("{s:I,s:f,s:f,s:{s:o,s:[f,f,f,f]},s:s,s:o,s:f,s:o}", "frame", (json_int_t)m->frame, "time", m->display_time, "animation_time",
                                                 m->animation_time, "head", "position", vector_json(m->head.position), "rotation", q.x, q.y, q.z, q.w, "pose_hash", hash,
                                                 "rank_ms", ranks, "swap_wait_ms", run->ranks.waited, "renderers", renderers));
}

static bool run_frame(struct run *run, struct cave_moment *m) {
    json_t *renderers = json_array();
    drill(run, m);
    bool good = cave_stage_render(run->stage, &run->place, m);
    if (good && run->o->render.validate && cave_stage_messages(run->stage)) {
        fprintf(stderr, "fanal: error: Vulkan validation sent %llu messages\n", (unsigned long long)cave_stage_messages(run->stage));
        good = false;
    }
    good = cave_ranks_swap(&run->ranks, good, m, cave_stage_report(run->stage), renderers);
    if (good) {
        good = cave_ranks_settle(&run->ranks, save(run, m->frame));
        if (!good) remove_pictures(run, m->frame); /* all walls or none */
    }
    if (good && run->ranks.rank == 0)
        note_frame(run, m, renderers);
    else
        json_decref(renderers);
    return good;
}

static bool run_frames(struct run *run) {
    const uint32_t first = run->o->render.start_frame, end = run->o->render.frame_count;
    for (uint32_t frame = first;; frame++) {
        const struct cave_moment own = cave_predict(run->o, run->d, frame, run->ev);
        struct cave_moment m;
        if (run->ranks.rank == 0) progress_show("rendering", frame - first, end - first);
        if (!cave_ranks_begin(&run->ranks, frame < end ? &own : NULL, &m)) return run->ranks.state == CAVE_RANKS_OVER;
        if (!run_frame(run, &m)) return false;
    }
}

/* ---- numbers ---- */

static char *stats_text(struct run *run) {
    json_t *walls = json_array();
    for (uint32_t v = 0; v < run->view_count; v++) {
        const struct cave_view *view = &run->views[v];
        json_array_append_new(walls, json_pack("{s:o,s:s,s:i,s:i,s:i,s:i}", "wall", json_text(run->d->walls[view->wall].name), "eye", cave_eye_name(view->eye), "width", (int)view->width,
                                               "height", (int)view->height, "rank", (int)view->rank, "device", (int)view->device));
    }
    const struct cave_quaternion q = run->place.pose.rotation;
    double at[3] = {0, 0, 0};
    (void)fnl_scene_query_origin(run->scene, at);
    at[0] += run->place.pose.position.x;
    at[1] += run->place.pose.position.y;
    at[2] += run->place.pose.position.z;
    json_t *json = json_pack("{s:i,s:{s:s,s:s},s:o,s:o,s:i,s:f,s:{s:o,s:[f,f,f,f],s:f},s:o,s:O}", "version", 1, "program", "version", fnl_version(), "commit",
                             program_commit, "scene", json_text(run->o->render.world.scene), "displays", json_text(run->d->source), "ranks", (int)run->ranks.count, "ev", run->ev, "origin", "position",
                             vector_json((struct cave_vector){at[0], at[1], at[2]}), "rotation", q.x, q.y, q.z, q.w, "scale", run->place.scale, "views", walls, "frames", run->frames);
    char *text = json ? json_text_write(json, JSON_INDENT(2) | JSON_REAL_PRECISION(9)) : NULL, *ended = NULL;
    if (text && asprintf(&ended, "%s\n", text) < 0) ended = NULL;
    free(text);
    json_decref(json);
    return ended;
}

static bool save_stats(struct run *run) {
    const char *path = run->o->render.stats;
    char *text = stats_text(run);
    if (!text) fputs("fanal: error: --stats: memory ran out\n", stderr);
    const bool good = text && (render_is_stdout(path) ? stream_write(text, strlen(text)) : output_save(path, text, strlen(text)));
    free(text);
    return good;
}

static void print_summary(const struct run *run) {
    const uint32_t frames = run->o->render.frame_count - run->o->render.start_frame;
    printf("%u wall%s, %u view%s, %u rank%s, %u frame%s; EV100 %.2f; %.2f ms a frame to copy pictures from devices; %.1f s\n", run->d->wall_count,
           run->d->wall_count == 1 ? "" : "s", run->view_count, run->view_count == 1 ? "" : "s", run->ranks.count, run->ranks.count == 1 ? "" : "s", frames,
           frames == 1 ? "" : "s", run->ev, run->copied / frames, progress_seconds());
}

/* Names as they were given: ranks may write theirs on other machines. */
static void print_wrote(const struct run *run) {
    const struct render_options *o = &run->o->render;
    const uint32_t count = run->view_count * (o->frame_count - o->start_frame);
    for (int i = 0; i < o->output_count; i++) printf("wrote %s: %u picture%s\n", o->outputs[i], count, count == 1 ? "" : "s");
    if (o->stats && !render_is_stdout(o->stats)) printf("wrote %s\n", o->stats);
}

int cave_run(const struct cave_options *o, const struct cave_displays *d) {
    struct run *run = calloc(1, sizeof *run);
    if (!run) return 2;
    *run = (struct run){.o = o, .d = d, .host = fnl_host_default(), .ev = (double)o->render.frame.ev, .frames = json_array()};
    bool good = cave_ranks_join(&run->ranks, o->timeout, o->render.quiet);
    if (good) {
        if (run->ranks.rank == 0 && o->render.stats && render_is_stdout(o->render.stats)) good = stream_open();
        progress_begin(o->render.quiet || run->ranks.rank > 0, PROGRESS_SECONDS);
        bool meters = false;
        double metered = 0;
        good = good && prepare(run, &metered, &meters);
        struct cave_greeting greeting = greet(run);
        greeting.good = good;
        greeting.has_ev = meters;
        greeting.ev = metered;
        good = cave_ranks_greet(&run->ranks, &greeting, &run->ev) && run_frames(run);
        progress_end();
        if (good && run->ranks.rank == 0) {
            if (!o->render.quiet) print_summary(run);
            good = output_flush() && (!o->render.stats || save_stats(run));
            if (good && !o->render.quiet) print_wrote(run);
        }
        cave_ranks_leave(&run->ranks);
    }
    const bool interrupted = run->ranks.state == CAVE_RANKS_INTERRUPTED;
    cave_stage_destroy(&run->stage);
    fnl_scene_destroy(&run->scene);
    json_decref(run->frames);
    free(run);
    return good ? 0 : interrupted ? EXIT_INTERRUPTED : 2;
}
