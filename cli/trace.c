/* SPDX-License-Identifier: MIT */
/* fanal trace: traces a scene with rays on the CPU, and writes the picture. */
#include "argument_next.h"
#include "arguments.h"
#include "commands.h"
#include "interrupt.h"
#include "output.h"
#include "print.h"
#include "progress.h"
#include "world.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

enum { MOST_OUTPUTS = 16, EXIT_INTERRUPTED = 130 };

struct trace_options {
    struct world_options world;
    fnl_trace_params params;
    const char *outputs[MOST_OUTPUTS];
    int output_count;
    uint32_t threads; /* 0: as many as there are processors */
    bool quiet;
};

static void print_help(void) {
    puts("Usage: fanal trace SCENE -o OUT.png|OUT.exr [-o ...] [OPTIONS]\n"
         "\n"
         "Traces SCENE with rays on the CPU, without a GPU: the truth that rendered pictures are measured against. Without\n"
         "--bounces it traces the light of the lights, with exact shadows; with them all light, by following its paths. A .png\n"
         "holds the tone-mapped picture, an .exr linear radiance in cd/m^2. Defaults are in brackets.\n"
         "\n"
         "Picture\n"
         "  -o, --output FILE          the file to write; can be given several times\n"
         "  --size WxH                 pixels (1280x720)\n" WORLD_CAMERA_HELP WORLD_EYE_HELP
         "  --exposure EV|auto|none    EV100 (auto)\n"
         "  --tonemap KIND             none, khronos-neutral, aces or agx (khronos-neutral)\n" WORLD_SURROUNDINGS_HELP
         "  --aov visibility           one more channel in the .exr, visibility.Y: which part of the lights' light shadows\n"
         "                             leave, 0 to 1\n"
         "\n"
         "Light\n"
         "  --samples N                rays per pixel; the first goes through its centre (1)\n"
         "  --bounces N                how often light is reflected before it meets what is seen (0: ambient light is that of\n"
         "                             'fanal render'; from 1 on it comes from the sky, and is shadowed)\n"
         "  --shadows on|off           (on)\n"
         "  --light-radius METRES      radius of all lights: above 0 shadows are soft, and need samples (that of each light)\n"
         "  --sun-angle DEGREES        the same for directional lights and boxes: half the angle that they fill\n"
         "  --roulette                 ends long paths by chance: the same mean in less time, with more noise\n"
         "  --light-sampling on|off    send rays to bright parts of the environment and to glowing surfaces (on): the same\n"
         "                             mean with less noise\n"
         "  --energy MODEL             energy model: gltf or conserving (gltf)\n"
         "  --seed S                   the random seed (1)\n");
    puts("Scene\n" WORLD_SCENE_HELP "\n"
         "Run\n"
         "  --threads N                threads that trace, 1 to 256 (as many as there are processors); the picture is the same\n"
         "  -q, --quiet                prints nothing but errors\n"
         "  -h, --help                 prints this text\n");
    puts("Ctrl-C ends it early; what was traced until then is written.\n"
         "Exit status: 0 when everything was traced and written, 130 when it was interrupted, 2 on an error, after which no\n"
         "output file is left behind.\n"
         "\n"
         "Examples:\n"
         "  fanal trace builtin:hall --lights 500 --size 640x360 -o truth.exr\n"
         "  fanal trace builtin:interior --samples 256 --bounces 4 -o interior.png\n"
         "  fanal trace builtin:hall --light-radius 0.1 --samples 64 --aov visibility -o soft.exr");
}

/* ---- reading arguments ---- */

enum {
    O_SIZE = 256,
    O_EXPOSURE,
    O_TONEMAP,
    O_AOV,
    O_SAMPLES,
    O_BOUNCES,
    O_SHADOWS,
    O_LIGHT_RADIUS,
    O_SUN_ANGLE,
    O_ROULETTE,
    O_LIGHT_SAMPLING,
    O_ENERGY,
    O_SEED,
    O_THREADS,
};

static bool has_extension(const char *path, const char *extension) {
    const char *dot = strrchr(path, '.');
    return dot && strcasecmp(dot + 1, extension) == 0;
}

static const char *tonemap_name(int value) { return fnl_value_name(FNL_ENUM_TONEMAP, (uint32_t)value); }
static const char *energy_name(int value) { return fnl_value_name(FNL_ENUM_ENERGY, (uint32_t)value); }
static const char *switch_name(int value) { return value == 0 ? "off" : value == 1 ? "on" : NULL; }
static const char *aov_name(int value) { return value == 0 ? "visibility" : NULL; }

