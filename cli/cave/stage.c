/* SPDX-License-Identifier: MIT */
/* Devices and renderers of one process. */
#include "cave/cave.h"

#include "arguments.h"
#include "counters.h"
#include "json_text.h"
#include "views.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { TAA_FRAMES = 16 };

/* A renderer, for the walls of one size on one device: their views are those of one frame. */
struct group {
    uint32_t device;               /* place in the stage */
    uint32_t views[CAVE_VIEWS], view_count; /* indices of the whole list */
    fnl_frame frame;
    fnl_camera cameras[CAVE_VIEWS];
    fnl_renderer *renderer, *linear; /* the second: of render_linear_outputs(), or NULL */
    fnl_image images[RENDER_PICTURES];
    fnl_result read;
    double cpu, gpu, wait, copy; /* milliseconds */
    uint64_t copied, draws;
};

struct stage_device {
    uint32_t number; /* in the file's list */
    fnl_device *device;
    fnl_device_info info;
};

struct cave_stage {
    const struct cave_options *options;
    const struct cave_displays *displays;
    const struct cave_view *views;
    fnl_host host;
    fnl_scene *scene;
    uint32_t rank, device_count, group_count;
    bool has_rendered;
    struct stage_device devices[CAVE_DEVICES];
    struct group groups[CAVE_VIEWS];
};

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

/* ---- life ---- */

static bool add_device(struct cave_stage *s, uint32_t number, uint32_t *out) {
    for (*out = 0; *out < s->device_count; ++*out)
        if (s->devices[*out].number == number) return true;
    struct stage_device *d = &s->devices[s->device_count++];
    fnl_device_params params = fnl_device_params_default();
    params.host = s->host;
    params.validate = s->options->render.validate;
    if (s->options->render.no_cache) params.cache_folder = "";
    argument_device(s->displays->device_count ? s->displays->devices[number] : s->options->render.device, &params);
    d->number = number;
    return fnl_device_create(&params, &d->device) == FNL_OK && fnl_device_query_info(d->device, &d->info) == FNL_OK;
}

static bool add_view(struct cave_stage *s, uint32_t index) {
    const struct cave_view *view = &s->views[index];
    uint32_t device, g = 0;
    if (!add_device(s, view->device, &device)) return false;
    while (g < s->group_count && (s->groups[g].device != device || s->groups[g].frame.width != view->width || s->groups[g].frame.height != view->height)) g++;
    struct group *group = &s->groups[g];
    if (g == s->group_count) {
        fnl_scene_info scene;
        s->group_count++;
        *group = (struct group){.device = device, .frame = s->options->render.frame};
        group->frame.width = view->width;
        group->frame.height = view->height;
        const bool both = render_linear_outputs(&s->options->render) != 0;
        group->frame.outputs = both ? FNL_OUTPUT_COLOR : render_wanted_outputs(&s->options->render);
        group->frame.pin_choice = true;
        if (s->options->render.lit_casts) {
            if (fnl_scene_query_info(s->scene, &scene) != FNL_OK) return false;
            group->frame.shadows = world_usual_shadows(&scene, &s->devices[device].info, s->options->render.quiet || g > 0);
        }
        if (fnl_renderer_create(s->devices[device].device, s->scene, &group->renderer) != FNL_OK) return false;
        if (both && fnl_renderer_create(s->devices[device].device, s->scene, &group->linear) != FNL_OK) return false;
    }
    group->views[group->view_count++] = index;
    return true;
}

bool cave_stage_create(const struct cave_options *options, const struct cave_displays *displays, const fnl_host *host, fnl_scene *scene,
                       const struct cave_view *views, uint32_t view_count, uint32_t rank, struct cave_stage **out) {
    struct cave_stage *s = *out = calloc(1, sizeof *s);
    if (!s) return false;
    s->options = options;
    s->displays = displays;
    s->views = views;
    s->host = *host;
    s->scene = scene;
    s->rank = rank;
    for (uint32_t i = 0; i < view_count; i++)
        if (views[i].rank == rank && !add_view(s, i)) return false;
    return true;
}

void cave_stage_destroy(struct cave_stage **handle) {
    struct cave_stage *s = *handle;
    if (!s) return;
    for (uint32_t g = 0; g < s->group_count; g++) {
        for (int i = 0; i < RENDER_PICTURES; i++) fnl_image_free(&s->host, &s->groups[g].images[i]);
        fnl_renderer_destroy(&s->groups[g].renderer);
        fnl_renderer_destroy(&s->groups[g].linear);
    }
    for (uint32_t i = 0; i < s->device_count; i++) fnl_device_destroy(&s->devices[i].device);
    free(s);
    *handle = NULL;
}

/* ---- a frame ---- */

