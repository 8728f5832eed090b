/* SPDX-License-Identifier: MIT */
/* fanal bench: reads what to measure, makes the plan of it, and brings the parts together. */
#include "bench.h"

#include "argument_next.h"
#include "arguments.h"
#include "commands.h"
#include "loading.h"
#include "options.h"
#include "print.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { LIGHTS_MAX = 1 << 20, COMBINATIONS_MAX = 1 << 20 };

struct bench_options {
    struct bench_settings settings;
    const struct bench_suite *suite;
    struct bench_matrix matrix;
    bool all; /* every order and every kind of lists, where none is named */
};

static const char *shading_name(int i) { return fnl_value_name(FNL_ENUM_SHADING, (uint32_t)i); }
static const char *lists_name(int i) { return fnl_value_name(FNL_ENUM_LISTS, (uint32_t)i); }

static void print_names(const char *(*name_of)(int)) {
    for (int i = 0; name_of(i); i++) printf(" %s", name_of(i));
    putchar('\n');
}

static void print_help(void) {
    puts("Usage: fanal bench SCENE... -o DIR [OPTIONS]\n"
         "       fanal bench --suite NAME [SCENE...] -o DIR [OPTIONS]\n"
         "\n"
         "Renders each SCENE (see 'fanal render --help') with every requested combination of shading path, light list and\n"
         "options, one frame of each in turn. Compares all pictures with brute force, and writes DIR/results.csv, results.json\n"
         "and report.html, a page with plots that needs no network.\n"
         "\n"
         "What is compared (values are separated by commas). Without --shading and --lists: the likely pairs, which are the ones\n"
         "that '--shading auto --lists auto' would measure for this number of lights, plus brute force up to 4096 lights\n"
         "  --shading KINDS|all        shading paths (the likely ones)\n"
         "  --lists KINDS|all          light lists; 'all' means every kind (the likely ones)\n"
         "  --all                      every shading path with every kind of lists: hundreds of pairs, an hour on a CPU;\n"
         "                             with --suite shadows: more lights as well\n"
         "  --lights N,...             lights in total in a built-in scene (its own); a file gets N more\n"
         "  --sizes WxH,...            pixels (1280x720; on a CPU 640x360)\n"
         "  --msaa N,...               samples per pixel: 1 2 4 8 (1)\n"
         "  --shadows KINDS|all        shadow methods, a separate case each (off, and maps if there are lights)\n"
         "  --energy, --transparency, --decals, --gbuffer, --msaa-method, --aa, --cull, --geometry, --occlusion VALUES|all\n"
         "                             options of the same names in 'fanal render'\n"
         "  --ideal                    adds fine-pruned lists to each path where it can use them: their frame without the time to\n"
         "                             build them is the ideal, and every time is printed as a multiple of it too\n"
         "  --vary KEY=VALUES|all      any option of a frame, such as tiles.size=8,16,32; can be given several times.\n"
         "                             'fanal render --options' prints them; a path or list that ignores it is measured once\n"
         "  --set KEY=VALUE            an option for all combinations; can be given several times\n"
         "  --suite NAME               repeats the experiments of a publication and prints its ratios beside ours; the suites\n"
         "                             geometry and visibility only preset scenes and options, which may be overridden\n"
         "\n"
         "Scenes\n" LOADING_VARIANT_HELP
         "  --environment FILE         lights all scenes by a panorama, builtin:studio, builtin:sky or builtin:overcast\n" LOADING_HELP
         "\n"
         "View\n"
         "  --camera NAME|INDEX        a camera of the scene (its first one, else one that frames the scene)\n"
         "  --camera-path KIND|FILE    moves the camera, one point of the path per frame: orbit or turntable (:N sets the points\n"
         "                             per turn), or a file with lines 'seconds eye.x eye.y eye.z target.x target.y target.z'\n"
         "  --stereo                   two eyes in place of the camera, 63.5 mm apart\n"
         "  --hmd FILE                 with --stereo: those of a headset, as in 'fanal render'\n");
    puts("Run\n"
         "  -o, --output DIR           folder for the results, created if missing; if it holds results, give --resume or --overwrite\n"
         "  --frames N                 timed frames per combination (10; on a CPU 4; up to four times as many where other\n"
         "                             programs disturb them)\n"
         "  --warm-up N                untimed frames before them (2)\n"
         "  --checks N                 points of the path at which pictures are compared; 0: none (1, with a path 3)\n"
         "  --reference KIND           the lists whose picture the others are compared with (brute-force)\n"
         "  --resume                   continues with DIR: measures only what is missing there\n"
         "  --overwrite                replaces the results in DIR\n"
         "  --device INDEX|NAME        one of those that 'fanal devices' lists (the best)\n"
         "  --no-cache                 does not use the user's cache folder, which keeps compiled pipelines and what auto chose\n"
         "  --validate                 Vulkan validation (slow, times mean little); any message makes the command fail\n"
         "  -q, --quiet                prints nothing but errors\n"
         "  -h, --help                 prints this text\n");
    fputs("Shading paths:", stdout);
    print_names(shading_name);
    fputs("Lists:", stdout);
    print_names(lists_name);
    fputs("Suites:", stdout);
    print_names(bench_suite_name);
    puts("\nCtrl-C or SIGTERM stops measuring; what was measured so far is written, and --resume continues from there.\n"
         "Exit status: 0 when everything was measured and written, 1 when a picture differs from the reference or\n"
         "a candidate failed, 2 on an error, 130 after Ctrl-C or SIGTERM.\n"
         "\n"
         "Examples:\n"
         "  fanal bench builtin:hall -o hall\n"
         "  fanal bench builtin:hall --lights 64,256,1024,4096 --shading deferred -o deferred\n"
         "  fanal bench city.glb builtin:glass --lists brute,tiled,clustered --msaa 1,4 --frames 30 -o compare\n"
         "  fanal bench --suite thesis -o thesis\n"
         "  fanal bench --suite geometry -o geometry\n"
         "  fanal bench --suite shadows -o shadows\n"
         "  fanal bench --suite visibility builtin:interior --sizes 1920x1080 --msaa 1,2,4,8 -o visibility");
}

