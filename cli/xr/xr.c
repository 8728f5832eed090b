/* SPDX-License-Identifier: MIT */
/* fanal xr: the options, and the sessions one after the other. */
#include "xr/xr.h"

#include "argument_next.h"
#include "arguments.h"
#include "commands.h"
#include "interrupt.h"
#include "options.h"
#include "print.h"
#include "progress.h"

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { MOST_LOSSES = 5 }; /* in a row, without a picture between them */

static void print_help(void) {
    puts("Usage: fanal xr SCENE [OPTIONS]\n"
         "\n"
         "Shows SCENE in a headset, through its OpenXR runtime. You stand where the scene's camera is. With a controller: the trigger goes\n"
         "where its ray meets the floor, the grip takes a light that it points at and moves it.\n"
         "\n"
         "Headset\n"
         "  --resolution auto|X        how much of the recommended size is rendered, 0.1 to 1 of either side (auto: 0.5 to 1, by frame time)\n"
         "  --budget MS                the time that a frame may take (the headset's)\n"
         "  --space stage|local        on the floor of the room, or where you sit (stage, if the headset has it)\n"
         "  --world-scale X            scene units per meter; 100 for a scene in centimeters (1)\n"
         "  --stereo                   two views, also where the runtime prefers four\n"
         "  --depth KIND               what is handed over with the picture, for runtimes that correct late frames: reversed (1 is near), forward\n"
         "                             or off (reversed)\n"
         "  --no-mask                  also renders what the lenses hide\n"
         "  --no-input                 without controllers\n"
         "  --no-gaze                  foveation (--shading coarse --set coarse.fovea=DEGREES) stays in the middle of the picture; otherwise it\n"
         "                             follows the eyes, if the headset tells where they look\n"
         "  --frames N                 ends after N frames (when you leave)\n"
         "  --stats FILE|-             writes numbers of the session as JSON: misses, times, predictions, states\n"
         "  --no-cache                 does not use the user's cache folder\n"
         "  --validate                 Vulkan validation; any message makes the command fail\n"
         "  -q, --quiet                prints nothing but warnings and errors\n"
         "  -h, --help                 prints this text\n"
         "\n"
         "Scene\n"
         WORLD_CAMERA_HELP
         "  --eye X,Y,Z --look-at X,Y,Z    where you stand at first, and where you look\n"
         "  --near METRES              from where on you see (0.05)\n"
         "  --exposure EV|auto|none    EV100 (auto: both eyes together)\n"
         WORLD_SURROUNDINGS_HELP);
    puts(WORLD_SCENE_HELP "\n"
         "Any option of 'fanal render' for the method can be given, such as --shading, --lists, --shadows, --msaa, --set KEY=VALUE.\n"
         "\n"
         "XR_RUNTIME_JSON names the runtime where several are installed. Ctrl-C ends the session as leaving it does.\n"
         "Exit status: 0, or 2 on an error.\n"
         "\n"
         "Examples:\n"
         "  fanal xr builtin:hall --lights 1000\n"
         "  fanal xr model.glb --environment builtin:sky --msaa 4");
}

enum {
    O_SET = 256,
    O_EXPOSURE,
    O_RESOLUTION,
    O_BUDGET,
    O_SPACE,
    O_WORLD_SCALE,
    O_STEREO,
    O_DEPTH,
    O_NO_MASK,
    O_NO_INPUT,
    O_NO_GAZE,
    O_FRAMES,
    O_STATS,
    O_NO_CACHE,
    O_VALIDATE
};

static const struct option own_options[] = {{"help", no_argument, NULL, 'h'},
                                            {"quiet", no_argument, NULL, 'q'},
                                            {"set", required_argument, NULL, O_SET},
                                            {"exposure", required_argument, NULL, O_EXPOSURE},
                                            {"resolution", required_argument, NULL, O_RESOLUTION},
                                            {"budget", required_argument, NULL, O_BUDGET},
                                            {"space", required_argument, NULL, O_SPACE},
                                            {"world-scale", required_argument, NULL, O_WORLD_SCALE},
                                            {"stereo", no_argument, NULL, O_STEREO},
                                            {"depth", required_argument, NULL, O_DEPTH},
                                            {"no-mask", no_argument, NULL, O_NO_MASK},
                                            {"no-input", no_argument, NULL, O_NO_INPUT},
                                            {"no-gaze", no_argument, NULL, O_NO_GAZE},
                                            {"frames", required_argument, NULL, O_FRAMES},
                                            {"stats", required_argument, NULL, O_STATS},
                                            {"no-cache", no_argument, NULL, O_NO_CACHE},
                                            {"validate", no_argument, NULL, O_VALIDATE},
                                            WORLD_OPTIONS};
