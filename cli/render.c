/* SPDX-License-Identifier: MIT */
/* fanal render: loads a scene, renders it, writes pictures and numbers. */
#include "render.h"

#include "argument_next.h"
#include "arguments.h"
#include "bench.h" /* camera paths */
#include "commands.h"
#include "counters.h"
#include "options.h"
#include "output.h"
#include "pixel.h"
#include "print.h"
#include "views.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

/* The options with names of their own: help, default in brackets, then what each takes on lines of its own. */
static void print_named(void) {
    const fnl_frame usual = fnl_frame_default();
    const char *key, *name;
    for (uint32_t i = 0; (name = options_named(i, &key)); i++) {
        fnl_option o;
        char head[32], range[512], value[64];
        if (!fnl_option_find(key, &o)) continue;
        options_print_range(&o, range, sizeof range);
        fnl_frame_get(&usual, key, value, sizeof value);
        if (strcmp(key, "shadows") == 0) snprintf(value, sizeof value, "maps where the scene has lights"); /* render_run() */
        bool is_switch = o.kind == FNL_OPTION_SWITCH;
        snprintf(head, sizeof head, "--%s%s", name, is_switch ? "" : o.kind == FNL_OPTION_NAME ? " KIND" : " N");
        printf("  %-26s %s (%s)\n", head, o.help, value);
        if (is_switch) continue;
        int column = 200; /* begins a line */
        for (char *word = strtok(range, " "); word; word = strtok(NULL, " ")) {
            bool wraps = column + 1 + (int)strlen(word) > 118;
            if (wraps && column < 200) putchar('\n');
            column = wraps ? printf("%29s%s", "", word) : column + printf(" %s", word);
        }
        putchar('\n');
    }
}

static void print_help(void) {
    puts("Usage: fanal render SCENE -o OUT.png|OUT.exr|- [-o ...] [OPTIONS]\n"
         "       fanal render --options|--counters [--json|--markdown]\n"
         "\n"
         "Renders SCENE, a .gltf or .glb file or builtin:NAME?key=value&... (NAME: city hall interior wall spheres pole "
         "lamps\n"
         "grass onetile nearplane sky glass room). A .png holds the tone-mapped picture, an .exr linear radiance in cd/m^2.\n"
         "Defaults are in brackets.\n"
         "\n"
         "Picture\n"
         "  -o, --output FILE|-        the file to write, - for stdout; can be given several times; %% is a percent sign\n"
         "  --format KIND              what -o - writes: png exr raw y4m y4m444 (png; for a sequence y4m)\n"
         "  --size WxH                 pixels (1280x720)\n"
         WORLD_CAMERA_HELP
         "  --camera-path KIND|FILE    a sequence along a path: orbit or turntable, each with :N pictures per turn, or a "
         "file\n"
         "                             of lines 'seconds eye.x eye.y eye.z target.x target.y target.z'\n"
         "  --views cube|all|LIST      several cameras in one frame: the six faces of a cube around the camera (give a "
         "square\n"
         "                             --size), all cameras of the scene, or some of them by name or index, with commas;\n"
         "                             each output has one %d, or as %02d, for the number of the view\n"
         STEREO_HELP
         DISPLAY_HELP
         WORLD_EYE_HELP
         "  --exposure EV|auto|none    EV100 (auto; a sequence keeps the exposure of its first picture unless auto is given)\n"
         WORLD_SURROUNDINGS_HELP
         "  --aov LIST                 more channels in the .exr: depth,normal,albedo,roughness,id,position,motion,object\n"
         "  --supersample N            averages N frames with different sample positions: a reference for antialiasing");
    puts("\n"
         "Scene\n"
         WORLD_SCENE_HELP "\n"
         "Method");
    print_named();
    puts("  --set KEY=VALUE            any option of a frame; can be given several times. 'fanal render --options' prints\n"
         "                             all of them, with their ranges and what uses them; with --json for programs.\n"
         "                             'help' as the value lists the names that an option takes, as in --debug help\n"
         "\n"
         "Run\n"
         "  --frames N                 times N frames and prints a table of medians\n"
         "  --frame-time SECONDS       outputs with %d or %04d in their names are a sequence of --frames pictures; the\n"
         "                             animation advances by this much between them (1/30)\n"
         "  --start-frame N            starts a sequence at picture N (0); it ends where --frames says\n"
         "  --choose-seconds S         with --frames 2 or more: how long auto may measure before the first one (20)\n"
         "  --stats FILE|-             writes the statistics as JSON; for a sequence, a line per picture. 'fanal render\n"
         "                             --counters' lists the counters that can be among them\n"
         "  --pixel X,Y[,VIEW]         prints the surface, the light list and each light at a pixel\n"
         "  --save-scene FILE.glb      writes the scene with what the options above added; without an output nothing is rendered\n"
         "  --plan[=json]              prints the frame graph, as text or for programs\n"
         "  --trace-file FILE          writes when each pass and each part of the CPU's work began and ended, for the last 240 of the\n"
         "                             timed frames or pictures: Chrome's trace format, which Perfetto shows\n"
         "  --traffic                  prints what each pass moves between images and memory\n"
         "  --device INDEX|NAME        one of those that 'fanal devices' lists (the best)\n"
         "  --no-cache                 does not use the user's cache folder, which keeps compiled pipelines and what auto "
         "chose\n"
         "  --validate                 Vulkan validation; any message makes the command fail\n"
         "  -v, --verbose              prints the table of a timed frame: passes, lights, triangles, memory\n"
         "  -q, --quiet                prints only errors and the output of --pixel, --plan, --traffic\n"
         "  -h, --help                 prints this text\n"
         "\n"
         "With -o - or --stats -, everything else is printed to stderr.\n"
         "Exit status: 0 when everything was written, 2 on an error. After an error no output file is left behind, except\n"
         "the complete pictures of a sequence.\n"
         "\n"
         "Examples:\n"
         "  fanal render builtin:hall --lights 500 -o hall.png\n"
         "  fanal render 'builtin:city?lights=65536' --shading deferred --lists tiled --frames 20 --stats city.json -o "
         "city.png\n"
         "  fanal render builtin:hall --shading coarse --set coarse.size=4 -o coarse.png\n"
         "  fanal render builtin:hall --aov depth,normal -o hall.exr --debug lights -o hall-lights.png\n"
         "  fanal render builtin:spheres --camera-path orbit:90 -o - |\n"
         "    ffmpeg -i - -colorspace bt709 -color_primaries bt709 -color_trc iec61966-2-1 spheres.mp4");
}