static bool parse_option(struct trace_options *o, int option, const char *value) {
    fnl_trace_params *p = &o->params;
    long long integer = 0;
    double number = 0;
    int index = 0;
    bool good = true;
    switch (option) {
    case 'o':
        if (!has_extension(value, "png") && !has_extension(value, "exr"))
            return argument_bad("output", value, "a file that ends in .png or .exr");
        if (o->output_count == MOST_OUTPUTS) return argument_bad("output", value, "among the first 16 outputs");
        o->outputs[o->output_count++] = value;
        break;
    case 'q':
        o->quiet = true;
        break;
    case O_SIZE:
        good = argument_size("size", value, &p->width, &p->height);
        break;
    case O_EXPOSURE:
        good = argument_exposure("exposure", value, &p->exposure, &p->ev);
        break;
    case O_TONEMAP:
        good = argument_name("tonemap", value, tonemap_name, &index);
        p->tonemap = (fnl_tonemap)index;
        break;
    case O_AOV:
        good = p->visibility = argument_name("aov", value, aov_name, &index);
        break;
    case O_SAMPLES:
        good = argument_integer("samples", value, 1, 1048576, &integer);
        p->samples = (uint32_t)integer;
        break;
    case O_BOUNCES:
        good = argument_integer("bounces", value, 0, 1024, &integer);
        p->bounces = (uint32_t)integer;
        break;
    case O_SHADOWS:
        good = argument_name("shadows", value, switch_name, &index);
        p->shadows = index == 1;
        break;
    case O_LIGHT_RADIUS:
        good = argument_number("light-radius", value, &number) &&
               ((number >= 0 && number <= 1e6) || argument_bad("light-radius", value, "a length in metres, 0 or more"));
        p->light_radius = (float)number;
        break;
    case O_SUN_ANGLE:
        good = argument_number("sun-angle", value, &number) &&
               ((number >= 0 && number <= 57) || argument_bad("sun-angle", value, "an angle from 0 to 57 degrees"));
        p->sun_angle = (float)(number * 3.14159265358979323846 / 180);
        break;
    case O_ROULETTE:
        p->russian_roulette = true;
        break;
    case O_LIGHT_SAMPLING:
        good = argument_name("light-sampling", value, switch_name, &index);
        p->light_sampling = index == 1;
        break;
    case O_ENERGY:
        good = argument_name("energy", value, energy_name, &index);
        p->energy = (fnl_energy)index;
        break;
    case O_SEED:
        good = argument_integer("seed", value, 0, INT64_MAX, &integer);
        p->seed = (uint64_t)integer;
        break;
    case O_THREADS:
        good = argument_integer("threads", value, 1, 256, &integer);
        o->threads = (uint32_t)integer;
        break;
    default:
        return false;
    }
    return good;
}

static const struct option long_options[] = {
    {"output", required_argument, NULL, 'o'},
    {"quiet", no_argument, NULL, 'q'},
    {"help", no_argument, NULL, 'h'},
    {"size", required_argument, NULL, O_SIZE},
    {"exposure", required_argument, NULL, O_EXPOSURE},
    {"tonemap", required_argument, NULL, O_TONEMAP},
    {"aov", required_argument, NULL, O_AOV},
    {"samples", required_argument, NULL, O_SAMPLES},
    {"bounces", required_argument, NULL, O_BOUNCES},
    {"shadows", required_argument, NULL, O_SHADOWS},
    {"light-radius", required_argument, NULL, O_LIGHT_RADIUS},
    {"sun-angle", required_argument, NULL, O_SUN_ANGLE},
    {"roulette", no_argument, NULL, O_ROULETTE},
    {"light-sampling", required_argument, NULL, O_LIGHT_SAMPLING},
    {"energy", required_argument, NULL, O_ENERGY},
    {"seed", required_argument, NULL, O_SEED},
    {"threads", required_argument, NULL, O_THREADS},
    WORLD_OPTIONS,
    {0},
};

static bool check_options(const struct trace_options *o) {
    const char *problem = world_problem(&o->world);
    bool has_exr = false;
    for (int i = 0; i < o->output_count; i++) has_exr = has_exr || has_extension(o->outputs[i], "exr");
    if (o->output_count == 0) problem = "no output was asked for: give -o FILE";
    if (o->params.visibility && !has_exr) problem = "--aov needs an .exr output";
    if (problem) fprintf(stderr, "fanal: error: %s; see 'fanal trace --help'\n", problem);
    for (int i = 0; !problem && i < o->output_count; i++)
        for (int k = i + 1; k <= o->output_count; k++) {
            const char *other = k < o->output_count ? o->outputs[k] : o->world.scene;
            if (!output_is_same(o->outputs[i], other)) continue;
            fprintf(stderr, "fanal: error: %s and %s are one file%s\n", o->outputs[i], other,
                    k < o->output_count ? ", which would be written twice" : ": the scene would be overwritten");
            return false;
        }
    for (int i = 0; !problem && i < o->output_count; i++)
        if (!output_check(o->outputs[i])) return false;
    return !problem;
}