enum { OWN_COUNT = sizeof own_options / sizeof *own_options };

struct given {
    bool shading, shadows;
};

static bool set_option(struct xr_options *o, struct given *given, const char *option, const char *key, const char *value) {
    given->shading |= strcmp(key, "shading") == 0;
    given->shadows |= strcmp(key, "shadows") == 0;
    return options_set(&o->frame, option, key, value);
}

static bool parse_option(struct xr_options *o, struct given *given, int option, const char *value) {
    long long integer;
    double number;
    const char *key = NULL, *name = option >= OPTIONS_NAMED ? options_named((uint32_t)(option - OPTIONS_NAMED), &key) : NULL;
    if (name) return set_option(o, given, name, key, value ? value : "on");
    switch (option) {
    case 'q':
        return o->quiet = true;
    case O_SET:
        if (!options_set_text(&o->frame, "set", value, &key)) return false;
        given->shading |= strcmp(key, "shading") == 0;
        given->shadows |= strcmp(key, "shadows") == 0;
        return true;
    case O_EXPOSURE:
        return argument_exposure("exposure", value, &o->frame.exposure, &o->frame.ev);
    case O_RESOLUTION:
        o->scale = 0;
        if (strcmp(value, "auto") == 0) return true;
        if (!argument_number("resolution", value, &number)) return false;
        o->scale = (float)number;
        return (number >= 0.1 && number <= 1) || argument_bad("resolution", value, "auto, or a number from 0.1 to 1");
    case O_BUDGET:
        if (!argument_number("budget", value, &o->budget)) return false;
        return (o->budget > 0 && o->budget <= 1e6) || argument_bad("budget", value, "a number of milliseconds above 0");
    case O_SPACE:
        o->space = strcmp(value, "stage") == 0 ? XR_REFERENCE_SPACE_TYPE_STAGE : XR_REFERENCE_SPACE_TYPE_LOCAL;
        return strcmp(value, "stage") == 0 || strcmp(value, "local") == 0 || argument_bad("space", value, "stage or local");
    case O_WORLD_SCALE:
        if (!argument_number("world-scale", value, &number)) return false;
        o->world_scale = (float)number;
        return (number >= 1e-4 && number <= 1e6) || argument_bad("world-scale", value, "a number from 0.0001 to 1e6");
    case O_STEREO:
        return o->stereo_only = true;
    case O_DEPTH:
        o->no_depth = strcmp(value, "off") == 0;
        o->forward_depth = strcmp(value, "forward") == 0;
        return o->no_depth || o->forward_depth || strcmp(value, "reversed") == 0 || argument_bad("depth", value, "reversed, forward or off");
    case O_NO_MASK:
        return o->no_mask = true;
    case O_NO_INPUT:
        return o->no_input = true;
    case O_NO_GAZE:
        return o->no_gaze = true;
    case O_FRAMES:
        if (!argument_integer("frames", value, 1, 1000000000, &integer)) return false;
        o->frame_count = (uint32_t)integer;
        return true;
    case O_STATS:
        o->stats = value;
        return true;
    case O_NO_CACHE:
        return o->no_cache = true;
    case O_VALIDATE:
        return o->validate = true;
    default:
        return false;
    }
}

/* ---- running ---- */

static void nap(long milliseconds) { nanosleep(&(struct timespec){.tv_sec = milliseconds / 1000, .tv_nsec = milliseconds % 1000 * 1000000}, NULL); }

static void leave(struct xr *x) {
    if (x->asked_exit || !x->running) {
        if (!x->running && interrupt_seen() && x->state != XR_SESSION_STATE_STOPPING && !x->asked_exit) x->end = XR_DONE; /* nothing is shown: nobody waits */
        return;
    }
    x->asked_exit = true;
    xr_good(x, "xrRequestExitSession", xrRequestExitSession(x->session));
}