/* ---- reading arguments ---- */

bool render_parse_aov(const char *text, uint32_t *aovs) {
    char copy[128], *rest = copy;
    if (strlen(text) >= sizeof copy) return argument_bad("aov", text, "a list such as depth,normal");
    strcpy(copy, text);
    for (char *part; (part = strsep(&rest, ","));) {
        int index;
        if (!argument_name("aov", part, render_aov_name, &index)) return false;
        *aovs |= 1u << index;
    }
    return true;
}

static bool add_output(struct render_options *o, const char *path) {
    if (!render_is_stdout(path) && !render_has_extension(path, "png") && !render_has_extension(path, "exr"))
        return argument_bad("output", path, "a file that ends in .png or .exr, nor -");
    if (o->output_count == RENDER_MAX_OUTPUTS) return argument_bad("output", path, "among the first 16 outputs");
    o->outputs[o->output_count++] = path;
    return true;
}

enum {
    O_SIZE = 256,
    O_VIEWS,
    O_SET,
    O_OPTIONS,
    O_COUNTERS,
    O_JSON,
    O_MARKDOWN,
    O_TRAFFIC,
    O_SUPERSAMPLE,
    O_FRAME_TIME,
    O_CHOOSE_SECONDS,
    O_EXPOSURE,
    O_FRAMES,
    O_DEVICE,
    O_VALIDATE,
    O_NO_CACHE,
    O_AOV,
    O_STATS,
    O_PLAN,
    O_TRACE_FILE,
    O_PIXEL,
    O_CAMERA_PATH,
    O_START_FRAME,
    O_FORMAT,
    O_SAVE_SCENE,
    O_STEREO,
    O_IPD,
    O_HMD,
    O_LENS,
    O_LENS_VIEW,
    O_HIDDEN_MESH,
};

/* Options of the frame by their keys, and whose use may be worth a warning. */
static bool set_option(struct render_options *o, const char *option, const char *key, const char *value) {
    if (o->given_count == RENDER_MAX_GIVEN) return argument_bad(option, value, "among the first 128 options");
    o->given[o->given_count++] = key;
    return options_set(&o->frame, option, key, value);
}

