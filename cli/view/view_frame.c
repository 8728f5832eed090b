/* SPDX-License-Identifier: MIT */
/* Frames of the window, pictures that are saved, and the scene that is shown. */
#include "view/view.h"

#include "print.h"
#include "render.h"
#include "view/ui.h"

#include "fanal/vulkan.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* ---- messages ---- */

void view_take_message(void *user, fnl_log_level level, const char *line) {
    struct view_messages *m = user;
    if (level >= FNL_LOG_WARNING) fprintf(stderr, "fanal: %s: %s\n", level == FNL_LOG_ERROR ? "error" : "warning", line);
    if (level < FNL_LOG_INFO) return;
    pthread_mutex_lock(&m->mutex);
    m->lines[m->count % VIEW_MESSAGES].level = level;
    snprintf(m->lines[m->count % VIEW_MESSAGES].text, sizeof m->lines->text, "%s", line);
    m->count++;
    pthread_mutex_unlock(&m->mutex);
}

void view_say(struct view *v, fnl_log_level level, const char *text) { view_take_message(&v->messages, level, text); }

/* ---- the scene ---- */

/* Where the user chose none, those that the scene should have: a scene without lights has none, until it gets one. */
void view_choose_shadows(struct view *v) {
    const fnl_shadows usual = world_usual_shadows(&v->shown.info, &v->device.info, true);
    if (!v->own_shadows) v->frame.shadows = v->usual.shadows = usual;
    if (!v->compare.own_shadows) v->compare.frame.shadows = usual;
}

struct ui_rectangle view_area(const struct view *v) {
    const struct ui_rectangle whole = {0, 0, (float)v->width, (float)v->height};
    return v->hides_panels || v->area.width < 16 || v->area.height < 16 ? whole : v->area;
}

fnl_camera view_fitted_camera(const fnl_camera *camera, struct ui_rectangle area, float width, float height) {
    fnl_camera fitted = *camera;
    if (area.x == 0 && area.y == 0 && area.width == width && area.height == height) return fitted;
    const float part = area.height / height;
    fitted.vertical_fov = 2 * atanf(tanf(camera->vertical_fov / 2) / part);
    fitted.vertical_extent = camera->vertical_extent / part;
    fitted.shift.x = camera->shift.x * area.width / width + (2 * area.x + area.width) / width - 1;
    fitted.shift.y = camera->shift.y * part + 1 - (2 * area.y + area.height) / height;
    return fitted;
}

fnl_frame view_whole_frame(const struct view *v) {
    fnl_frame frame = v->frame;
    frame.width = v->width;
    frame.height = v->height;
    frame.camera = view_fitted_camera(&v->camera.now, view_area(v), (float)v->width, (float)v->height);
    frame.outputs = FNL_OUTPUT_COLOR;
    return frame;
}

/* The new scene takes the place of the old one; where it cannot, the old one stays. */
void view_show(struct view *v, struct view_scene *scene) {
    if (!scene->scene) return;
    pthread_mutex_lock(&v->device.mutex);
    view_compare_leave(v);
    view_scene_free(&v->shown);
    v->screen.is_drawing = false;
    v->stats = (fnl_frame_stats){0}; /* what it points to was the old renderer's */
    pthread_mutex_unlock(&v->device.mutex);
    v->shown = *scene;
    v->camera.now = scene->camera;
    const struct world_options *w = &v->world;
    v->framed_aspect = 0;
    if (scene->source && fnl_scene_count(scene->scene, FNL_ENTITY_CAMERA) == 0 && !w->has_eye && w->fov == 0 && w->near == 0 && w->up.x == 0 && w->up.y == 0 && w->up.z == 0) {
        v->framed = scene->camera;
        v->framed_aspect = view_area(v).width / fmaxf(view_area(v).height, 1);
    }
    const fnl_vec3 low = scene->info.bounds_low, high = scene->info.bounds_high; /* of nothing: infinite */
    const float size = fmaxf(high.x - low.x, fmaxf(high.y - low.y, high.z - low.z));
    v->camera.size = size > 1e-3f && size < 1e6f ? size : 1;
    v->animation = 0;
    v->time = v->world.time;
    v->pick.known = v->pick.asked = v->pick.clicked = false;
    v->variant[0] = 0;
    v->surroundings.changed = false;
    v->surroundings.none = !scene->info.has_environment;
    v->surroundings.params = fnl_environment_params_default();
    v->surroundings.source[0] = 0;
    if (scene->info.has_environment && fnl_scene_query_environment(scene->scene, &v->surroundings.params) == FNL_OK && v->surroundings.params.source)
        snprintf(v->surroundings.source, sizeof v->surroundings.source, "%s", v->surroundings.params.source);
    v->surroundings.params.source = NULL;
    if (scene->source) view_settings_note_scene(&v->settings, scene->source);
    view_select_reset(v);
    view_choose_shadows(v);
    v->good = v->frame;
    v->compare.good = v->compare.frame;
    view_watch_loaded(v);
    char title[300];
    snprintf(title, sizeof title, "%.200s%sFanal", scene->source ? scene->source : "", scene->source ? " - " : "");
    if (v->window) view_window_set_title(v->window, title);
    v->arriving = scene->source ? 2 : 0;
    if (v->swapchain) v->part = fminf(v->part, 0.375f); /* something soon, then finer */
    v->moving = true;
    view_want(v, v->swapchain ? 1 : 2);
}

