/* SPDX-License-Identifier: MIT */
/* fanal view: shows a scene in a window. */
#include "view/view.h"

#include "argument_next.h"
#include "arguments.h"
#include "commands.h"
#include "interrupt.h"
#include "options.h"
#include "output.h"
#include "print.h"
#include "view/ui.h"

#include "fanal/vulkan.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct view_options {
    struct world_options world;
    fnl_frame frame;
    const char *device, *replay, *record, *compare;
    uint32_t exit_after; /* frames; 0: never */
    bool headless, validate, no_cache, own_shadows, no_settings;
    /* Instead of what is remembered. */
    bool has_size, has_scale, has_present, has_color, light, dark, no_panels;
    double scale; /* 0: the screen's */
    uint32_t present, color;
    char arguments[VIEW_ARGUMENTS], light_arguments[VIEW_ARGUMENTS], environment_arguments[VIEW_ARGUMENTS];
};

static void print_help(void) {
    puts("Usage: fanal view [SCENE] [OPTIONS]\n"
         "\n"
         "Shows SCENE, a .gltf or .glb file or builtin:NAME, in a window; without one, what is dropped into it. F1 lists the keys.\n"
         "\n"
         "Window\n"
         "  --size WxH                 pixels (1280x720)\n"
         "  --scale X|auto             size of text and spacing, 0.5 to 4 (auto: the screen's)\n"
         "  --dark, --light            light letters on dark panels, or the other way round (dark)\n"
         "  --no-panels                begins without toolbar and panels (Tab shows them)\n"
         "  --present MODE             fifo (waits for the screen), mailbox (the newest picture, does not wait), immediate (with tearing) (fifo)\n"
         "  --color SPACE              srgb, scrgb or hdr10; srgb where the screen has nothing else (srgb)\n"
         "  --no-settings              neither reads nor writes what windows remember: these options, their size, the last scenes\n"
         "  --compare KEY=VALUE[,...]  begins with a split screen: left as asked for, right with these options changed\n"
         "  --headless                 draws the same frames without a window; with --replay\n"
         "  --replay FILE              reads events, one per line, from a file written by --record or from - (standard input); in addition to window events:\n"
         "                             'frames N', 'settle', 'set KEY=VALUE', 'click LABEL', 'save FILE [W H]', 'capture FILE' (with the panels), 'command FILE', 'report FILE',\n"
         "                             'trace FILE', 'savescene FILE', 'turntable N', 'panel NAME', 'compare MODE', 'setb KEY=VALUE', 'slider X', 'poll'\n"
         "  --record FILE              writes the events of the window to a file\n"
         "  --exit-after N             ends after N frames of the scene and prints how often the window was drawn\n"
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

/* ---- with a window ---- */

static bool run_window(struct view *v, const struct view_options *o) {
    struct output out;
    if (o->record && !output_begin(o->record, &out)) return false;
    FILE *record = o->record ? out.stream : NULL;
    double last = view_now();
    bool good = true;
    while (!v->quit && good && !interrupt_seen() && (o->exit_after == 0 || v->loader.running || v->frames_drawn < o->exit_after + v->frames_loading)) {
        struct view_event event;
        const bool idle = v->wanted == 0 && v->queue.count == 0;
        const double rest = view_window_has_gamepad(v->window) ? 0.05 : 0.5; /* sticks do not wake */
        view_window_poll(v->window, v->screen.is_drawing ? 0.004 : idle ? (v->part < 1 ? fmin(rest, 0.15) : rest) : v->loader.running || v->pending > 0 ? 0.03 : 0);
        if (idle && !v->screen.is_drawing && v->queue.count == 0 && v->part < 1) { /* it has come to rest: now as fine as the window */
            v->part = 1;
            view_want(v, 1);
        }
        v->moving = false;
        trace_mark(v->timeline.history, "events");
        for (bool enough = false; good && !enough && view_queue_take(&v->queue, &event);) {
            if (record) view_event_write(record, &event);
            good = view_feed(v, &event, &enough);
        }
        if (o->exit_after) view_want(v, 1);
        const double time = view_now(), seconds = fmin(time - last, 0.1);
        last = time;
        view_advance(v, seconds);
        view_watch(v);
        if (!view_collect(v)) good = false;
        if (good && v->wanted == 0) {
            trace_end_frame(v->timeline.history, NULL, 0);
            continue;
        }
        good = good && view_draw_frame(v, seconds);
        if (record) fputs("frames 1\n", record);
    }
    return (!record || output_commit(&out)) && good;
}

/* ---- the command ---- */

static bool open_device(struct view *v, const struct view_options *o) {
    fnl_device_params *params = &v->device.params;
    *params = fnl_device_params_default();
    params->host = v->host;
    params->validate = o->validate;
    params->presentation = v->window != NULL;
    if (o->no_cache) params->cache_folder = "";
    argument_device(o->device, params);
    return fnl_device_create(params, &v->device.device) == FNL_OK && fnl_device_query_info(v->device.device, &v->device.info) == FNL_OK &&
           (!v->window || view_window_open_swapchain(v->window, v->device.device, v->settings.present, v->settings.color, &v->swapchain));
}

/* What is remembered, and what the command line says instead. */
static void choose_settings(struct view *v, const struct view_options *o) {
    struct view_settings *s = &v->settings;
    v->remembers = !o->headless && !o->replay && !o->no_settings;
    *s = view_settings_default();
    if (v->remembers) view_settings_load(s);
    if (o->has_size) {
        s->width = o->frame.width;
        s->height = o->frame.height;
    }
    if (o->has_scale) s->scale = (float)o->scale;
    if (o->has_present) s->present = o->present;
    if (o->has_color) s->color = o->color;
    s->dark = o->light ? false : o->dark ? true : s->dark;
    v->hides_panels = o->no_panels || !s->panels;
    snprintf(v->arguments, sizeof v->arguments, "%s", o->arguments);
    snprintf(v->light_arguments, sizeof v->light_arguments, "%s", o->light_arguments);
    snprintf(v->asked_for, sizeof v->asked_for, "%s", o->world.scene ? o->world.scene : "");
    snprintf(v->environment_arguments, sizeof v->environment_arguments, "%s", o->environment_arguments);
}

static void remember(struct view *v) {
    if (!v->remembers) return;
    const float scale = view_window_scale(v->window);
    if (v->width > 0 && v->height > 0) {
        v->settings.width = (uint32_t)lroundf((float)v->width / scale);
        v->settings.height = (uint32_t)lroundf((float)v->height / scale);
    }
    v->settings.panels = !v->hides_panels;
    view_settings_save(&v->settings);
}

static bool run(struct view *v, const struct view_options *o) {
    choose_settings(v, o);
    v->width = v->settings.width;
    v->height = v->settings.height;
    if (!o->headless && !view_window_create(v->width, v->height, "Fanal", &v->queue, &v->window)) return false;
    if (v->window) view_window_query_size(v->window, &v->width, &v->height);
    v->scale = v->settings.scale > 0 ? v->settings.scale : v->window ? view_window_scale(v->window) : 1;
    if (!open_device(v, o)) return false;
    if (!ui_create(v->scale, v->settings.dark)) {
        fputs("fanal: error: memory ran out\n", stderr);
        return false;
    }
    if (!view_screen_adapt(v)) return false;
    struct view_scene nothing = {0}; /* for the panels, until there is something */
    if (fnl_scene_create(&v->host, &nothing.scene) != FNL_OK || fnl_scene_query_info(nothing.scene, &nothing.info) != FNL_OK ||
        fnl_renderer_create(v->device.device, nothing.scene, &nothing.renderer) != FNL_OK) {
        view_scene_free(&nothing);
        return false;
    }
    nothing.camera = fnl_camera_default();
    view_show(v, &nothing);
    if (o->world.scene) view_open(v, o->world.scene);
    if (!o->replay) interrupt_catch(true); /* Ctrl-C closes the window as its button does: settings and a recording are kept */
    bool good = o->replay ? view_replay(v, o->replay, o->exit_after) : run_window(v, o);
    view_loader_stop(&v->loader);
    if (!o->replay && (o->exit_after || interrupt_seen()))
        printf("%llu frames of the scene in %llu pictures of the window\n", (unsigned long long)(v->frames_drawn - v->frames_loading), (unsigned long long)v->screen.shown);
    remember(v);
    view_compare_leave(v);
    fnl_renderer_destroy(&v->shown.renderer);
    const unsigned long long messages = view_screen_finish(v) + fnl_device_validation_count(v->device.device);
    if (good && o->validate && messages) {
        fprintf(stderr, "fanal: error: Vulkan validation sent %llu messages\n", messages);
        good = false;
    }
    ui_destroy();
    return good;
}

enum { O_SIZE = 256, O_SET, O_EXPOSURE, O_SCALE, O_DARK, O_LIGHT, O_PRESENT, O_COLOR, O_NO_SETTINGS, O_NO_PANELS, O_COMPARE, O_HEADLESS, O_REPLAY, O_RECORD, O_EXIT_AFTER, O_DEVICE,
       O_NO_CACHE, O_VALIDATE };

static const struct option own_options[] = {{"help", no_argument, NULL, 'h'},
                                            {"size", required_argument, NULL, O_SIZE},
                                            {"set", required_argument, NULL, O_SET},
                                            {"exposure", required_argument, NULL, O_EXPOSURE},
                                            {"scale", required_argument, NULL, O_SCALE},
                                            {"light", no_argument, NULL, O_LIGHT},
                                            {"dark", no_argument, NULL, O_DARK},
                                            {"present", required_argument, NULL, O_PRESENT},
                                            {"color", required_argument, NULL, O_COLOR},
                                            {"no-settings", no_argument, NULL, O_NO_SETTINGS},
                                            {"no-panels", no_argument, NULL, O_NO_PANELS},
                                            {"compare", required_argument, NULL, O_COMPARE},
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

/* One of three names. */
static bool parse_name(const char *option, const char *value, const char *const names[3], bool *out_has, uint32_t *out) {
    for (*out = 0; *out < 3 && strcmp(value, names[*out]) != 0;) ++*out;
    char text[64];
    snprintf(text, sizeof text, "%s, %s or %s", names[0], names[1], names[2]);
    return (*out_has = *out < 3) || argument_bad(option, value, text);
}

static bool parse_option(struct view_options *o, int option, const char *value) {
    long long integer;
    const char *key = NULL, *name = option >= OPTIONS_NAMED ? options_named((uint32_t)(option - OPTIONS_NAMED), &key) : NULL;
    if (name) return set_option(o, name, key, value ? value : "on");
    switch (option) {
    case O_SIZE:
        o->has_size = true;
        return argument_size("size", value, &o->frame.width, &o->frame.height);
    case O_SET:
        if (!options_set_text(&o->frame, "set", value, &key)) return false;
        o->own_shadows = o->own_shadows || strcmp(key, "shadows") == 0;
        return true;
    case O_EXPOSURE:
        return argument_exposure("exposure", value, &o->frame.exposure, &o->frame.ev);
    case O_SCALE:
        o->has_scale = true;
        if (strcmp(value, "auto") == 0) return true;
        if (!argument_number("scale", value, &o->scale)) return false;
        return (o->scale >= 0.5 && o->scale <= 4) || argument_bad("scale", value, "auto, or a number from 0.5 to 4");
    case O_LIGHT:
        return o->light = true;
    case O_DARK:
        return o->dark = true;
    case O_PRESENT:
        return parse_name("present", value, view_present_names, &o->has_present, &o->present);
    case O_COLOR:
        return parse_name("color", value, view_color_names, &o->has_color, &o->color);
    case O_NO_SETTINGS:
        return o->no_settings = true;
    case O_NO_PANELS:
        return o->no_panels = true;
    case O_COMPARE:
        o->compare = value;
        return true;
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

/* For the command that renders the picture: what it says of the scene, but for what it sees of it and when. */
static void note_argument(struct view_options *o, const struct option *long_options, int option, const char *value) {
    static const int seen[] = {WORLD_CAMERA, WORLD_EYE, WORLD_LOOK_AT, WORLD_FOV, WORLD_NEAR, WORLD_UP, WORLD_TIME, WORLD_ANIMATION};
    for (size_t i = 0; i < sizeof seen / sizeof *seen; i++)
        if (seen[i] == option) return;
    const bool environment = option >= WORLD_ENVIRONMENT && option <= WORLD_ENVIRONMENT_COMPRESSED;
    const bool lights = option >= WORLD_LIGHTS && option <= WORLD_LIGHT_SCALE;
    char *text = environment ? o->environment_arguments : lights ? o->light_arguments : o->arguments;
    const size_t used = strlen(text);
    const struct option *row = long_options;
    while (row->val != option) row++;
    char *word = value ? print_shell_word(value) : NULL;
    const int length = snprintf(text + used, VIEW_ARGUMENTS - used, word ? " --%s %s" : " --%s", row->name, word);
    if ((value && !word) || used + (size_t)length >= VIEW_ARGUMENTS) text[used] = 0; /* no part of an option */
    free(word);
}

int command_view(int argc, char **argv) {
    struct view_options o = {.frame = fnl_frame_default(), .world = world_options_default()};
    struct option long_options[OWN_COUNT + OPTIONS_NAMED_MAX];
    options_make_long(own_options, OWN_COUNT, false, long_options);
    optind = 0;
    for (int option; (option = argument_next(argc, argv, "h", long_options)) != -1;) {
        const char *key = NULL;
        if (option == 'h') {
            print_help();
            return 0;
        }
        if (option == '?') return 2;
        if (option >= OPTIONS_NAMED && options_named((uint32_t)(option - OPTIONS_NAMED), &key) && options_print_values(key, optarg)) return 0;
        if (world_has(option)) note_argument(&o, long_options, option, optarg);
        if (!(world_has(option) ? world_parse(option, optarg, &o.world) : parse_option(&o, option, optarg))) return 2;
    }
    const char *problem = world_problem(&o.world);
    if (argc - optind > 1) problem = "one scene can be shown at once";
    if (o.headless && !o.replay) problem = "--headless needs --replay: there is no window that could say what to do";
    if (o.record && o.replay) problem = "--record and --replay cannot be combined";
    if (problem) {
        fprintf(stderr, "fanal: error: %s; see 'fanal view --help'\n", problem);
        return 2;
    }
    world_set_frame(&o.world, &o.frame);
    o.world.scene = optind < argc ? argv[optind] : NULL;
    struct view *v = calloc(1, sizeof *v);
    if (!v) return 2;
    pthread_mutex_init(&v->messages.mutex, NULL);
    pthread_mutexattr_t recursive;
    pthread_mutexattr_init(&recursive);
    pthread_mutexattr_settype(&recursive, PTHREAD_MUTEX_RECURSIVE);
    pthread_mutex_init(&v->device.mutex, &recursive);
    pthread_mutexattr_destroy(&recursive);
    v->host = fnl_host_default();
    v->host.log = view_take_message;
    v->host.user = &v->messages;
    v->world = o.world;
    v->frame = v->usual = v->good = o.frame;
    v->surroundings.params = fnl_environment_params_default();
    v->own_shadows = o.own_shadows;
    v->replays = o.replay != NULL;
    v->drag = v->select.gizmo.held = -1;
    v->part = 1;
    v->speed = 1;
    snprintf(v->save_path, sizeof v->save_path, "picture.png");
    snprintf(v->timeline.trace_path, sizeof v->timeline.trace_path, "trace.json");
    v->timeline.history = trace_create(); /* without one there is no timeline */
    v->timeline.zoom = 1;
    view_files_init(&v->files);
    const bool good = view_compare_start(v, o.compare) && run(v, &o);
    view_select_free(v);
    fnl_image_free(&v->host, &v->thumbnails.image);
    view_files_finish(v);
    view_scene_free(&v->shown);
    fnl_device_destroy(&v->device.device);
    view_window_destroy(&v->window);
    pthread_mutex_destroy(&v->messages.mutex);
    pthread_mutex_destroy(&v->device.mutex);
    view_timeline_finish(v);
    free(v);
    return good ? 0 : 2;
}
