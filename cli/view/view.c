/* SPDX-License-Identifier: MIT */
/* fanal view: shows a scene in a window. */
#include "view/view.h"

#include "arguments.h"
#include "commands.h"
#include "options.h"
#include "render.h"
#include "view/ui.h"

#include "fanal/vulkan.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

struct view_options {
    struct world_options world;
    fnl_frame frame;
    const char *device, *replay, *record;
    uint32_t exit_after; /* frames; 0: never */
    bool headless, validate, no_cache, light, own_shadows, no_vsync, no_panels;
    double scale; /* 0: the screen's */
};

static void print_help(void) {
    puts("Usage: fanal view [SCENE] [OPTIONS]\n"
         "\n"
         "Shows SCENE, a .gltf or .glb file or builtin:NAME, in a window; without one, what is dropped into it. F1 lists the keys.\n"
         "\n"
         "Window\n"
         "  --size WxH                 pixels (1280x720)\n"
         "  --scale X                  size of letters and gaps, 0.5 to 4 (the screen's)\n"
         "  --light                    dark letters on light panels\n"
         "  --no-panels                begins with the picture alone (Tab shows the panels)\n"
         "  --no-vsync                 does not wait for the screen\n"
         "  --headless                 draws the same frames without a window; with --replay\n"
         "  --replay FILE              takes its events from a file that --record has written, a line each; besides what a window sends,\n"
         "                             'frames N', 'settle', 'set KEY=VALUE', 'click LABEL', 'save FILE', 'capture FILE' (with the panels), 'command FILE', 'report FILE'\n"
         "  --record FILE              writes the events of the window to a file\n"
         "  --exit-after N             ends after N frames\n"
         "  --device INDEX|NAME        one of those that 'fanal devices' lists (the best)\n"
         "  --no-cache                 does not use the user's cache folder\n"
         "  --validate                 Vulkan validation; any message makes the command fail\n"
         "  -h, --help                 prints this text\n"
         "\n"
         "Scene\n"
         WORLD_CAMERA_HELP WORLD_EYE_HELP
         "  --exposure EV|auto|none    EV100 (auto)\n"
         WORLD_SURROUNDINGS_HELP);
    puts(WORLD_SCENE_HELP "\n"
         "Any option of 'fanal render' for the method can be given, such as --shading, --lists, --shadows, --debug, --set KEY=VALUE.\n"
         "\n"
         "Exit status: 0, or 2 on an error.\n"
         "\n"
         "Examples:\n"
         "  fanal view builtin:hall --lights 1000\n"
         "  fanal view model.glb --environment builtin:sky");
}

/* ---- messages ---- */

static void take_message(void *user, fnl_log_level level, const char *line) {
    struct view_messages *m = user;
    if (level >= FNL_LOG_WARNING) fprintf(stderr, "fanal: %s\n", line);
    if (level < FNL_LOG_INFO) return;
    pthread_mutex_lock(&m->mutex);
    m->lines[m->count % VIEW_MESSAGES].level = level;
    snprintf(m->lines[m->count % VIEW_MESSAGES].text, sizeof m->lines->text, "%s", line);
    m->count++;
    pthread_mutex_unlock(&m->mutex);
}

static void say(struct view *v, fnl_log_level level, const char *text) { take_message(&v->messages, level, text); }

/* ---- the scene ---- */

static fnl_shadows usual_shadows(const struct view *v) {
    fnl_device_info device;
    return fnl_device_query_info(v->device, &device) == FNL_OK ? world_usual_shadows(&v->shown.info, &device, true) : FNL_SHADOWS_OFF;
}

