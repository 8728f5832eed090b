/* SPDX-License-Identifier: MIT */
/* fanal cave: what is seen through the walls of a CAVE. */
#include "cave/cave.h"
#include "cave/hash.h"

#include "argument_next.h"
#include "arguments.h"
#include "commands.h"
#include "options.h"
#include "output.h"
#include "print.h"

#include <stdio.h>
#include <string.h>

static void print_help(void) {
    puts("Usage: fanal cave SCENE --displays FILE -o NAME-%w-%e.png [-o ...] [OPTIONS]\n"
         "       mpirun -n N fanal cave SCENE --displays FILE ...\n"
         "       fanal cave --displays builtin:NAME --print\n"
         "\n"
         "Renders what a viewer sees through walls: screens or projections around the head, each of one picture or of one for\n"
         "each eye. FILE is JSON: corners and resolution of each wall, place of the head, distance of the eyes, devices. There\n"
         "are examples: builtin:mono, builtin:stereo, builtin:three (three screens), builtin:cave (a room of five walls).\n"
         "docs/cave.md describes the file. Defaults are in brackets.\n"
         "\n"
         "Displays\n"
         "  --displays FILE            the walls, or an example\n"
         "  --print                    prints an example, to begin a file with, or the walls of a file, and ends\n"
         "  --size WxH                 the resolution of all walls, instead of the file's\n"
         WORLD_CAMERA_HELP
         "  --eye X,Y,Z --look-at X,Y,Z    a camera of your own\n"
         "                             The camera is where the head is at first; --camera, --eye and --look-at do so even if\n"
         "                             the file says where the CAVE stands. Fields of view are those of the walls.\n"
         "\n"
         "Picture\n"
         "  -o, --output FILE          the pictures, .png or .exr: %w becomes the name of the wall, %e the eye (mono, left,\n"
         "                             right), %d or %04d the number of the frame; can be given several times\n"
         "  --aov LIST                 more channels in the .exr: depth,normal,albedo,roughness,id,position,motion,object\n"
         "  --exposure EV|auto|none    EV100 of all walls; auto measures once, all around the head (auto)");
    puts(WORLD_SURROUNDINGS_HELP "\n"
         "Scene\n" WORLD_SCENE_HELP);
    puts("Method\n"
         "  --shading, --lists, --shadows and all others of 'fanal render'\n"
         "  --set KEY=VALUE            any option of a frame; 'fanal render --options' prints all\n"
         "\n"
         "Run\n"
         "  --frames N                 renders N frames, in which the head follows its track (1)\n"
         "  --frame-time SECONDS       time from frame to frame, of the track and of the animation (1/30)\n"
         "  --start-frame N            begins with frame N (0)\n"
         "  --gather                   rank 0 writes all pictures, not each rank its own\n"
         "  --timeout SECONDS          how long ranks wait for one that does not answer (60)\n"
         "  --fault RANK,FRAME,KIND    a drill: the rank is late=SECONDS, lost, or has another pose\n"
         "  --stats FILE|-             writes the numbers of all frames as JSON\n"
         "  --device INDEX|NAME        one of those that 'fanal devices' lists, where the file names none (the best)\n"
         "  --no-cache                 does not use the user's cache folder\n"
         "  --validate                 Vulkan validation; any message makes the command fail\n"
         "  -q, --quiet                prints nothing but errors\n"
         "  -h, --help                 prints this text\n"
         "\n"
         "Under mpirun each rank renders the walls that name it, or else every N-th wall.\n"
         "Exit status: 0 when everything was written, 130 when it was interrupted, 2 on an error. The pictures of a frame are\n"
         "written when all walls are done; after an error those of earlier frames stay.\n"
         "\n"
         "Examples:\n"
         "  fanal cave builtin:hall --displays builtin:cave --size 512x512 -o hall-%w-%e.png\n"
         "  fanal cave builtin:cave --displays studio.json --frames 90 -o walk-%w-%e-%04d.png --stats walk.json\n"
         "  mpirun -n 5 fanal cave scene.glb --displays builtin:cave -o wall-%w-%e.png");
}

enum { O_DISPLAYS = 256, O_PRINT, O_SIZE, O_SET, O_EXPOSURE, O_AOV, O_FRAMES, O_FRAME_TIME, O_START_FRAME, O_GATHER, O_TIMEOUT, O_FAULT, O_STATS, O_DEVICE, O_NO_CACHE, O_VALIDATE };