bool view_ends_with(const char *text, const char *end) {
    const size_t a = strlen(text), b = strlen(end);
    return a >= b && strcasecmp(text + a - b, end) == 0;
}

bool view_is_asked_for(const struct view *v, const char *source) { return v->asked_for[0] && source && strcmp(v->asked_for, source) == 0; }

bool view_load(struct view *v, const char *source) {
    struct view_loader *l = &v->loader;
    fnl_swapchain_info info = {0};
    v->opened = view_now();
    view_watch_loading(v);
    view_loader_stop(l);
    if (v->swapchain) fnl_swapchain_query_info(v->swapchain, &info);
    l->device = &v->device;
    l->world = v->world;
    if (!view_is_asked_for(v, source)) l->world.lights = -1; /* a saved scene has them already */
    l->host = v->host;
    l->frame = view_whole_frame(v);
    l->frame.width = l->frame.width ? l->frame.width : 1;
    l->frame.height = l->frame.height ? l->frame.height : 1;
    l->width = view_area(v).width;
    l->height = view_area(v).height;
    l->own_shadows = v->own_shadows;
    l->format = v->screen.device ? 0 : (uint32_t)info.format;
    const bool good = view_loader_start(l, source);
    if (!good) view_say(v, FNL_LOG_ERROR, "memory ran out");
    return good;
}

void view_open(struct view *v, const char *source) {
    if (v->shown.scene && (view_ends_with(source, ".hdr") || view_ends_with(source, ".exr") || strcmp(source, "builtin:studio") == 0)) {
        snprintf(v->surroundings.source, sizeof v->surroundings.source, "%s", source);
        v->surroundings.none = false;
        view_apply_surroundings(v);
        return;
    }
    v->files.again = false;
    v->files.blend_with = UINT32_MAX;
    view_load(v, source);
    view_want(v, 1);
}

void view_apply_surroundings(struct view *v) {
    struct view_surroundings *s = &v->surroundings;
    fnl_environment_params params = s->params;
    params.source = s->source[0] ? s->source : NULL;
    params.max_memory = v->world.loading.max_memory;
    /* On errors, which the log tells, the scene keeps what it had. */
    if (fnl_scene_set_environment(v->shown.scene, s->none ? NULL : &params) == FNL_OK) {
        s->changed = true;
        fnl_scene_query_info(v->shown.scene, &v->shown.info);
        view_choose_shadows(v);
        view_watch_begin(v);
    }
    view_want(v, 2);
}

void view_apply_settings(struct view *v) {
    fnl_swapchain_params params = fnl_swapchain_params_default();
    params.width = v->width;
    params.height = v->height;
    params.present = (fnl_present)v->settings.present;
    params.color = (fnl_color_space)v->settings.color;
    if (v->swapchain) fnl_swapchain_set(v->swapchain, &params);
    ui_set_look(v->scale, v->settings.dark);
    if (!view_screen_adapt(v)) v->quit = true;
    view_want(v, 2);
}