/* The new scene takes the place of the old one; where it cannot, the old one stays. */
static void show(struct view *v, struct view_scene *scene) {
    fnl_renderer *renderer = NULL;
    if (!scene->scene) return;
    if (fnl_renderer_create(v->device, scene->scene, &renderer) != FNL_OK) {
        view_scene_free(scene);
        return;
    }
    fnl_renderer_destroy(&v->renderer);
    view_scene_free(&v->shown);
    v->renderer = renderer;
    v->shown = *scene;
    v->camera.now = scene->camera;
    const fnl_vec3 low = scene->info.bounds_low, high = scene->info.bounds_high; /* of nothing: infinite */
    const float size = fmaxf(high.x - low.x, fmaxf(high.y - low.y, high.z - low.z));
    v->camera.size = size > 1e-3f && size < 1e6f ? size : 1;
    v->animation = 0;
    v->time = v->world.time;
    v->pick.known = false;
    if (!v->own_shadows) v->frame.shadows = v->usual.shadows = usual_shadows(v);
    v->good = v->frame;
    char title[300];
    snprintf(title, sizeof title, "%.200s%sFanal", scene->source ? scene->source : "", scene->source ? " - " : "");
    if (v->window) view_window_set_title(v->window, title);
    view_want(v, 2);
}

static bool ends_with(const char *text, const char *end) {
    const size_t a = strlen(text), b = strlen(end);
    return a >= b && strcasecmp(text + a - b, end) == 0;
}

void view_open(struct view *v, const char *source) {
    if (v->shown.scene && (ends_with(source, ".hdr") || ends_with(source, ".exr") || strcmp(source, "builtin:studio") == 0)) {
        fnl_environment_params environment = v->world.environment_params;
        environment.source = source;
        if (fnl_scene_set_environment(v->shown.scene, &environment) == FNL_OK) view_want(v, 2);
        return;
    }
    if (!view_loader_start(&v->loader, &v->world, &v->host, source, v->width, v->height)) say(v, FNL_LOG_ERROR, "memory ran out");
    view_want(v, 1);
}

void view_frame_all(struct view *v) {
    const fnl_camera before = v->camera.now;
    if (!v->shown.scene || v->height == 0) return;
    if (fnl_scene_query_framing_camera(v->shown.scene, (float)v->width / (float)v->height, &v->camera.now) != FNL_OK) v->camera.now = before;
    view_want(v, 2);
}

void view_set_time(struct view *v, double time) {
    fnl_animation_info info;
    if (!v->shown.scene || fnl_scene_query_animation(v->shown.scene, v->animation, &info) != FNL_OK) return;
    v->time = info.duration > 0 ? fmod(time, info.duration) : 0;
    fnl_scene_set_time(v->shown.scene, v->animation, v->time);
    view_want(v, 2);
}