static const struct option own_options[] = {
    {"output", required_argument, NULL, 'o'},
    {"quiet", no_argument, NULL, 'q'},
    {"help", no_argument, NULL, 'h'},
    {"displays", required_argument, NULL, O_DISPLAYS},
    {"print", no_argument, NULL, O_PRINT},
    {"size", required_argument, NULL, O_SIZE},
    {"set", required_argument, NULL, O_SET},
    {"exposure", required_argument, NULL, O_EXPOSURE},
    {"aov", required_argument, NULL, O_AOV},
    {"frames", required_argument, NULL, O_FRAMES},
    {"frame-time", required_argument, NULL, O_FRAME_TIME},
    {"start-frame", required_argument, NULL, O_START_FRAME},
    {"gather", no_argument, NULL, O_GATHER},
    {"timeout", required_argument, NULL, O_TIMEOUT},
    {"fault", required_argument, NULL, O_FAULT},
    {"stats", required_argument, NULL, O_STATS},
    {"device", required_argument, NULL, O_DEVICE},
    {"no-cache", no_argument, NULL, O_NO_CACHE},
    {"validate", no_argument, NULL, O_VALIDATE},
    WORLD_OPTIONS,
};
enum { OWN_COUNT = sizeof own_options / sizeof *own_options };

static bool add_output(struct render_options *o, const char *path) {
    if (!render_has_extension(path, "png") && !render_has_extension(path, "exr")) return argument_bad("output", path, "a file that ends in .png or .exr");
    if (o->output_count == RENDER_MAX_OUTPUTS) return argument_bad("output", path, "among the first 16 outputs");
    o->outputs[o->output_count++] = path;
    return true;
}

static bool parse_fault(const char *text, struct cave_fault *out) {
    static const char wanted[] = "a drill: RANK,FRAME,late=SECONDS or RANK,FRAME,lost or RANK,FRAME,pose";
    const char *kind = text;
    uint64_t rank, frame;
    if (!argument_take_count(&kind, &rank) || *kind++ != ',' || rank >= CAVE_RANKS) return argument_bad("fault", text, wanted);
    if (!argument_take_count(&kind, &frame) || *kind++ != ',' || frame > UINT32_MAX) return argument_bad("fault", text, wanted);
    *out = (struct cave_fault){.rank = (uint32_t)rank, .frame = (uint32_t)frame};
    if (strcmp(kind, "lost") == 0) out->kind = CAVE_FAULT_LOST;
    if (strcmp(kind, "pose") == 0) out->kind = CAVE_FAULT_POSE;
    if (strncmp(kind, "late=", 5) == 0) {
        out->kind = CAVE_FAULT_LATE;
        if (!argument_number("fault", kind + 5, &out->seconds)) return false;
        if (!(out->seconds >= 0 && out->seconds <= 3600)) return argument_bad("fault", text, wanted);
    }
    return out->kind != CAVE_FAULT_NONE || argument_bad("fault", text, wanted);
}