static bool set_text(struct render_options *o, const char *text) {
    const char *key = NULL;
    if (o->given_count == RENDER_MAX_GIVEN) return argument_bad("set", text, "among the first 128 options");
    if (!options_set_text(&o->frame, "set", text, &key)) return false;
    o->given[o->given_count++] = key;
    return true;
}

bool render_was_given(const struct render_options *o, const char *key) {
    for (int i = 0; i < o->given_count; i++)
        if (strcmp(o->given[i], key) == 0) return true;
    return false;
}

static bool parse_option(struct render_options *o, int option, const char *value) {
    long long integer;
    double number;
    int index;
    const char *key, *name = option >= OPTIONS_NAMED ? options_named((uint32_t)(option - OPTIONS_NAMED), &key) : NULL;
    if (name) return set_option(o, name, key, value ? value : "on");
    switch (option) {
    case O_SET:
        return set_text(o, value);
    case 'o':
        return add_output(o, value);
    case 'q':
        o->quiet = true;
        return true;
    case 'v':
        o->verbose = true;
        return true;
    case O_SIZE:
        o->has_size = true;
        return argument_size("size", value, &o->frame.width, &o->frame.height);
    case O_VIEWS:
        o->views = value;
        return true;
    case O_STEREO:
        if (!argument_name("stereo", value, stereo_kind_name, &index)) return false;
        o->stereo.kind = (enum stereo_kind)(index + 1);
        return true;
    case O_IPD:
        if (!argument_number("ipd", value, &number)) return false;
        if (!(number >= 0 && number <= 1)) return argument_bad("ipd", value, "a number of metres, 0 to 1");
        o->stereo.ipd = (float)number;
        return true;
    case O_LENS:
        o->display.given = true;
        if (!argument_name("lens", value, display_warp_name, &index)) return false;
        o->display.warp = (fnl_warp)index;
        return true;
    case O_LENS_VIEW:
        if (!argument_name("lens-view", value, display_view_name, &index)) return false;
        o->display.view = (fnl_display_view)index;
        return true;
    case O_HIDDEN_MESH:
        if (strcmp(value, "on") != 0 && strcmp(value, "off") != 0) return argument_bad("hidden-mesh", value, "on or off");
        o->display.hides = value[1] == 'n';
        return true;
    case O_HMD:
        o->stereo.hmd = value;
        return true;
    case O_PIXEL:
        return pixel_parse("pixel", value, &o->frame.pixel);
    case O_TRAFFIC:
        o->traffic = true;
        return true;
    case O_SUPERSAMPLE:
        if (!argument_integer("supersample", value, 1, 4096, &integer)) return false;
        o->supersample = (uint32_t)integer;
        return true;
    case O_FRAME_TIME:
        if (!argument_number("frame-time", value, &o->frame_time)) return false;
        return (o->has_frame_time = o->frame_time >= 0) || argument_bad("frame-time", value, "a number of seconds");
    case O_CHOOSE_SECONDS:
        if (!argument_number("choose-seconds", value, &number)) return false;
        if (!(number >= 0 && number <= 1e6)) return argument_bad("choose-seconds", value, "a number of seconds");
        o->choose_seconds = number;
        return true;
    case O_EXPOSURE:
        o->has_exposure = true;
        return argument_exposure("exposure", value, &o->frame.exposure, &o->frame.ev);
    case O_FRAMES:
        if (!argument_integer("frames", value, 0, 1000000, &integer)) return false;
        o->frame_count = (uint32_t)integer;
        o->has_frames = true;
        return true;
    case O_DEVICE:
        o->device = value;
        return true;
    case O_VALIDATE:
        o->validate = true;
        return true;
    case O_NO_CACHE:
        o->no_cache = true;
        return true;
    case O_AOV:
        return render_parse_aov(value, &o->aovs);
    case O_STATS:
        o->stats = value;
        return true;
    case O_PLAN:
        if (!value)
            o->plan = RENDER_PLAN_TEXT;
        else if (strcmp(value, "json") == 0)
            o->plan = RENDER_PLAN_JSON;
        else
            return argument_bad("plan", value, "json, nor nothing at all");
        return true;
    case O_TRACE_FILE:
        o->trace_file = value;
        return true;
    case O_CAMERA_PATH:
        o->camera_path = value;
        return true;
    case O_START_FRAME:
        if (!argument_integer("start-frame", value, 0, 999999, &integer)) return false;
        o->start_frame = (uint32_t)integer;
        return true;
    case O_SAVE_SCENE:
        o->save_scene = value;
        return render_has_extension(value, "glb") || argument_bad("save-scene", value, "a file that ends in .glb");
    case O_FORMAT:
        if (!argument_name("format", value, render_format_name, &index)) return false;
        o->format = (enum render_format)index;
        o->has_format = true;
        return true;
    default:
        return false;
    }
}