void view_frame_all(struct view *v) {
    const fnl_camera before = v->camera.now;
    const struct ui_rectangle area = view_area(v);
    if (!v->shown.scene || area.height < 1 || area.width < 1) return;
    v->framed_aspect = area.width / area.height;
    if (fnl_scene_query_framing_camera(v->shown.scene, v->framed_aspect, &v->camera.now) != FNL_OK) v->camera.now = before;
    v->framed = v->camera.now;
    view_want(v, 2);
}

void view_frame_again(struct view *v) {
    const struct ui_rectangle area = view_area(v);
    if (v->framed_aspect == 0 || area.height < 1) return;
    if (memcmp(&v->framed, &v->camera.now, sizeof v->framed) != 0)
        v->framed_aspect = 0;
    else if (fabsf(v->framed_aspect - area.width / area.height) > 1e-3f)
        view_frame_all(v);
}

void view_reset_camera(struct view *v) {
    if (!v->shown.source || fnl_scene_count(v->shown.scene, FNL_ENTITY_CAMERA) == 0) {
        view_frame_all(v);
        return;
    }
    v->camera.now = v->shown.camera;
    view_want(v, 2);
}

void view_set_time(struct view *v, double time) {
    fnl_animation_info info;
    if (!v->shown.scene || fnl_scene_query_animation(v->shown.scene, v->animation, &info) != FNL_OK) return;
    double duration = info.duration;
    const bool blends = view_blends(v) && fnl_scene_query_animation(v->shown.scene, v->files.blend_with, &info) == FNL_OK;
    if (blends) duration = fmax(duration, info.duration);
    v->time = duration > 0 ? fmod(time, duration) : 0;
    const fnl_animation_time times[] = {{v->animation, v->time, blends ? 1 - v->files.blend_part : 1}, {v->files.blend_with, v->time, v->files.blend_part}};
    fnl_scene_set_times(v->shown.scene, times, blends ? 2 : 1);
    v->select.stamp++;
    view_want(v, 2);
}

/* ---- frames ---- */

double view_now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void note_stats(struct view *v) {
    trace_mark(v->timeline.history, "wait for the frame");
    const bool good = fnl_renderer_query_stats(v->shown.renderer, &v->stats) == FNL_OK;
    trace_end_frame(v->timeline.history, good && v->timeline.called > 0 ? &v->stats : NULL, v->timeline.called);
    if (!good) return;
    v->pass_count = v->stats.pass_count < VIEW_PASSES ? v->stats.pass_count : VIEW_PASSES;
    for (uint32_t i = 0; i < v->pass_count; i++) {
        snprintf(v->passes[i].name, sizeof v->passes[i].name, "%s", v->stats.passes[i].name);
        v->passes[i].milliseconds = v->stats.passes[i].milliseconds;
    }
    const fnl_counter *pending = fnl_counter_find(&v->stats, "images.pending");
    v->pending = pending ? pending->value : 0;
    v->history[v->history_at] = (float)v->stats.gpu_milliseconds;
    v->history_at = (v->history_at + 1) % VIEW_HISTORY;
    view_compare_note(v);
}

/* So fine that frames take a 25th of a second while something moves, and whole when nothing does. */
enum { FRAME_MILLISECONDS = 40 };
static void choose_part(struct view *v) {
    if (!v->moving || !v->swapchain) {
        v->part = v->moving ? v->part : 1;
        return;
    }
    const double wanted = FRAME_MILLISECONDS * 1e-3, ratio = sqrt(wanted / fmax(v->frame_seconds, 1e-4));
    /* In eighths: each new size takes memory of its own. */
    const double part = (double)v->part * fmax(0.6, fmin(1.3, ratio));
    v->part = (float)fmax(2, fmin(8, floor(8 * part + 0.25))) / 8;
}

static void begin_call(struct view *v) {
    trace_mark(v->timeline.history, "render");
    v->timeline.called = trace_now();
}

/* What the frame says of the pixel that was clicked, before any other call on its renderer. */
static fnl_result drawn(struct view *v, const fnl_frame *frame, fnl_result result) {
    if (result == FNL_OK && !v->compare.is_shown) view_pixel_take(v, frame);
    return result;
}