/* ---- reading arguments ---- */

static bool parse_count(const char *option, const char *text, uint32_t low, uint32_t high, uint32_t *out) {
    long long value;
    if (!argument_integer(option, text, low, high, &value)) return false;
    *out = (uint32_t)value;
    return true;
}

static bool parse_value(struct bench_options *o, const char *option, const char *text) {
    int value;
    if (strcmp(option, "shading") == 0) {
        if (!argument_name(option, text, shading_name, &value)) return false;
        o->matrix.shading[o->matrix.shading_count++] = (uint32_t)value;
    } else if (strcmp(option, "lists") == 0) {
        if (strcmp(text, "brute") == 0) text = fnl_value_name(FNL_ENUM_LISTS, FNL_LISTS_ALL);
        if (!argument_name(option, text, lists_name, &value)) return false;
        o->matrix.lists[o->matrix.lists_count++] = (uint32_t)value;
    } else if (strcmp(option, "lights") == 0) {
        return parse_count(option, text, 0, LIGHTS_MAX, &o->matrix.lights[o->matrix.light_count++]);
    } else if (strcmp(option, "msaa") == 0) {
        uint32_t *samples = &o->matrix.msaa[o->matrix.msaa_count++];
        if (!parse_count(option, text, 1, 8, samples)) return false;
        if (*samples & (*samples - 1)) return argument_bad(option, text, "one of 1 2 4 8");
    } else {
        uint32_t *size = o->matrix.sizes[o->matrix.size_count++];
        return argument_size(option, text, &size[0], &size[1]);
    }
    return true;
}

/* Values separated by commas; they replace what an earlier use of the option gave. */
static bool parse_values(struct bench_options *o, const char *option, const char *text, uint32_t *count) {
    char copy[2048];
    *count = 0;
    if (strlen(text) >= sizeof copy) return argument_bad(option, text, "a shorter list");
    strcpy(copy, text);
    for (char *part = copy, *next; part; part = next) {
        next = strchr(part, ',');
        if (next) *next++ = 0;
        if (*count == BENCH_VALUES_MAX) return argument_bad(option, text, "a list of at most 64 values");
        if (!parse_value(o, option, part)) return false;
    }
    return true;
}