bool cave_stage_meter(struct cave_stage *s, const struct cave_place *place, const struct cave_moment *m, double *out_ev) {
    enum { SIDE = 64 };
    fnl_camera from = fnl_camera_default(), cube[FNL_VIEWS_MAX];
    const struct cave_vector head = cave_placed(place, m->head.position);
    fnl_frame_stats stats;
    fnl_frame frame = s->groups[0].frame;
    fnl_renderer *renderer;
    from.position = (fnl_vec3){(float)head.x, (float)head.y, (float)head.z};
    from.near_distance = (float)(s->displays->near_distance * place->scale);
    if (!world_set_time(&s->options->render.world, s->scene, m->animation_time) || !views_choose("cube", s->scene, &from, cube, &frame.view_count)) return false;
    frame.views = cube;
    frame.width = frame.height = SIDE;
    frame.outputs = FNL_OUTPUT_COLOR;
    if (fnl_renderer_create(s->devices[s->groups[0].device].device, s->scene, &renderer) != FNL_OK) return false;
    const bool good = fnl_renderer_render(renderer, &frame) == FNL_OK && fnl_renderer_query_stats(renderer, &stats) == FNL_OK;
    *out_ev = 0;
    for (uint32_t i = 0; good && i < stats.view_count; i++) *out_ev += (double)stats.views[i].ev / stats.view_count;
    fnl_renderer_destroy(&renderer);
    return good;
}

static fnl_frame linear_frame(const struct cave_stage *s, const struct group *g) {
    fnl_frame frame = g->frame;
    frame.outputs = render_linear_outputs(&s->options->render);
    return frame;
}

/* Starts a frame; it is over when query_stats() or read() return. */
static bool submit(struct cave_stage *s, struct group *g, const struct cave_place *place, const struct cave_moment *m, const fnl_camera *viewer) {
    for (uint32_t i = 0; i < g->view_count; i++)
        if (!cave_view_camera(s->displays, place, m, &s->views[g->views[i]], &g->cameras[i])) return false;
    g->frame.views = g->cameras;
    g->frame.viewer = viewer;
    g->frame.view_count = g->view_count;
    if (g->frame.exposure == FNL_EXPOSURE_AUTO) g->frame.exposure = FNL_EXPOSURE_EV; /* metered by wall it would show at the edges */
    if (g->frame.exposure == FNL_EXPOSURE_EV) g->frame.ev = (float)m->ev;
    const fnl_frame linear = linear_frame(s, g);
    return fnl_renderer_render(g->renderer, &g->frame) == FNL_OK && (!g->linear || fnl_renderer_render(g->linear, &linear) == FNL_OK);
}

/* Pools that were too small are only slow, not wrong, but for what renders an approximation then: as `fanal render` does it. */
static bool await_frame(fnl_renderer *renderer, const fnl_frame *frame, fnl_frame_stats *stats) {
    const bool moves = frame->aa == FNL_ANTIALIASING_TAA || frame->outputs & FNL_OUTPUT_MOTION;
    return fnl_renderer_query_stats(renderer, stats) == FNL_OK && (moves || render_settle_pools(renderer, frame, stats));
}

static bool await(const struct cave_stage *s, struct group *g) {
    fnl_frame_stats stats;
    const double begun = now();
    const fnl_frame linear = linear_frame(s, g);
    if (g->linear && !await_frame(g->linear, &linear, &stats)) return false;
    if (!await_frame(g->renderer, &g->frame, &stats)) return false; /* the numbers are those of the picture */
    g->wait = now() - begun;
    g->cpu = stats.cpu_milliseconds;
    g->gpu = stats.gpu_milliseconds;
    g->draws = stats.draws;
    for (uint32_t i = 1; i < stats.view_count; i++) g->draws += stats.views[i].draws;
    return true;
}

/* What a device has rendered, to the host's memory. The scene is not touched, so that devices do it at the same time. */
struct reading {
    struct cave_stage *stage;
    uint32_t device;
};
static void *read_device(void *context) {
    const struct reading *reading = context;
    struct cave_stage *s = reading->stage;
    const uint32_t outputs = render_wanted_outputs(&s->options->render);
    for (uint32_t i = 0; i < s->group_count; i++) {
        struct group *g = &s->groups[i];
        if (g->device != reading->device) continue;
        const double begun = now();
        g->copied = 0;
        g->read = FNL_OK;
        for (uint32_t p = 0; p < RENDER_PICTURES; p++) {
            fnl_image_free(&s->host, &g->images[p]);
            if (outputs >> p & 1 && g->read == FNL_OK) g->read = fnl_renderer_read(g->linear && p > 0 ? g->linear : g->renderer, (fnl_output)(1u << p), &g->images[p]);
            if (g->images[p].pixels) g->copied += (uint64_t)g->images[p].width * g->images[p].height * fnl_pixel_size(g->images[p].format);
        }
        g->copy = now() - begun;
    }
    return NULL;
}