static fnl_result draw(struct view *v, const fnl_overlay *overlay, bool retried) {
    fnl_frame frame = view_whole_frame(v);
    frame.overlay = overlay;
    if (!v->swapchain) {
        begin_call(v);
        view_pixel_ask(v, &frame);
        return drawn(v, &frame, view_compare_draw(v, &frame, NULL));
    }
    fnl_vulkan_target target;
    trace_mark(v->timeline.history, "acquire");
    fnl_result result = fnl_swapchain_acquire(v->swapchain, &target);
    if (result == FNL_ERROR_DEVICE && !retried) { /* the surface is lost: another one, once */
        fnl_swapchain_destroy(&v->swapchain);
        if (!view_window_open_swapchain(v->window, v->device.device, v->settings.present, v->settings.color, &v->swapchain)) return result;
        return draw(v, overlay, true);
    }
    if (result != FNL_OK || target.image == VK_NULL_HANDLE) return result;
    choose_part(v);
    frame.pin_choice = v->part < 1; /* auto measures frames of the window's size alone */
    frame.width = (uint32_t)fmaxf(1, (float)target.width * v->part);
    frame.height = (uint32_t)fmaxf(1, (float)target.height * v->part);
    begin_call(v);
    view_pixel_ask(v, &frame);
    result = drawn(v, &frame, view_compare_draw(v, &frame, &target));
    trace_mark(v->timeline.history, "present");
    if (result == FNL_OK) result = fnl_swapchain_present(v->swapchain);
    return result == FNL_ERROR_DEVICE && !retried ? FNL_OK : result; /* the next one finds out whether the surface is lost */
}

static fnl_result draw_window(struct view *v, const fnl_overlay *overlay) { return draw(v, overlay, false); }

/* How long a scene took from its name to its picture. */
static void note_arrival(struct view *v) {
    char text[160];
    const double seconds = view_now() - v->opened;
    if (v->arriving == 2) snprintf(text, sizeof text, "first picture after %.2f s", seconds);
    if (v->arriving == 1 && v->pending == 0) snprintf(text, sizeof text, "all images after %.2f s", seconds);
    if (v->arriving == 2 || (v->arriving == 1 && v->pending == 0)) {
        view_say(v, FNL_LOG_INFO, text);
        v->arriving--;
    }
}

/* ---- by a device of its own ---- */

/* The scene's frame is finished: its picture is the window's from now on. */
static bool finish_frame(struct view *v, fnl_result result, fnl_image *picture) {
    v->screen.is_drawing = false;
    if (result != FNL_OK) return false;
    v->frame_seconds = view_now() - v->screen.begun;
    view_screen_take(v, picture);
    note_stats(v);
    note_arrival(v);
    v->frames_drawn++;
    v->frames_loading += v->loader.running;
    view_want_panels(v, 2);
    return true;
}

bool view_collect(struct view *v) {
    struct view_screen *s = &v->screen;
    fnl_image picture = {0};
    bool is_done = false, good = true;
    if (!s->is_drawing || pthread_mutex_trylock(&v->device.mutex) != 0) return true;
    good = fnl_renderer_query_done(v->shown.renderer, &is_done) == FNL_OK;
    if (good && is_done) {
        fnl_frame frame = s->sent;
        frame.pixel = s->pixel;
        drawn(v, &frame, FNL_OK);
        good = finish_frame(v, fnl_renderer_read(v->shown.renderer, FNL_OUTPUT_COLOR, &picture), &picture);
    }
    pthread_mutex_unlock(&v->device.mutex);
    return good;
}

/* Begins the scene's next frame; two methods are drawn one after the other, and waited for. */
static fnl_result send(struct view *v, const fnl_overlay *overlay) {
    struct view_screen *s = &v->screen;
    (void)overlay;
    choose_part(v);
    s->sent = view_screen_frame(v);
    s->begun = view_now();
    fnl_frame frame = s->sent;
    begin_call(v);
    view_pixel_ask(v, &frame);
    if (v->compare.mode == VIEW_COMPARE_OFF) {
        const fnl_result result = fnl_renderer_render(v->shown.renderer, &frame);
        s->is_drawing = result == FNL_OK;
        s->pixel = frame.pixel;
        return result;
    }
    fnl_image picture = {0};
    const fnl_result result = v->compare.is_shown ? FNL_OK : view_compare_read(v, &frame, &picture);
    return result != FNL_OK || finish_frame(v, result, &picture) ? result : FNL_ERROR_DEVICE;
}