/* "KEY=VALUES" */
static bool parse_vary(struct bench_options *o, const char *text) {
    char key[64];
    size_t length = strcspn(text, "=");
    if (!text[length] || length >= sizeof key) return argument_bad("vary", text, "KEY=VALUES");
    snprintf(key, sizeof key, "%.*s", (int)length, text);
    return bench_vary_add(&o->matrix, "vary", key, text + length + 1);
}

static bool parse_set(struct bench_options *o, const char *text) {
    fnl_frame scratch = bench_frame();
    size_t length = strlen(o->matrix.set), left = sizeof o->matrix.set - length;
    if (strchr(text, ',')) return argument_bad("set", text, "one KEY=VALUE");
    if (!bench_ways_apply("set", text, &scratch)) return false;
    return snprintf(o->matrix.set + length, left, "%s%s", length ? "," : "", text) < (int)left ||
           argument_bad("set", text, "short enough");
}

enum {
    O_SHADING = 256,
    O_LISTS,
    O_LIGHTS,
    O_SIZES,
    O_MSAA,
    O_VARY,
    O_SET,
    O_SUITE,
    O_CAMERA,
    O_CAMERA_PATH,
    O_VARIANT,
    O_ENVIRONMENT,
    O_FRAMES,
    O_WARM_UP,
    O_CHECKS,
    O_REFERENCE,
    O_RESUME,
    O_OVERWRITE,
    O_ALL,
    O_IDEAL,
    O_DEVICE,
    O_VALIDATE,
    O_NO_CACHE,
    O_STEREO,
    O_HMD
};

static const struct option own_options[] = {{"output", required_argument, NULL, 'o'},
                                             {"quiet", no_argument, NULL, 'q'},
                                             {"help", no_argument, NULL, 'h'},
                                             {"shading", required_argument, NULL, O_SHADING},
                                             {"lists", required_argument, NULL, O_LISTS},
                                             {"lights", required_argument, NULL, O_LIGHTS},
                                             {"sizes", required_argument, NULL, O_SIZES},
                                             {"msaa", required_argument, NULL, O_MSAA},
                                             {"vary", required_argument, NULL, O_VARY},
                                             {"set", required_argument, NULL, O_SET},
                                             {"suite", required_argument, NULL, O_SUITE},
                                             LOADING_OPTIONS,
                                             {"camera", required_argument, NULL, O_CAMERA},
                                             {"camera-path", required_argument, NULL, O_CAMERA_PATH},
                                             {"variant", required_argument, NULL, O_VARIANT},
                                             {"environment", required_argument, NULL, O_ENVIRONMENT},
                                             {"frames", required_argument, NULL, O_FRAMES},
                                             {"warm-up", required_argument, NULL, O_WARM_UP},
                                             {"checks", required_argument, NULL, O_CHECKS},
                                             {"reference", required_argument, NULL, O_REFERENCE},
                                             {"resume", no_argument, NULL, O_RESUME},
                                             {"overwrite", no_argument, NULL, O_OVERWRITE},
                                             {"all", no_argument, NULL, O_ALL},
                                             {"ideal", no_argument, NULL, O_IDEAL},
                                             {"device", required_argument, NULL, O_DEVICE},
                                             {"validate", no_argument, NULL, O_VALIDATE},
                                             {"no-cache", no_argument, NULL, O_NO_CACHE},
                                             {"stereo", no_argument, NULL, O_STEREO},
                                             {"hmd", required_argument, NULL, O_HMD}};
enum { OWN_COUNT = sizeof own_options / sizeof *own_options };