/* ---- frames ---- */

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void note_stats(struct view *v) {
    if (!v->renderer || fnl_renderer_query_stats(v->renderer, &v->stats) != FNL_OK) return;
    v->pass_count = v->stats.pass_count < VIEW_PASSES ? v->stats.pass_count : VIEW_PASSES;
    for (uint32_t i = 0; i < v->pass_count; i++) {
        snprintf(v->passes[i].name, sizeof v->passes[i].name, "%s", v->stats.passes[i].name);
        v->passes[i].milliseconds = v->stats.passes[i].milliseconds;
    }
    v->history[v->history_at] = (float)v->stats.gpu_milliseconds;
    v->history_at = (v->history_at + 1) % VIEW_HISTORY;
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

static fnl_frame whole_frame(const struct view *v) {
    fnl_frame frame = v->frame;
    frame.width = v->width;
    frame.height = v->height;
    frame.camera = v->camera.now;
    frame.outputs = FNL_OUTPUT_COLOR;
    return frame;
}

static fnl_result draw(struct view *v, const fnl_overlay *overlay) {
    fnl_frame frame = whole_frame(v);
    frame.overlay = overlay;
    if (!v->swapchain) return fnl_renderer_render(v->renderer, &frame);
    fnl_vulkan_target target;
    fnl_result result = fnl_swapchain_acquire(v->swapchain, &target);
    if (result != FNL_OK || target.image == VK_NULL_HANDLE) return result;
    choose_part(v);
    frame.pin_choice = v->part < 1; /* auto measures frames of the window's size alone */
    frame.width = (uint32_t)fmaxf(1, (float)target.width * v->part);
    frame.height = (uint32_t)fmaxf(1, (float)target.height * v->part);
    result = fnl_renderer_render_to(v->renderer, &frame, &target);
    return result == FNL_OK ? fnl_swapchain_present(v->swapchain) : result;
}

/* What cannot be drawn is taken back: the picture stays the last that could. */
static bool draw_or_take_back(struct view *v, const fnl_overlay *overlay) {
    fnl_result result = draw(v, overlay);
    if (result == FNL_OK) {
        v->good = v->frame;
        return true;
    }
    if (result != FNL_ERROR_INVALID && result != FNL_ERROR_UNSUPPORTED && result != FNL_ERROR_MEMORY) return false;
    v->frame = v->good;
    result = draw(v, overlay);
    view_want(v, 2); /* with the reason among the messages */
    return result == FNL_OK;
}

static void read_pick(struct view *v) {
    struct view_pick *p = &v->pick;
    fnl_frame frame = whole_frame(v);
    fnl_image images[3] = {{0}};
    static const fnl_output outputs[3] = {FNL_OUTPUT_SURFACE, FNL_OUTPUT_NORMAL, FNL_OUTPUT_POSITION};
    frame.outputs = FNL_OUTPUT_SURFACE | FNL_OUTPUT_NORMAL | FNL_OUTPUT_POSITION;
    frame.msaa = 1;
    bool good = fnl_renderer_render(v->renderer, &frame) == FNL_OK;
    for (uint32_t i = 0; i < 3 && good; i++) good = fnl_renderer_read(v->renderer, outputs[i], &images[i]) == FNL_OK;
    p->asked = false;
    p->known = good && p->x < frame.width && p->y < frame.height;
    if (p->known) {
        const size_t at = 4 * ((size_t)p->y * frame.width + p->x);
        const float *surface = (const float *)images[0].pixels + at, *normal = (const float *)images[1].pixels + at,
                    *position = (const float *)images[2].pixels + at;
        p->hit = position[3] > 0;
        p->color = (fnl_vec3){surface[0], surface[1], surface[2]};
        p->roughness = surface[3];
        p->normal = (fnl_vec3){normal[0], normal[1], normal[2]};
        p->depth = normal[3];
        p->position = (fnl_vec3){position[0], position[1], position[2]};
    }
    for (uint32_t i = 0; i < 3; i++) fnl_image_free(&v->host, &images[i]);
    view_want(v, 2);
}

/* A frame of the window; false when the device is lost. */
static bool draw_frame(struct view *v, double seconds) {
    const double begun = now();
    fnl_overlay overlay;
    if (v->wanted > 0) v->wanted--;
    v->stale = false;
    if (v->width == 0 || v->height == 0) return true;
    ui_begin(v->width, v->height, seconds);
    view_panels(v);
    ui_end(&overlay);
    if (v->pick.asked && v->renderer) read_pick(v);
    if (v->renderer && !draw_or_take_back(v, &overlay)) return false;
    note_stats(v);
    v->frame_seconds = now() - begun;
    v->frames_drawn++;
    return true;
}

static bool save_last(struct view *v, fnl_renderer *renderer, const char *path, fnl_output output) {
    fnl_image image = {0};
    bool good = fnl_renderer_read(renderer, output, &image) == FNL_OK && fnl_image_save(&v->host, path, &image) == FNL_OK;
    fnl_image_free(&v->host, &image);
    char text[1100];
    snprintf(text, sizeof text, good ? "wrote %s" : "%s was not written", path);
    say(v, good ? FNL_LOG_INFO : FNL_LOG_ERROR, text);
    return good;
}

/* By a renderer of its own, which begins as that of the command does: without the shadow pages and the history of earlier frames. */
bool view_save_picture(struct view *v, const char *path) {
    enum { TAA_FRAMES = 16 }; /* render_run.c */
    fnl_renderer *renderer = NULL;
    fnl_frame_stats stats;
    fnl_frame frame = whole_frame(v);
    if (v->width == 0 || v->height == 0 || fnl_renderer_create(v->device, v->shown.scene, &renderer) != FNL_OK) return false;
    frame.outputs = ends_with(path, ".exr") ? FNL_OUTPUT_RADIANCE : FNL_OUTPUT_COLOR;
    frame.pin_choice = true;
    bool good = true;
    for (int i = frame.aa == FNL_ANTIALIASING_TAA ? TAA_FRAMES : 1; i > 0 && good; i--) good = fnl_renderer_render(renderer, &frame) == FNL_OK;
    good = good && fnl_renderer_query_stats(renderer, &stats) == FNL_OK && render_settle_pools(renderer, &frame, &stats) &&
           save_last(v, renderer, path, (fnl_output)frame.outputs);
    fnl_renderer_destroy(&renderer);
    view_want(v, 2);
    return good;
}

static bool save_capture(struct view *v, const char *path) {
    fnl_overlay overlay;
    fnl_frame frame = whole_frame(v);
    if (v->width == 0 || v->height == 0) return false;
    ui_begin(v->width, v->height, 1.0 / 60);
    view_panels(v);
    ui_end(&overlay);
    frame.overlay = &overlay;
    return fnl_renderer_render(v->renderer, &frame) == FNL_OK && save_last(v, v->renderer, path, FNL_OUTPUT_COLOR);
}

/* ---- events ---- */

enum { KEY_SPACE = 32, KEY_TAB = 258, KEY_F1 = 290, KEY_SHIFT = 340, KEY_CONTROL = 341 };

static void press_key(struct view *v, int key) {
    switch (key) {
    case 'F':
        view_frame_all(v);
        break;
    case 'P':
        view_save_picture(v, v->save_path);
        break;
    case 'Q':
        v->quit = v->modifiers & VIEW_CONTROL;
        break;
    case KEY_SPACE:
        v->plays = !v->plays && v->shown.info.animation_count > 0;
        break;
    case KEY_TAB:
        v->hides_panels = !v->hides_panels;
        break;
    case KEY_F1:
        v->shows_help = !v->shows_help;
        break;
    default:
        break;
    }
}

static void drag(struct view *v, float x, float y) {
    const float dx = x - v->mouse_x, dy = y - v->mouse_y, height = fmaxf((float)v->height, 1);
    const bool sideways = v->drag == 2 || (v->drag == 0 && v->modifiers & VIEW_SHIFT);
    if (v->drag < 0 || !v->shown.scene) return;
    if (sideways)
        view_camera_pan(&v->camera, dx / height, dy / height);
    else if (v->drag == 0)
        view_camera_orbit(&v->camera, dx / height * 3, dy / height * 3);
    else
        view_camera_look(&v->camera, dx / height * 2, dy / height * 2);
    v->moving = true;
}

static void press_button(struct view *v, const struct view_event *e) {
    if (!e->down) {
        if (v->drag == e->code) v->drag = -1;
        return;
    }
    if (ui_wants_mouse()) return;
    if (e->code == 0 && v->modifiers & VIEW_CONTROL) {
        v->pick.asked = v->shown.scene && v->mouse_x >= 0 && v->mouse_y >= 0;
        v->pick.x = (uint32_t)fmaxf(v->mouse_x, 0);
        v->pick.y = (uint32_t)fmaxf(v->mouse_y, 0);
        return;
    }
    v->drag = e->code;
}

/* True when a frame must be drawn before the next event: widgets see a button or a key only if it stays as it is for a frame. */
static bool handle(struct view *v, const struct view_event *e) {
    view_want(v, 3);
    if (e->kind == VIEW_BUTTON || e->kind == VIEW_KEY) {
        v->modifiers = e->modifiers;
        /* The event of a modifier's own key does not count that key. */
        if (e->kind == VIEW_KEY && (e->code == KEY_SHIFT || e->code == KEY_SHIFT + 4))
            v->modifiers = e->down ? v->modifiers | VIEW_SHIFT : v->modifiers & ~(uint32_t)VIEW_SHIFT;
        if (e->kind == VIEW_KEY && (e->code == KEY_CONTROL || e->code == KEY_CONTROL + 4))
            v->modifiers = e->down ? v->modifiers | VIEW_CONTROL : v->modifiers & ~(uint32_t)VIEW_CONTROL;
        ui_modifiers(v->modifiers & VIEW_CONTROL, v->modifiers & VIEW_SHIFT, v->modifiers & VIEW_ALT);
    }
    switch (e->kind) {
    case VIEW_MOVE:
        v->stale = true;
        ui_mouse_moved(e->x, e->y);
        drag(v, e->x, e->y);
        v->mouse_x = e->x;
        v->mouse_y = e->y;
        return false;
    case VIEW_BUTTON:
        ui_mouse_button(e->code, e->down);
        press_button(v, e);
        return true;
    case VIEW_WHEEL:
        ui_mouse_wheel(e->x, e->y);
        if (ui_wants_mouse() || !v->shown.scene) return false;
        view_camera_dolly(&v->camera, e->y);
        v->moving = true;
        return false;
    case VIEW_KEY:
        ui_key(e->code, e->down);
        v->keys[e->code] = e->down && !ui_wants_keys();
        if (v->keys[e->code]) press_key(v, e->code);
        return true;
    case VIEW_CHARACTER:
        ui_character((uint32_t)e->code);
        return false;
    case VIEW_SIZE:
        v->width = (uint32_t)e->x;
        v->height = (uint32_t)e->y;
        if (v->swapchain) {
            fnl_swapchain_params params = fnl_swapchain_params_default();
            params.width = v->width;
            params.height = v->height;
            fnl_swapchain_set(v->swapchain, &params);
        }
        return false;
    case VIEW_DROP:
        view_open(v, e->text);
        return false;
    case VIEW_CLOSE:
        v->quit = true;
        return false;
    default:
        return false;
    }
}

/* Hands an event on, between frames where that matters: first for a button, which belongs to what is under the mouse. */
static bool feed(struct view *v, const struct view_event *e, bool *out_wants_frame) {
    if (e->kind == VIEW_BUTTON && v->stale && !draw_frame(v, 1.0 / 60)) return false;
    *out_wants_frame = handle(v, e);
    return true;
}

/* What goes on by itself: keys that are held down, the animation, what is being loaded. */
static void advance(struct view *v, double seconds) {
    struct view_scene scene;
    if (view_loader_take(&v->loader, false, &scene)) {
        show(v, &scene);
        view_want(v, 2);
    }
    if (v->loader.running) view_want(v, 1);
    if (v->plays) {
        view_set_time(v, v->time + seconds * v->speed);
        v->moving = true;
    }
    const float step = v->camera.size * 0.4f * (v->modifiers & VIEW_SHIFT ? 4.0f : 1.0f) * (float)seconds;
    const fnl_vec3 by = {step * (float)(v->keys['D'] - v->keys['A']), step * (float)(v->keys['E'] - v->keys['Q']), step * (float)(v->keys['W'] - v->keys['S'])};
    if ((by.x != 0 || by.y != 0 || by.z != 0) && v->shown.scene) {
        view_camera_fly(&v->camera, by);
        v->moving = true;
        view_want(v, 2);
    }
    if (v->drag >= 0) v->moving = true;
    if (v->frame.aa == FNL_ANTIALIASING_TAA && v->moving) view_want(v, 16);
}

/* ---- with a window ---- */

static bool run_window(struct view *v, const struct view_options *o) {
    FILE *record = o->record ? fopen(o->record, "w") : NULL;
    if (o->record && !record) {
        fprintf(stderr, "fanal: error: %s: cannot be written\n", o->record);
        return false;
    }
    double last = now();
    bool good = true;
    while (!v->quit && good && (o->exit_after == 0 || v->frames_drawn < o->exit_after)) {
        struct view_event event;
        const bool idle = v->wanted == 0 && v->queue.count == 0;
        view_window_poll(v->window, idle ? (v->part < 1 ? 0.15 : 0.5) : v->loader.running ? 0.03 : 0);
        if (idle && v->queue.count == 0 && v->part < 1) { /* it has come to rest: now as fine as the window */
            v->part = 1;
            view_want(v, 1);
        }
        v->moving = false;
        for (bool enough = false; good && !enough && view_queue_take(&v->queue, &event);) {
            if (record) view_event_write(record, &event);
            good = feed(v, &event, &enough);
        }
        if (o->exit_after) view_want(v, 1);
        const double time = now(), seconds = fmin(time - last, 0.1);
        last = time;
        advance(v, seconds);
        if (v->wanted == 0) continue;
        good = draw_frame(v, seconds);
        if (record) fputs("frames 1\n", record);
    }
    if (record && fclose(record) != 0) good = false;
    return good;
}

/* ---- from a file ---- */

static bool settle(struct view *v) {
    struct view_scene scene;
    if (view_loader_take(&v->loader, true, &scene)) show(v, &scene);
    view_want(v, 2);
    for (uint32_t i = 0; i < 1000 && v->wanted > 0 && !v->plays; i++) {
        v->moving = false;
        advance(v, 1.0 / 60);
        if (!draw_frame(v, 1.0 / 60)) return false;
    }
    return true;
}

static bool write_command(const struct view *v, const char *path) {
    FILE *file = fopen(path, "w");
    if (!file) {
        fprintf(stderr, "fanal: error: %s: cannot be written\n", path);
        return false;
    }
    view_print_command(v, file);
    return fclose(file) == 0;
}

/* As somebody would: the mouse goes there, and the button goes down and up, with a frame after each. */
static bool click(struct view *v, const char *label) {
    struct view_event e = {.kind = VIEW_MOVE};
    bool ignored;
    if (!draw_frame(v, 1.0 / 60)) return false;
    if (!ui_find(label, &e.x, &e.y)) {
        fprintf(stderr, "fanal: error: %s: no widget in sight is called so\n", label);
        return false;
    }
    if (!feed(v, &e, &ignored)) return false;
    e = (struct view_event){.kind = VIEW_BUTTON, .down = true};
    if (!feed(v, &e, &ignored) || !draw_frame(v, 1.0 / 60)) return false;
    e.down = false;
    return feed(v, &e, &ignored) && draw_frame(v, 1.0 / 60);
}

static bool replay_event(struct view *v, const struct view_event *e) {
    switch (e->kind) {
    case VIEW_FRAMES:
        for (int i = 0; i < e->code; i++) {
            if (v->window) view_window_poll(v->window, 0);
            v->queue.count = 0; /* what the real window says does not count */
            v->moving = false;
            advance(v, 1.0 / 60);
            if (!draw_frame(v, 1.0 / 60)) return false;
        }
        return true;
    case VIEW_SETTLE:
        return settle(v);
    case VIEW_SET:
        view_want(v, 2);
        v->own_shadows = v->own_shadows || strncmp(e->text, "shadows=", 8) == 0;
        return options_set_text(&v->frame, "replay", e->text, NULL);
    case VIEW_CLICK:
        return click(v, e->text);
    case VIEW_SAVE:
        return view_save_picture(v, e->text);
    case VIEW_CAPTURE:
        return save_capture(v, e->text);
    case VIEW_COMMAND:
        return write_command(v, e->text);
    case VIEW_REPORT:
        return view_write_report(v, e->text);
    default: {
        bool wants_frame;
        return feed(v, e, &wants_frame) && (!wants_frame || draw_frame(v, 1.0 / 60));
    }
    }
}

static bool run_replay(struct view *v, const struct view_options *o) {
    FILE *file = fopen(o->replay, "r");
    if (!file) {
        fprintf(stderr, "fanal: error: %s: cannot be read\n", o->replay);
        return false;
    }
    char text[1200];
    bool good = settle(v);
    for (uint32_t line = 1; good && !v->quit && fgets(text, sizeof text, file); line++) {
        struct view_event event;
        good = view_event_parse(o->replay, line, text, &event);
        if (good && event.kind != VIEW_EVENT_COUNT) good = replay_event(v, &event);
        if (o->exit_after && v->frames_drawn >= o->exit_after) break;
    }
    fclose(file);
    return good;
}

/* ---- the command ---- */

static bool open_device(struct view *v, const struct view_options *o) {
    fnl_device_params params = fnl_device_params_default();
    params.host = v->host;
    params.validate = o->validate;
    params.presentation = v->window != NULL;
    if (o->no_cache) params.cache_folder = "";
    argument_device(o->device, &params);
    return fnl_device_create(&params, &v->device) == FNL_OK &&
           (!v->window || view_window_open_swapchain(v->window, v->device, !o->no_vsync, &v->swapchain));
}

static bool run(struct view *v, const struct view_options *o) {
    v->width = o->frame.width;
    v->height = o->frame.height;
    if (!o->headless && !view_window_create(v->width, v->height, "Fanal", &v->queue, &v->window)) return false;
    if (v->window) view_window_query_size(v->window, &v->width, &v->height);
    v->scale = o->scale > 0 ? (float)o->scale : v->window ? view_window_scale(v->window) : 1;
    v->dark = !o->light;
    v->hides_panels = o->no_panels;
    if (!open_device(v, o)) return false;
    if (!ui_create(v->scale, v->dark)) {
        fputs("fanal: error: memory ran out\n", stderr);
        return false;
    }
    struct view_scene nothing = {0}; /* for the panels, until there is something */
    if (fnl_scene_create(&v->host, &nothing.scene) != FNL_OK || fnl_scene_query_info(nothing.scene, &nothing.info) != FNL_OK) return false;
    nothing.camera = fnl_camera_default();
    show(v, &nothing);
    if (o->world.scene) view_open(v, o->world.scene);
    bool good = o->replay ? run_replay(v, o) : run_window(v, o);
    view_loader_stop(&v->loader);
    fnl_renderer_destroy(&v->renderer);
    if (good && o->validate && fnl_device_validation_count(v->device)) {
        fprintf(stderr, "fanal: error: Vulkan validation sent %llu messages\n", (unsigned long long)fnl_device_validation_count(v->device));
        good = false;
    }
    ui_destroy();
    return good;
}

enum { O_SIZE = 256, O_SET, O_EXPOSURE, O_SCALE, O_LIGHT, O_NO_VSYNC, O_NO_PANELS, O_HEADLESS, O_REPLAY, O_RECORD, O_EXIT_AFTER, O_DEVICE, O_NO_CACHE, O_VALIDATE };

static const struct option own_options[] = {{"help", no_argument, NULL, 'h'},
                                            {"size", required_argument, NULL, O_SIZE},
                                            {"set", required_argument, NULL, O_SET},
                                            {"exposure", required_argument, NULL, O_EXPOSURE},
                                            {"scale", required_argument, NULL, O_SCALE},
                                            {"light", no_argument, NULL, O_LIGHT},
                                            {"no-vsync", no_argument, NULL, O_NO_VSYNC},
                                            {"no-panels", no_argument, NULL, O_NO_PANELS},
                                            {"headless", no_argument, NULL, O_HEADLESS},
                                            {"replay", required_argument, NULL, O_REPLAY},
                                            {"record", required_argument, NULL, O_RECORD},
                                            {"exit-after", required_argument, NULL, O_EXIT_AFTER},
                                            {"device", required_argument, NULL, O_DEVICE},
                                            {"no-cache", no_argument, NULL, O_NO_CACHE},
                                            {"validate", no_argument, NULL, O_VALIDATE},
                                            WORLD_OPTIONS};
enum { OWN_COUNT = sizeof own_options / sizeof *own_options };

static bool set_option(struct view_options *o, const char *option, const char *key, const char *value) {
    if (strcmp(key, "shadows") == 0) o->own_shadows = true;
    return options_set(&o->frame, option, key, value);
}

static bool parse_option(struct view_options *o, int option, const char *value) {
    long long integer;
    const char *key = NULL, *name = option >= OPTIONS_NAMED ? options_named((uint32_t)(option - OPTIONS_NAMED), &key) : NULL;
    if (name) return set_option(o, name, key, value ? value : "on");
    switch (option) {
    case O_SIZE:
        return argument_size("size", value, &o->frame.width, &o->frame.height);
    case O_SET:
        if (!options_set_text(&o->frame, "set", value, &key)) return false;
        o->own_shadows = o->own_shadows || strcmp(key, "shadows") == 0;
        return true;
    case O_EXPOSURE:
        return argument_exposure("exposure", value, &o->frame.exposure, &o->frame.ev);
    case O_SCALE:
        if (!argument_number("scale", value, &o->scale)) return false;
        return (o->scale >= 0.5 && o->scale <= 4) || argument_bad("scale", value, "a number from 0.5 to 4");
    case O_LIGHT:
        return o->light = true;
    case O_NO_VSYNC:
        return o->no_vsync = true;
    case O_NO_PANELS:
        return o->no_panels = true;
    case O_HEADLESS:
        return o->headless = true;
    case O_REPLAY:
        o->replay = value;
        return true;
    case O_RECORD:
        o->record = value;
        return true;
    case O_EXIT_AFTER:
        if (!argument_integer("exit-after", value, 1, 1000000000, &integer)) return false;
        o->exit_after = (uint32_t)integer;
        return true;
    case O_DEVICE:
        o->device = value;
        return true;
    case O_NO_CACHE:
        return o->no_cache = true;
    case O_VALIDATE:
        return o->validate = true;
    default:
        return false;
    }
}

int command_view(int argc, char **argv) {
    struct view_options o = {.frame = fnl_frame_default(), .world = world_options_default()};
    struct option long_options[OWN_COUNT + OPTIONS_NAMED_MAX];
    options_make_long(own_options, OWN_COUNT, false, long_options);
    optind = 0;
    for (int option; (option = getopt_long(argc, argv, "h", long_options, NULL)) != -1;) {
        const char *key = NULL;
        if (option == 'h') {
            print_help();
            return 0;
        }
        if (option == '?') {
            fputs("fanal: see 'fanal view --help'\n", stderr);
            return 2;
        }
        if (option >= OPTIONS_NAMED && options_named((uint32_t)(option - OPTIONS_NAMED), &key) && options_print_values(key, optarg)) return 0;
        if (!(world_has(option) ? world_parse(option, optarg, &o.world) : parse_option(&o, option, optarg))) return 2;
    }
    const char *problem = world_problem(&o.world);
    if (argc - optind > 1) problem = "one scene can be shown at once";
    if (o.headless && !o.replay) problem = "--headless needs --replay: there is no window that could say what to do";
    if (o.record && o.replay) problem = "--record and --replay exclude one another";
    if (problem) {
        fprintf(stderr, "fanal: error: %s; see 'fanal view --help'\n", problem);
        return 2;
    }
    o.world.scene = optind < argc ? argv[optind] : NULL;
    struct view *v = calloc(1, sizeof *v);
    if (!v) return 2;
    pthread_mutex_init(&v->messages.mutex, NULL);
    v->host = fnl_host_default();
    v->host.log = take_message;
    v->host.user = &v->messages;
    v->world = o.world;
    v->frame = v->usual = v->good = o.frame;
    v->own_shadows = o.own_shadows;
    v->drag = -1;
    v->part = 1;
    v->speed = 1;
    snprintf(v->save_path, sizeof v->save_path, "picture.png");
    const bool good = run(v, &o);
    fnl_swapchain_destroy(&v->swapchain);
    view_scene_free(&v->shown);
    fnl_device_destroy(&v->device);
    view_window_destroy(&v->window);
    pthread_mutex_destroy(&v->messages.mutex);
    free(v);
    return good ? 0 : 2;
}