/* What cannot be drawn is taken back: the picture stays the last that could. */
static bool draw_or_take_back(struct view *v, fnl_result (*begin)(struct view *, const fnl_overlay *), const fnl_overlay *overlay) {
    view_follow_origin(v);
    fnl_result result = begin(v, overlay);
    if (result == FNL_OK) {
        v->good = v->frame;
        return true;
    }
    if (result != FNL_ERROR_INVALID && result != FNL_ERROR_UNSUPPORTED && result != FNL_ERROR_MEMORY) return false;
    v->frame = v->good;
    result = begin(v, overlay);
    view_want(v, 2); /* with the reason among the messages */
    return result == FNL_OK;
}

static void pick_object(struct view *v) {
    struct view_pick *p = &v->pick;
    fnl_frame frame = view_whole_frame(v);
    fnl_image image = {0};
    uint32_t x = p->x;
    frame.width = view_compare_place(v, &x);
    frame.camera = view_compare_camera(v, x != p->x);
    frame.outputs = FNL_OUTPUT_OBJECT;
    frame.msaa = 1;
    frame.pin_choice = true;
    p->clicked = false;
    if (x < frame.width && p->y < frame.height && fnl_renderer_render(v->shown.renderer, &frame) == FNL_OK &&
        fnl_renderer_read(v->shown.renderer, FNL_OUTPUT_OBJECT, &image) == FNL_OK)
        view_select_object(v, (const float *)image.pixels + 4 * ((size_t)p->y * frame.width + x));
    fnl_image_free(&v->host, &image);
    view_want(v, 2);
}

/* The scene's next frame is begun where it is due and the device is free; panels are drawn in any case. */
static bool draw_apart(struct view *v, double seconds) {
    fnl_overlay overlay;
    const bool is_free = pthread_mutex_trylock(&v->device.mutex) == 0;
    bool good = true;
    if (is_free && !v->screen.is_drawing && (v->due > 0 || view_screen_has_changed(v))) {
        if (v->due > 0) v->due--;
        view_compare_update(v);
        if (v->pick.clicked) pick_object(v);
        v->timeline.called = 0;
        good = draw_or_take_back(v, send, NULL);
    } else if (!is_free)
        view_want_panels(v, 1);
    trace_mark(v->timeline.history, "panels");
    ui_begin(v->width, v->height, seconds);
    view_screen_back(v);
    view_panels(v);
    ui_end(&overlay);
    trace_mark(v->timeline.history, "present");
    good = good && view_screen_show(v, &overlay) == FNL_OK;
    if (is_free) pthread_mutex_unlock(&v->device.mutex);
    return good;
}

/* A frame of the window; false when the device is lost. */
bool view_draw_frame(struct view *v, double seconds) {
    fnl_overlay overlay;
    if (v->wanted > 0) v->wanted--;
    v->stale = false;
    if (v->width == 0 || v->height == 0) return true;
    if (v->wanted_scale > 0) { /* letters are made anew between frames */
        v->scale = v->settings.scale = v->wanted_scale;
        v->wanted_scale = 0;
        view_apply_settings(v);
    }
    if (v->screen.device) return draw_apart(v, seconds);
    if (v->due > 0) v->due--;
    if (v->replays)
        pthread_mutex_lock(&v->device.mutex);
    else if (pthread_mutex_trylock(&v->device.mutex) != 0) { /* a scene is on its way to the device: the window answers, and this frame is left out */
        view_want(v, 1);
        return true;
    }
    const double begun = view_now();
    view_compare_update(v);
    if (v->compare.is_shown) note_stats(v); /* before more frames of the device follow */
    v->timeline.called = 0;
    trace_mark(v->timeline.history, "panels");
    ui_begin(v->width, v->height, seconds);
    view_panels(v);
    ui_end(&overlay);
    if (v->pick.clicked) pick_object(v);
    const bool good = draw_or_take_back(v, draw_window, &overlay);
    if (good && !v->compare.is_shown) note_stats(v);
    pthread_mutex_unlock(&v->device.mutex);
    v->frame_seconds = view_now() - begun;
    note_arrival(v);
    v->frames_drawn++;
    v->frames_loading += v->loader.running;
    v->screen.shown += !v->loader.running;
    return good && view_screen_adapt(v);
}