static const struct option own_options[] = {
    {"output", required_argument, NULL, 'o'},
    {"quiet", no_argument, NULL, 'q'},
    {"verbose", no_argument, NULL, 'v'},
    {"help", no_argument, NULL, 'h'},
    {"size", required_argument, NULL, O_SIZE},
    {"views", required_argument, NULL, O_VIEWS},
    {"set", required_argument, NULL, O_SET},
    {"options", no_argument, NULL, O_OPTIONS},
    {"counters", no_argument, NULL, O_COUNTERS},
    {"json", no_argument, NULL, O_JSON},
    {"markdown", no_argument, NULL, O_MARKDOWN},
    {"traffic", no_argument, NULL, O_TRAFFIC},
    {"supersample", required_argument, NULL, O_SUPERSAMPLE},
    {"frame-time", required_argument, NULL, O_FRAME_TIME},
    {"choose-seconds", required_argument, NULL, O_CHOOSE_SECONDS},
    {"exposure", required_argument, NULL, O_EXPOSURE},
    {"frames", required_argument, NULL, O_FRAMES},
    {"device", required_argument, NULL, O_DEVICE},
    {"validate", no_argument, NULL, O_VALIDATE},
    {"no-cache", no_argument, NULL, O_NO_CACHE},
    {"aov", required_argument, NULL, O_AOV},
    {"stats", required_argument, NULL, O_STATS},
    {"plan", optional_argument, NULL, O_PLAN},
    {"trace-file", required_argument, NULL, O_TRACE_FILE},
    {"pixel", required_argument, NULL, O_PIXEL},
    {"camera-path", required_argument, NULL, O_CAMERA_PATH},
    {"start-frame", required_argument, NULL, O_START_FRAME},
    {"format", required_argument, NULL, O_FORMAT},
    {"save-scene", required_argument, NULL, O_SAVE_SCENE},
    {"stereo", required_argument, NULL, O_STEREO},
    {"ipd", required_argument, NULL, O_IPD},
    {"hmd", required_argument, NULL, O_HMD},
    {"lens", required_argument, NULL, O_LENS},
    {"lens-view", required_argument, NULL, O_LENS_VIEW},
    {"hidden-mesh", required_argument, NULL, O_HIDDEN_MESH},
    WORLD_OPTIONS,
};
enum { OWN_COUNT = sizeof own_options / sizeof *own_options };

/* The path of an output; a field stays, without the width of its number. */
static const char *plain_path(const char *pattern, char path[4096]) {
    const char *percent, *field;
    int width;
    size_t used = 0;
    if ((field = output_next_field(pattern, &percent, &width))) {
        used = output_append(path, 0, 4096, pattern, (size_t)(percent - pattern));
        used = output_append(path, used, 4096, "%", 1);
        pattern = field;
    }
    output_append(path, used, 4096, pattern, strlen(pattern));
    return path;
}

/* Of two outputs that are one file the first would be lost. */
static bool check_files(const struct render_options *o) {
    const char *files[RENDER_MAX_OUTPUTS + 5];
    char paths[RENDER_MAX_OUTPUTS][4096];
    int count = 0;
    for (; count < o->output_count; count++) files[count] = plain_path(o->outputs[count], paths[count]);
    if (o->stats) files[count++] = o->stats;
    if (o->trace_file) files[count++] = o->trace_file;
    if (o->save_scene) files[count++] = o->save_scene;
    int written = count;
    files[count++] = o->world.scene;
    if (o->stereo.hmd) files[count++] = o->stereo.hmd;
    for (int i = 0; i < written; i++)
        for (int k = i + 1; k < count; k++) {
            if (!output_is_same(files[i], files[k])) continue;
            fprintf(stderr, "fanal: error: %s and %s are one file%s\n", files[i], files[k],
                    k < written ? ", which would be written twice" : k == written ? ": the scene would be overwritten" : ": the headset would be overwritten");
            return false;
        }
    for (int i = 0; i < written; i++)
        if (!render_is_stdout(files[i]) && !(i < o->output_count ? output_check_pattern(o->outputs[i]) : output_check(files[i]))) return false;
    return true;
}