static bool parse_option(struct bench_options *o, int option, const char *value) {
    struct bench_settings *s = &o->settings;
    const char *key, *name = option >= OPTIONS_NAMED ? options_named((uint32_t)(option - OPTIONS_NAMED), &key) : NULL;
    int index;
    if (name) return bench_vary_add(&o->matrix, name, key, value);
    switch (option) {
    case 'o':
        s->output = value;
        return *value || argument_bad("output", value, "a folder");
    case 'q':
        s->quiet = true;
        return true;
    case O_SHADING:
        o->matrix.shading_count = 0;
        return (o->matrix.every_shading = strcmp(value, "all") == 0) || parse_values(o, "shading", value, &o->matrix.shading_count);
    case O_LISTS:
        o->matrix.lists_count = 0;
        return (o->matrix.every_lists = strcmp(value, "all") == 0) || parse_values(o, "lists", value, &o->matrix.lists_count);
    case O_LIGHTS:
        return parse_values(o, "lights", value, &o->matrix.light_count);
    case O_SIZES:
        return parse_values(o, "sizes", value, &o->matrix.size_count);
    case O_MSAA:
        return parse_values(o, "msaa", value, &o->matrix.msaa_count);
    case O_VARY:
        return parse_vary(o, value);
    case O_SET:
        return parse_set(o, value);
    case O_SUITE:
        o->suite = bench_suite_find(value);
        return o->suite || argument_name("suite", value, bench_suite_name, &index);
    case O_CAMERA:
        o->matrix.camera = value;
        return true;
    case O_CAMERA_PATH:
        s->camera_path = value;
        return true;
    case O_STEREO:
        s->stereo = true;
        return true;
    case O_HMD:
        s->hmd = value;
        return true;
    case O_VARIANT:
        s->variant = value;
        return true;
    case O_ENVIRONMENT:
        s->environment = value;
        return true;
    case O_FRAMES:
        return parse_count("frames", value, 1, 100000, &s->frames);
    case O_WARM_UP:
        return parse_count("warm-up", value, 0, 100000, &s->warm_up);
    case O_CHECKS:
        return parse_count("checks", value, 0, 100000, &s->checks);
    case O_REFERENCE:
        if (strcmp(value, "all") == 0) value = fnl_value_name(FNL_ENUM_LISTS, FNL_LISTS_ALL); /* as elsewhere */
        if (!argument_name("reference", value, lists_name, &index)) return false;
        s->reference = (fnl_light_lists)index;
        return true;
    case O_RESUME:
        s->resume = true;
        return true;
    case O_OVERWRITE:
        s->overwrite = true;
        return true;
    case O_ALL:
        o->all = true;
        return true;
    case O_IDEAL:
        o->matrix.ideal = true;
        return true;
    case O_DEVICE:
        s->device = value;
        return true;
    case O_VALIDATE:
        s->validate = true;
        return true;
    case O_NO_CACHE:
        s->no_cache = true;
        return true;
    default:
        return false;
    }
}

/* ---- running ---- */

/* Of shading, lists and ways, for each case; 'all' of many options at once is more than anybody waits for. */
static uint64_t combination_count(const struct bench_matrix *m) {
    uint64_t count = m->shading_count && !m->every_shading ? m->shading_count : FNL_SHADING_COUNT;
    count *= m->lists_count && !m->every_lists ? m->lists_count : FNL_LISTS_COUNT;
    for (uint32_t v = 0; v < m->vary_count && count <= COMBINATIONS_MAX; v++) count *= m->varied[v].count;
    return count;
}

/* What only makes sense together. */
static bool check_options(const struct bench_options *o, int scene_count) {
    const char *problem = NULL;
    bool closed = o->suite && bench_suite_kind_of(o->suite) != BENCH_SUITE_MATRIX;
    if (closed && scene_count > 0) problem = "--suite brings its own scenes: give none";
    if (closed && (o->matrix.shading_count || o->matrix.lists_count || o->matrix.every_shading || o->matrix.every_lists || (o->all && !bench_suite_takes_all(o->suite)) || o->matrix.light_count ||
                     o->matrix.msaa_count || *o->matrix.set || o->matrix.vary_count || o->matrix.ideal || o->matrix.camera || o->settings.camera_path))
        problem = "--suite chooses shading, lists, lights, samples, options and cameras itself";
    if (closed && o->matrix.size_count > 1) problem = "--suite takes one size";
    if (o->settings.resume && o->settings.overwrite) problem = "--resume goes on with results, --overwrite drops them: give one of them";
    if (!o->suite && scene_count == 0) problem = "at least one scene or --suite is needed";
    if (combination_count(&o->matrix) > COMBINATIONS_MAX) problem = "more than 1048576 combinations of options, paths and lists";
    if (o->settings.hmd && !o->settings.stereo) problem = "--hmd belongs to --stereo";
    if (closed && o->settings.stereo) problem = "--stereo is for scenes of your own, not for this suite";
    if (!o->settings.output) problem = "a folder for the results is needed: give -o DIR";
    if (problem) fprintf(stderr, "fanal: error: %s; see 'fanal bench --help'\n", problem);
    return !problem;
}