static bool save_image(struct view *v, fnl_result result, const char *path, fnl_image *image) {
    bool good = result == FNL_OK && fnl_image_save(&v->host, path, image) == FNL_OK;
    fnl_image_free(&v->host, image);
    char text[1100];
    snprintf(text, sizeof text, good ? "wrote %s" : "%s was not written", path);
    view_say(v, good ? FNL_LOG_INFO : FNL_LOG_ERROR, text);
    return good;
}

/* Frames take up images as they come, those of any renderer for all. */
bool view_wait_for_images(struct view *v, const fnl_frame *frame) {
    fnl_renderer *renderer = NULL;
    fnl_frame small = *frame;
    fnl_frame_stats stats;
    small.width = small.height = 8;
    small.aa = FNL_ANTIALIASING_NONE;
    small.outputs = 0;
    uint64_t pending = v->pending;
    bool good = pending == 0 || fnl_renderer_create(v->device.device, v->shown.scene, &renderer) == FNL_OK;
    while (pending > 0 && good) {
        good = fnl_renderer_render(renderer, &small) == FNL_OK && fnl_renderer_query_stats(renderer, &stats) == FNL_OK;
        const fnl_counter *counter = good ? fnl_counter_find(&stats, "images.pending") : NULL;
        pending = counter ? counter->value : 0;
        nanosleep(&(struct timespec){.tv_nsec = 2000000}, NULL);
    }
    fnl_renderer_destroy(&renderer);
    return good;
}

static bool save_last(struct view *v, fnl_renderer *renderer, const char *path, fnl_output output) {
    fnl_image image = {0};
    const fnl_result result = fnl_renderer_read(renderer, output, &image);
    return save_image(v, result, path, &image);
}

/* A window that is closed up has no picture. */
static bool has_place(struct view *v, const char *path, uint32_t width, uint32_t height) {
    char text[VIEW_PATH + 80];
    if (width > 0 && height > 0) return true;
    snprintf(text, sizeof text, "%s: not written: the picture has %u x %u pixels", path, width, height);
    view_say(v, FNL_LOG_ERROR, text);
    return false;
}

/* By a renderer of its own, which begins as that of the command does: without the shadow pages and the history of earlier frames. */
bool view_save_picture(struct view *v, const char *path) {
    enum { TAA_FRAMES = 16 }; /* render_run.c */
    fnl_renderer *renderer = NULL;
    fnl_frame_stats stats;
    fnl_frame frame = view_whole_frame(v);
    view_save_size(v, &frame.width, &frame.height);
    frame.camera = v->camera.now;
    if (!has_place(v, path, frame.width, frame.height)) return false;
    frame.outputs = view_ends_with(path, ".exr") ? FNL_OUTPUT_RADIANCE : FNL_OUTPUT_COLOR;
    frame.pin_choice = true;
    pthread_mutex_lock(&v->device.mutex);
    bool good = view_wait_for_images(v, &frame) && fnl_renderer_create(v->device.device, v->shown.scene, &renderer) == FNL_OK;
    for (int i = frame.aa == FNL_ANTIALIASING_TAA ? TAA_FRAMES : 1; i > 0 && good; i--) good = fnl_renderer_render(renderer, &frame) == FNL_OK;
    good = good && fnl_renderer_query_stats(renderer, &stats) == FNL_OK && render_settle_pools(renderer, &frame, &stats) &&
           save_last(v, renderer, path, (fnl_output)frame.outputs);
    fnl_renderer_destroy(&renderer);
    pthread_mutex_unlock(&v->device.mutex);
    view_want(v, 2);
    return good;
}

bool view_save_capture(struct view *v, const char *path) {
    fnl_overlay overlay;
    fnl_frame frame = view_whole_frame(v);
    if (!has_place(v, path, v->width, v->height)) return false;
    view_compare_update(v);
    ui_begin(v->width, v->height, 1.0 / 60);
    view_panels(v);
    ui_end(&overlay);
    frame.overlay = &overlay;
    pthread_mutex_lock(&v->device.mutex);
    fnl_image image = {0};
    const fnl_result result = view_compare_read(v, &frame, &image);
    pthread_mutex_unlock(&v->device.mutex);
    return save_image(v, result, path, &image);
}