/* What only makes sense together. */
static bool check_options(struct render_options *o) {
    const char *problem = NULL;
    bool has_exr = false, has_stdout = false, sequence = render_makes_sequence(o);
    uint32_t circle = 0;
    for (int i = 0; i < o->output_count; i++) {
        enum render_format format = render_format_of(o, o->outputs[i]);
        bool is_stdout = render_is_stdout(o->outputs[i]);
        has_exr = has_exr || format == RENDER_EXR;
        if (is_stdout && has_stdout) problem = "-o - may be given once";
        has_stdout = has_stdout || is_stdout;
        if (sequence && is_stdout && format < RENDER_RAW) problem = "a sequence goes to stdout as --format raw, y4m or y4m444";
        if (sequence && !is_stdout && !render_is_sequence(o->outputs[i]))
            problem = "each output of a sequence has one %d, or as %04d, for the frame's number (%% is a percent sign)";
        if (o->views && is_stdout) problem = "-o - takes the picture of one view, not those of --views";
        if (o->views && !is_stdout && !render_is_sequence(o->outputs[i]))
            problem = "each output of --views has one %d, or as %02d, for the view's number (%% is a percent sign)";
        if (o->stereo.kind == STEREO_LAYERS && is_stdout) problem = "-o - takes one picture, not those of --stereo layers";
        if (o->stereo.kind == STEREO_LAYERS && !is_stdout && !render_is_sequence(o->outputs[i]))
            problem = "each output of --stereo layers has one %d for the eye's number (%% is a percent sign)";
    }
    if (render_shows_nothing(o) && !o->save_scene)
        problem = "no output was asked for: give -o FILE, --stats FILE, --pixel X,Y, --plan, --traffic, --trace-file FILE or --save-scene FILE";
    if (o->has_format && !has_stdout) problem = "--format is for -o -: files have it in their names";
    if (has_stdout && o->stats && render_is_stdout(o->stats)) problem = "stdout takes the picture or --stats, not both";
    if (world_problem(&o->world)) problem = world_problem(&o->world);
    if (stereo_problem(&o->stereo)) problem = stereo_problem(&o->stereo);
    for (int i = 0; i <= o->output_count; i++) {
        const bool exr = i < o->output_count && render_format_of(o, o->outputs[i]) == RENDER_EXR;
        if (display_problem(&o->display, &o->stereo, exr)) problem = display_problem(&o->display, &o->stereo, exr);
    }
    if (o->views && o->stereo.kind) problem = "--views and --stereo cannot be combined";
    if (o->stereo.kind == STEREO_LAYERS && sequence) problem = "a sequence takes one picture at a time, not those of --stereo layers";
    if (o->stereo.hmd && o->world.fov > 0) problem = "--fov does not go with --hmd, whose displays have fields of view of their own";
    if (o->views && sequence) problem = "--views and --camera-path cannot be combined";
    if (o->views && !views_are_cube(o->views) && (o->world.camera || o->world.has_eye || o->world.fov > 0))
        problem = "--camera, --eye and --fov do not go with --views, but for the place of --views cube";
    if (o->views && views_are_cube(o->views) && o->world.fov > 0) problem = "the faces of --views cube have 90 degrees: --fov does not go with them";
    if (o->views && views_are_cube(o->views) && o->frame.width != o->frame.height)
        problem = "the faces of --views cube are square: give, for example, --size 1024x1024";
    if (o->camera_path && o->world.has_eye) problem = "--camera-path and --eye cannot be combined";
    if (o->camera_path && !o->has_frames && bench_path_is_circle(o->camera_path, &circle) && circle == 0)
        problem = "--camera-path orbit and turntable need --frames, or as orbit:N the pictures once round";
    if (o->aovs && !has_exr) problem = "--aov needs an .exr output";
    if (o->supersample > 1 && o->frame.aa == FNL_ANTIALIASING_TAA) problem = "--supersample and --aa taa cannot be combined";
    if (o->frame_count == 0 && (o->stats || o->trace_file || o->verbose || sequence))
        problem = "--frames 0 cannot be combined with --stats, --trace-file, --verbose or a sequence: it measures nothing";
    if (o->verbose && o->quiet) problem = "--verbose and --quiet cannot be combined";
    if (o->verbose && sequence) problem = "--verbose is for single pictures; use --stats FILE for a sequence";
    if (o->trace_file && render_is_stdout(o->trace_file)) problem = "--trace-file cannot write to stdout";
    if (o->trace_file && o->supersample > 1) problem = "--trace-file and --supersample cannot be combined: pictures of several frames are not timed";
    if (o->frame.pixel.asked && (o->frame.pixel.x >= o->frame.width || o->frame.pixel.y >= o->frame.height))
        problem = "--pixel is outside of the picture: X and Y are less than its --size";
    if (o->frame.pixel.asked && sequence) problem = "--pixel is for single pictures, not for sequences";
    if (o->has_frame_time && !sequence) problem = "--frame-time is for sequences: -o NAME-%04d.png";
    if (o->start_frame > 0 && !sequence) problem = "--start-frame is for sequences: -o NAME-%04d.png";
    if (problem) fprintf(stderr, "fanal: error: %s; see 'fanal render --help'\n", problem);
    return !problem;
}