static bool read_all(struct cave_stage *s) {
    struct reading readings[CAVE_DEVICES];
    pthread_t threads[CAVE_DEVICES];
    bool started[CAVE_DEVICES] = {false}, good = true;
    for (uint32_t i = 0; i < s->device_count; i++) {
        readings[i] = (struct reading){s, i};
        started[i] = i > 0 && pthread_create(&threads[i], NULL, read_device, &readings[i]) == 0;
    }
    for (uint32_t i = 0; i < s->device_count; i++) {
        if (started[i])
            pthread_join(threads[i], NULL);
        else
            read_device(&readings[i]);
    }
    for (uint32_t g = 0; g < s->group_count; g++) good = good && s->groups[g].read == FNL_OK;
    return good;
}

/* The head, which sees 90 degrees: all walls, devices and ranks show the levels of detail that suit it, as those of each wall would break at the edges. */
static fnl_camera viewer_at(const struct cave_place *place, const struct cave_moment *m) {
    fnl_camera viewer = fnl_camera_default();
    const struct cave_vector at = cave_placed(place, m->head.position), ahead = cave_rotate(place->pose.rotation, (struct cave_vector){0, 0, -1});
    viewer.position = (fnl_vec3){(float)at.x, (float)at.y, (float)at.z};
    const struct cave_vector target = cave_add_scaled(at, ahead, 1 + cave_length(at));
    viewer.target = (fnl_vec3){(float)target.x, (float)target.y, (float)target.z};
    const struct cave_vector up = cave_rotate(place->pose.rotation, (struct cave_vector){0, 1, 0});
    viewer.up = (fnl_vec3){(float)up.x, (float)up.y, (float)up.z};
    viewer.vertical_fov = 1.57079632679489662f;
    return viewer;
}

bool cave_stage_render(struct cave_stage *s, const struct cave_place *place, const struct cave_moment *m) {
    bool good = world_set_time(&s->options->render.world, s->scene, m->animation_time);
    const fnl_camera viewer = viewer_at(place, m);
    /* Temporal antialiasing begins with a picture that is collected from several frames, as that of `fanal render` is. */
    const uint32_t times = !s->has_rendered && s->options->render.frame.aa == FNL_ANTIALIASING_TAA ? TAA_FRAMES : 1;
    for (uint32_t i = 0; i < times; i++)
        for (uint32_t g = 0; g < s->group_count && good; g++) good = submit(s, &s->groups[g], place, m, &viewer);
    s->has_rendered = true;
    for (uint32_t g = 0; g < s->group_count && good; g++) good = await(s, &s->groups[g]);
    return good && read_all(s);
}

bool cave_stage_picture(const struct cave_stage *s, uint32_t view, uint32_t output, fnl_image *out) {
    for (uint32_t i = 0; i < s->group_count; i++) {
        const struct group *g = &s->groups[i];
        for (uint32_t v = 0; v < g->view_count; v++) {
            if (g->views[v] != view || !g->images[output].pixels) continue;
            *out = g->images[output];
            out->height = g->frame.height;
            out->pixels = (char *)out->pixels + v * (size_t)out->width * out->height * fnl_pixel_size(out->format);
            return true;
        }
    }
    return false;
}

/* ---- numbers ---- */

json_t *cave_stage_report(const struct cave_stage *s) {
    json_t *all = json_array();
    for (uint32_t i = 0; i < s->group_count; i++) {
        const struct group *g = &s->groups[i];
        json_t *views = json_array();
        for (uint32_t v = 0; v < g->view_count; v++) {
            char name[2 * CAVE_NAME];
            cave_view_name(s->displays, &s->views[g->views[v]], name, sizeof name);
            json_array_append_new(views, json_text(name));
        }
        json_array_append_new(all, json_pack("{s:i,s:i,s:s,s:i,s:i,s:o,s:I,s:f,s:f,s:f,s:f,s:I}", "rank", (int)s->rank, "device", (int)s->devices[g->device].number, "name", s->devices[g->device].info.name, "width",
                                             (int)g->frame.width, "height", (int)g->frame.height, "views", views, "draws", (json_int_t)g->draws, "cpu_ms", g->cpu, "gpu_ms",
                                             g->gpu, "wait_ms", g->wait, "copy_ms", g->copy, "copy_bytes", (json_int_t)g->copied));
    }
    return all;
}

uint64_t cave_stage_messages(const struct cave_stage *s) {
    uint64_t count = 0;
    for (uint32_t i = 0; i < s->device_count; i++) count += fnl_device_validation_count(s->devices[i].device);
    return count;
}