static bool parse_option(struct cave_options *c, int option, const char *value) {
    struct render_options *o = &c->render;
    long long integer;
    const char *key, *name = option >= OPTIONS_NAMED ? options_named((uint32_t)(option - OPTIONS_NAMED), &key) : NULL;
    if (name) {
        if (strcmp(key, "shadows") == 0) o->lit_casts = false;
        if (strcmp(key, "shading") == 0) o->given_count = 1; /* --msaa does not choose it */
        return options_set(&o->frame, name, key, value ? value : "on");
    }
    switch (option) {
    case 'o':
        return add_output(o, value);
    case 'q':
        return o->quiet = true;
    case O_DISPLAYS:
        c->displays = value;
        return true;
    case O_SIZE:
        return argument_size("size", value, &c->width, &c->height);
    case O_SET:
        if (!options_set_text(&o->frame, "set", value, &key)) return false;
        if (strcmp(key, "shadows") == 0) o->lit_casts = false;
        if (strcmp(key, "shading") == 0) o->given_count = 1;
        return true;
    case O_EXPOSURE:
        return argument_exposure("exposure", value, &o->frame.exposure, &o->frame.ev);
    case O_AOV:
        return render_parse_aov(value, &o->aovs);
    case O_FRAMES:
        if (!argument_integer("frames", value, 1, 1000000, &integer)) return false;
        o->frame_count = (uint32_t)integer;
        return true;
    case O_FRAME_TIME:
        if (!argument_number("frame-time", value, &o->frame_time)) return false;
        return (o->frame_time >= 0 && o->frame_time <= 1e6) || argument_bad("frame-time", value, "a number of seconds");
    case O_START_FRAME:
        if (!argument_integer("start-frame", value, 0, 999999, &integer)) return false;
        o->start_frame = (uint32_t)integer;
        return true;
    case O_GATHER:
        return c->gather = true;
    case O_TIMEOUT:
        if (!argument_number("timeout", value, &c->timeout)) return false;
        return (c->timeout >= 0.1 && c->timeout <= 86400) || argument_bad("timeout", value, "a number of seconds from 0.1 to 86400");
    case O_FAULT:
        return parse_fault(value, &c->fault);
    case O_STATS:
        o->stats = value;
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

/* Options that may differ between ranks: where things are, what is printed, and which device renders. */
static bool is_local(int option) {
    return option == 'o' || option == 'q' || option == O_DISPLAYS || option == O_STATS || option == O_DEVICE || option == O_NO_CACHE || option == O_VALIDATE || option == O_FAULT ||
           option == O_TIMEOUT;
}

static bool check(const struct cave_options *c, const struct cave_displays *d) {
    const struct render_options *o = &c->render;
    const uint64_t frames = o->frame_count;
    const char *problem = NULL;
    bool has_exr = false;
    if (o->start_frame >= o->frame_count) problem = "--start-frame must be below --frames";
    if (o->output_count == 0 && !o->stats) problem = "no output was asked for: give -o NAME-%w-%e.png or --stats FILE";
    if (world_problem(&o->world)) problem = world_problem(&o->world);
    if (o->world.fov > 0) problem = "--fov has no effect: fields of view are those of the walls";
    if (o->world.up.x != 0 || o->world.up.y != 0 || o->world.up.z != 0) problem = "--up has no effect: the CAVE stands upright, or as its file says";
    if (o->world.near > 0) problem = "--near has no effect: the file of the displays says it";
    if (o->frame.pixel.asked || o->frame.light_lod > 0) problem = "light-lod is for frames of one view";
    for (int i = 0; i < o->output_count && !problem; i++) {
        problem = cave_pattern_problem(o->outputs[i], d, frames);
        has_exr = has_exr || render_has_extension(o->outputs[i], "exr");
        for (int k = 0; k < i; k++)
            if (output_is_same(o->outputs[i], o->outputs[k])) problem = "two outputs are one file";
        if (output_is_same(o->outputs[i], d->source) || output_is_same(o->outputs[i], o->world.scene)) problem = "an output would overwrite an input";
    }
    if (o->stats && (output_is_same(o->stats, d->source) || output_is_same(o->stats, o->world.scene))) problem = "--stats would overwrite an input";
    if (!problem && o->aovs && !has_exr) problem = "--aov needs an .exr output";
    if (problem) fprintf(stderr, "fanal: error: %s; see 'fanal cave --help'\n", problem);
    return !problem;
}

static int print_displays(const char *source, const struct cave_displays *d) {
    const char *text = cave_displays_example(source);
    if (text) {
        fputs(text, stdout); /* own text */
        return 0;
    }
    for (uint32_t i = 0; i < d->wall_count; i++) {
        const struct cave_wall *w = &d->walls[i];
        printf("%-16s %5ux%-5u %6.3f x %.3f m  %s\n", w->name, w->width, w->height, cave_length(cave_subtract(w->lower_right, w->lower_left)),
               cave_length(cave_subtract(w->upper_left, w->lower_left)), w->stereo ? "stereo" : "mono");
    }
    return 0;
}

int command_cave(int argc, char **argv) {
    struct cave_options c = {.render = {.frame = fnl_frame_default(), .world = world_options_default(), .frame_count = 1, .frame_time = 1 / 30.0, .lit_casts = true},
                             .timeout = 60,
                             .hash = CAVE_HASH_SEED};
    struct option long_options[OWN_COUNT + OPTIONS_NAMED_MAX];
    bool prints = false;
    options_make_long(own_options, OWN_COUNT, false, long_options);
    optind = 0;
    for (int option; (option = argument_next(argc, argv, "o:qh", long_options)) != -1;) {
        const char *key = NULL;
        if (option == 'h') {
            print_help();
            return 0;
        }
        if (option == '?') return 2;
        if (option >= OPTIONS_NAMED && options_named((uint32_t)(option - OPTIONS_NAMED), &key) && options_print_values(key, optarg)) return 0;
        prints = prints || option == O_PRINT;
        if (option == O_PRINT) continue;
        if (!is_local(option)) {
            c.hash = cave_hash(&option, sizeof option, c.hash);
            if (optarg) c.hash = cave_hash(optarg, strlen(optarg) + 1, c.hash);
        }
        if (!(world_has(option) ? world_parse(option, optarg, &c.render.world) : parse_option(&c, option, optarg))) return 2;
    }
    if (!c.displays) {
        fputs("fanal: error: --displays FILE is needed; see 'fanal cave --help'\n", stderr);
        return 2;
    }
    if (argc - optind != (prints ? 0 : 1)) {
        fprintf(stderr, "fanal: error: %s, %d were given; see 'fanal cave --help'\n", prints ? "--print takes no scene" : "one scene is needed", argc - optind);
        return 2;
    }
    c.render.world.scene = argv[optind];
    world_set_frame(&c.render.world, &c.render.frame);
    c.places_by_camera = c.render.world.camera || c.render.world.has_eye;
    struct cave_displays displays;
    int status = 2;
    if (cave_displays_load(c.displays, &displays)) {
        if (prints)
            status = print_displays(c.displays, &displays);
        else if (check(&c, &displays))
            status = cave_run(&c, &displays);
    }
    cave_displays_free(&displays);
    return status;
}