/* A misspelt name must not cost the time of the measurements before it. */
static bool check_scenes(const struct bench_options *o, const char *const *scenes, int count, uint32_t *lights) {
    for (int i = 0; i < count; i++)
        if (!bench_scene_check(&o->settings, scenes[i], o->matrix.camera, &lights[i])) return false;
    return true;
}

/* What is not asked for goes by the device: a CPU draws fewer frames of a quarter of the pixels, which tell the same in ratios. */
static bool complete_options(struct bench_options *o) {
    static const struct {
        uint32_t size[2], frames;
    } usual[2] = {{{1280, 720}, 10}, {{640, 360}, 4}};
    struct bench_matrix *m = &o->matrix;
    struct bench_settings *s = &o->settings;
    fnl_device *device = NULL;
    fnl_device_info info = {0};
    bool good = bench_create_device(s, NULL, &device) && fnl_device_query_info(device, &info) == FNL_OK,
         cpu = info.type == FNL_DEVICE_CPU;
    fnl_device_destroy(&device);
    if (o->suite && !s->camera_path) s->camera_path = bench_suite_camera_path(o->suite);
    s->all = o->all;
    m->every_shading |= o->all && m->shading_count == 0;
    m->every_lists |= o->all && m->lists_count == 0;
    if (m->size_count == 0) memcpy(m->sizes[m->size_count++], usual[cpu].size, sizeof usual[cpu].size);
    bool shadows = strstr(m->set, "shadows=") == m->set || strstr(m->set, ",shadows=");
    for (uint32_t v = 0; v < m->vary_count; v++) shadows |= strcmp(m->varied[v].option.key, "shadows") == 0;
    m->usual_shadows = !shadows && bench_vary_add(m, "shadows", "shadows", "off,maps");
    if (m->msaa_count == 0) m->msaa[m->msaa_count++] = 1;
    s->more = s->frames == UINT32_MAX;
    if (s->more) s->frames = usual[cpu].frames;
    if (s->checks == UINT32_MAX) s->checks = s->camera_path ? 3 : 1;
    return good;
}

/* Whether there is anything to be written. */
static bool has_results(const struct bench_data *data) {
    static const char *const parts[] = {"results", "antialiasing", "coarse", "dais", "shadows", "stereo"};
    size_t count = 0;
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) count += json_array_size(json_object_get(data->root, parts[i]));
    return count > 0;
}

static int run(struct bench_options *o, const struct bench_plan *plan, uint32_t width, uint32_t height, struct bench_data *data) {
    const struct bench_settings *s = &o->settings;
    interrupt_catch(true);
    enum bench_end end = bench_measure(s, plan, data);
    if (end == BENCH_DONE && o->suite) end = bench_suite_measure(o->suite, s, width, height, data);
    if (end == BENCH_DONE && interrupt_seen()) end = BENCH_INTERRUPTED;
    interrupt_catch(false);
    if (end == BENCH_REFUSED) return 2;
    if (end != BENCH_DONE && !has_results(data)) {
        fprintf(stderr, "fanal: %s before anything was measured: nothing was written\n", end == BENCH_INTERRUPTED ? "interrupted" : "ended");
        return end == BENCH_INTERRUPTED ? 130 : 2;
    }
    bench_add_ideals(data);
    bench_conclude(data);
    if (o->suite) bench_suite_conclude(o->suite, width, height, data);
    if (!bench_save(s->output, data, true)) return 2;
    if (!s->quiet) {
        bench_print(data);
        bench_aa_print(data);
        bench_coarse_print(data);
        bench_tables_print(data);
        printf("\n%s: results.csv, results.json, report.html\n", s->output);
        if (end == BENCH_INTERRUPTED) puts("Interrupted: --resume goes on from here.");
    }
    if (end != BENCH_DONE) return end == BENCH_INTERRUPTED ? 130 : 2;
    return bench_unequal_count(data) || bench_failed_count(data) ? 1 : 0;
}