/* Options that this frame ignores are harmless, but hardly what was meant. auto may take any path or list, so it may need any. */
static void warn_of_unused(const struct render_options *o) {
    fnl_option option;
    for (int i = 0; i < o->given_count && !o->quiet; i++) {
        if (!fnl_option_find(o->given[i], &option)) continue;
        if (o->frame.shading != FNL_SHADING_AUTO && !(option.shadings >> o->frame.shading & 1))
            fprintf(stderr, "fanal: warning: %s has no effect with --shading %s\n", option.key,
                    fnl_value_name(FNL_ENUM_SHADING, o->frame.shading));
        if (o->frame.lists != FNL_LISTS_AUTO && !(option.lists >> o->frame.lists & 1))
            fprintf(stderr, "fanal: warning: %s has no effect with --lists %s\n", option.key,
                    fnl_value_name(FNL_ENUM_LISTS, o->frame.lists));
    }
}

int command_render(int argc, char **argv) {
    struct render_options o = {.frame = fnl_frame_default(),
                               .world = world_options_default(),
                               .stereo.ipd = NAN,
                               .frame_count = 1,
                               .frame_time = 1 / 30.0,
                               .choose_seconds = 20};
    struct option long_options[OWN_COUNT + OPTIONS_NAMED_MAX];
    void (*prints)(enum options_form form) = NULL;
    enum options_form form = OPTIONS_TEXT;
    options_make_long(own_options, OWN_COUNT, false, long_options);
    optind = 0;
    for (int option; (option = argument_next(argc, argv, "o:qvh", long_options)) != -1;) {
        if (option == 'h') {
            print_help();
            return 0;
        }
        if (option == '?') return 2;
        const char *key = NULL;
        if (option >= OPTIONS_NAMED && options_named((uint32_t)(option - OPTIONS_NAMED), &key) && options_print_values(key, optarg))
            return 0;
        if (option == O_OPTIONS || option == O_COUNTERS) prints = option == O_OPTIONS ? options_print : counters_print;
        if (option == O_JSON) form = OPTIONS_JSON;
        if (option == O_MARKDOWN) form = OPTIONS_MARKDOWN;
        if (option == O_OPTIONS || option == O_COUNTERS || option == O_JSON || option == O_MARKDOWN) continue;
        if (!(world_has(option) ? world_parse(option, optarg, &o.world) : parse_option(&o, option, optarg))) return 2;
    }
    if (prints) {
        prints(form);
        return 0;
    }
    if (form != OPTIONS_TEXT) {
        fputs("fanal: error: --json and --markdown belong to --options and --counters; --stats FILE writes the numbers of a "
              "frame as JSON\n",
              stderr);
        return 2;
    }
    if (argc - optind != 1) {
        fprintf(stderr, "fanal: error: one scene is needed, %d were given; see 'fanal render --help'\n", argc - optind);
        return 2;
    }
    o.world.scene = argv[optind];
    if (!check_options(&o) || !check_files(&o)) return 2;
    if (o.supersample > 1 && !render_was_given(&o, "msaa")) o.frame.msaa = 1; /* the mean smooths edges */
    if (o.supersample > 1 && !render_was_given(&o, "aa")) o.frame.aa = FNL_ANTIALIASING_NONE;
    world_set_frame(&o.world, &o.frame);
    if (!o.has_frames && !o.stats && !o.trace_file && !o.verbose && !render_makes_sequence(&o)) o.frame_count = 0;
    o.lit_casts = !render_was_given(&o, "shadows");
    warn_of_unused(&o);
    return render_run(&o);
}