/* Until the session ends, in one way or another. */
static void run_session(struct xr *x) {
    const uint32_t wanted = x->options->frame_count;
    while (x->end == XR_RUNS) {
        xr_take_events(x);
        if (x->end != XR_RUNS) return;
        if (interrupt_seen() || (wanted > 0 && x->numbers.rendered >= wanted)) leave(x);
        if (x->end != XR_RUNS) return;
        if (x->running) xr_run_frame(x);
        else nap(x->numbers.rendered ? 50 : 5);
    }
}

static bool load(struct xr *x) {
    progress_begin(x->options->quiet, PROGRESS_SECONDS);
    progress_show("loading the scene", 0, 0);
    const bool good = world_load(&x->options->world, &x->host, 1, 1, x->options->quiet, &x->scene, &x->home) && fnl_scene_query_info(x->scene, &x->scene_info) == FNL_OK;
    progress_end();
    if (x->options->world.near == 0) x->home.near_distance *= x->options->world_scale;
    return good;
}

/* A session that is lost is made anew, from the instance on: the runtime may have been started again, perhaps with another headset. */
static bool run(struct xr *x) {
    uint32_t rendered = 0, losses = 0;
    if (!load(x)) return false;
    interrupt_catch(true);
    for (;;) {
        if (xr_connect(x)) {
            if (!x->options->own_shadows) x->frame.shadows = world_usual_shadows(&x->scene_info, &x->device_info, true);
            run_session(x);
        }
        const enum xr_end end = x->end;
        xr_disconnect(x);
        if (end != XR_LOST || x->end == XR_FAILED) break;
        x->numbers.losses++;
        losses = x->numbers.rendered > rendered ? 1 : losses + 1;
        rendered = x->numbers.rendered;
        if (losses > MOST_LOSSES || interrupt_seen()) {
            fprintf(stderr, "fanal: error: the OpenXR session was lost %u times in a row\n", losses);
            x->end = XR_FAILED;
            break;
        }
        fputs("fanal: warning: the session was lost: it is begun anew\n", stderr);
        nap(20l << (2 * losses));
    }
    interrupt_catch(false);
    if (x->end != XR_DONE) return false;
    if (!x->options->quiet && !(x->options->stats && strcmp(x->options->stats, "-") == 0)) xr_print(x);
    return !x->options->stats || xr_save_stats(x);
}

int command_xr(int argc, char **argv) {
    struct xr_options o = {.frame = fnl_frame_default(),
                           .world = world_options_default(),
                           .space = XR_REFERENCE_SPACE_TYPE_VIEW,
                           .world_scale = 1};
    struct given given = {false, false};
    struct option long_options[OWN_COUNT + OPTIONS_NAMED_MAX];
    options_make_long(own_options, OWN_COUNT, false, long_options);
    optind = 0;
    for (int option; (option = argument_next(argc, argv, "hq", long_options)) != -1;) {
        const char *key = NULL;
        if (option == 'h') {
            print_help();
            return 0;
        }
        if (option == '?') return 2;
        if (option >= OPTIONS_NAMED && options_named((uint32_t)(option - OPTIONS_NAMED), &key) && options_print_values(key, optarg)) return 0;
        if (!(world_has(option) ? world_parse(option, optarg, &o.world) : parse_option(&o, &given, option, optarg))) return 2;
    }
    const char *problem = world_problem(&o.world);
    if (argc - optind != 1) problem = "one scene is needed";
    if (o.world.fov > 0) problem = "--fov does not go with a headset, which has its own";
    if (problem) {
        fprintf(stderr, "fanal: error: %s; see 'fanal xr --help'\n", problem);
        return 2;
    }
    o.world.scene = argv[optind];
    world_set_frame(&o.world, &o.frame);
    o.own_shadows = given.shadows;
    struct xr *x = calloc(1, sizeof *x);
    if (!x) return 2;
    x->options = &o;
    x->host = fnl_host_default();
    x->frame = o.frame;
    x->ev = o.frame.exposure == FNL_EXPOSURE_EV ? o.frame.ev : 0;
    x->scale = o.scale > 0 ? o.scale : 1;
    x->numbers.least_scale = x->scale;
    const bool good = run(x);
    fnl_scene_destroy(&x->scene);
    if (x->vulkan_library) dlclose(x->vulkan_library);
    free(x);
    return good ? 0 : 2;
}