/* ---- tracing ---- */

static bool show_progress(void *user, uint64_t done, uint64_t total) {
    (void)user;
    const uint64_t steps = total < 1000 ? total : 1000; /* of a thousandth each: tiles and samples say less */
    progress_show("tracing", (uint32_t)((double)done / (double)total * (double)steps), (uint32_t)steps);
    return !interrupt_seen();
}

static bool save(const struct trace_options *o, const fnl_host *host, const fnl_trace *trace, const char *path) {
    if (has_extension(path, "png")) return fnl_image_save(host, path, &trace->color) == FNL_OK;
    const float *radiance = trace->radiance.pixels;
    const fnl_exr_channel channels[] = {{"R", radiance, 4},
                                        {"G", radiance + 1, 4},
                                        {"B", radiance + 2, 4},
                                        {"A", radiance + 3, 4},
                                        {"visibility.Y", trace->visibility.pixels, 4}};
    return fnl_exr_save(host, path, trace->radiance.width, trace->radiance.height, channels, o->params.visibility ? 5 : 4) ==
           FNL_OK;
}

static void print_summary(const struct trace_options *o, const fnl_trace *trace, double seconds) {
    const fnl_trace_params *p = &o->params;
    printf("%u x %u, %u sample%s, %u bounce%s: %" PRIu64 " rays in %.1f s, %.2f million a second\n", p->width, p->height,
           p->samples, p->samples == 1 ? "" : "s", p->bounces, p->bounces == 1 ? "" : "s", trace->ray_count, seconds,
           seconds > 0 ? 1e-6 * (double)trace->ray_count / seconds : 0);
    if (p->exposure != FNL_EXPOSURE_NONE) printf("exposure EV100 %.2f\n", (double)trace->ev);
    if (trace->unseen)
        printf("%u primitives of lines or points, or decals that are not baked, are missing: rays do not see them\n",
               trace->unseen);
}

static int run(struct trace_options *o) {
    fnl_host host = fnl_host_default();
    host.thread_count = o->threads;
    fnl_scene *scene = NULL;
    fnl_trace trace = {0};
    progress_begin(o->quiet, PROGRESS_SECONDS);
    progress_show("loading the scene", 0, 0);
    bool good = world_load(&o->world, &host, o->params.width, o->params.height, o->quiet, &scene, &o->params.camera);
    world_set_trace(&o->world, &o->params);
    o->params.progress = show_progress;
    interrupt_catch(true);
    progress_show("preparing the scene", 0, 0);
    const double begun = progress_seconds();
    good = good && fnl_scene_trace(scene, &o->params, &trace) == FNL_OK;
    interrupt_catch(false);
    progress_end();
    if (good && !trace.complete) fputs("fanal: interrupted: the picture is that of what was traced until now\n", stderr);
    if (good && !o->quiet) print_summary(o, &trace, progress_seconds() - begun);
    good = good && output_flush(); /* before anything is written: all or nothing */
    for (int i = 0; i < o->output_count && good; i++) {
        good = save(o, &host, &trace, o->outputs[i]);
        for (int k = 0; !good && k < i; k++) unlink(o->outputs[k]);
    }
    for (int i = 0; i < o->output_count && good && !o->quiet; i++) printf("wrote %s\n", o->outputs[i]);
    const bool complete = trace.complete;
    fnl_trace_free(&host, &trace);
    fnl_scene_destroy(&scene);
    return !good ? 2 : complete ? 0 : EXIT_INTERRUPTED;
}

int command_trace(int argc, char **argv) {
    struct trace_options o = {.world = world_options_default(), .params = fnl_trace_params_default()};
    optind = 0;
    for (int option; (option = argument_next(argc, argv, "o:qh", long_options)) != -1;) {
        if (option == 'h') {
            print_help();
            return 0;
        }
        if (option == '?') return 2;
        if (!(world_has(option) ? world_parse(option, optarg, &o.world) : parse_option(&o, option, optarg))) return 2;
    }
    if (argc - optind != 1) {
        fprintf(stderr, "fanal: error: one scene is needed, %d were given; see 'fanal trace --help'\n", argc - optind);
        return 2;
    }
    o.world.scene = argv[optind];
    return check_options(&o) ? run(&o) : 2;
}