/* The status to end with, or -1 to go on. */
static int read_arguments(struct bench_options *o, int argc, char **argv) {
    struct option long_options[OWN_COUNT + OPTIONS_NAMED_MAX];
    options_make_long(own_options, OWN_COUNT, true, long_options); /* but for those that make the cases, any may vary */
    optind = 0;
    for (int option; (option = argument_next(argc, argv, "o:qh", long_options)) != -1;) {
        if (option == 'h') {
            print_help();
            return 0;
        }
        if (option == '?') return 2;
        if (!(loading_has(option) ? loading_parse(option, optarg, &o->settings.loading) : parse_option(o, option, optarg)))
            return 2;
    }
    return -1;
}

static struct bench_options default_options(void) {
    return (struct bench_options){.settings = {.frames = UINT32_MAX, .warm_up = 2, .checks = UINT32_MAX, .loading = fnl_load_params_default()}};
}

/* The options of a suite first, then those of the command once more, which replace them. */
static int read_over_suite(struct bench_options *o, int argc, char **argv) {
    const struct bench_suite *suite = o->suite;
    const char *const *preset;
    struct option long_options[OWN_COUNT + OPTIONS_NAMED_MAX];
    options_make_long(own_options, OWN_COUNT, true, long_options); /* but for those that make the cases, any may vary */
    *o = default_options();
    for (int i = 0; (preset = bench_suite_option(suite, i)) != NULL; i++) {
        const struct option *option = long_options;
        while (option->name && strcmp(option->name, preset[0]) != 0) option++;
        if (!option->name || !parse_option(o, option->val, preset[1])) return 2;
    }
    return read_arguments(o, argc, argv);
}

/* What a shell reads as these arguments; ends with " …" where there is no more room. */
static void quote_command(int argc, char **argv, char *text, size_t capacity) {
    static const char more[] = " …";
    size_t used = (size_t)snprintf(text, capacity, "fanal");
    for (int i = 0; i < argc; i++) {
        char *word = print_shell_word(argv[i]);
        const bool fits = word && used + strlen(word) + sizeof more < capacity;
        used += (size_t)snprintf(text + used, capacity - used, fits ? " %s" : more, word);
        free(word);
        if (!fits) return;
    }
}

int command_bench(int argc, char **argv) {
    struct bench_options o = default_options();
    char command[sizeof o.settings.command];
    quote_command(argc, argv, command, sizeof command); /* getopt sorts them */
    int early = read_arguments(&o, argc, argv);
    if (early < 0 && o.suite) early = read_over_suite(&o, argc, argv);
    if (early >= 0) return early;
    memcpy(o.settings.command, command, sizeof command);
    const char *const *scenes = (const char *const *)argv + optind;
    int scene_count = argc - optind;
    if (o.suite && scene_count == 0)
        for (scenes = bench_suite_scenes(o.suite); scenes[scene_count]; scene_count++) continue;
    if (!check_options(&o, scene_count)) return 2;

    struct bench_plan plan = {.skipped = json_array()};
    struct bench_data data = {NULL, NULL};
    bool matrix = !o.suite || bench_suite_kind_of(o.suite) == BENCH_SUITE_MATRIX;
    uint32_t width = o.matrix.size_count ? o.matrix.sizes[0][0] : 0, height = o.matrix.size_count ? o.matrix.sizes[0][1] : 0;
    uint32_t *lights = calloc((size_t)scene_count + 1, sizeof *lights);
    int status = 2;
    bool made = false;
    /* Everything that can be wrong is found before the folder is touched. */
    if (lights && bench_check_folder(&o.settings) && complete_options(&o) && check_scenes(&o, scenes, scene_count, lights) &&
        (!o.settings.resume || bench_load(o.settings.output, &data)) && bench_prepare_folder(o.settings.output, &made)) {
        if (!data.root) data.root = json_object();
        if (!data.pictures) data.pictures = json_object();
        if (matrix ? bench_plan_matrix(&o.matrix, scenes, lights, scene_count, &plan) : bench_suite_plan(o.suite, width, height, &plan))
            status = run(&o, &plan, width, height, &data);
        else
            fputs("fanal: error: memory ran out\n", stderr);
    }
    free(lights);
    if (status == 2 && made) rmdir(o.settings.output); /* unless something was measured, it is empty */
    json_decref(data.root);
    json_decref(data.pictures);
    bench_plan_free(&plan);
    return status;
}
