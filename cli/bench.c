/* SPDX-License-Identifier: MIT */
/* fanal bench: reads what to measure, makes the plan of it, and brings the parts together. */
#include "bench.h"

#include "arguments.h"
#include "commands.h"

#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LIGHTS_MAX = 1 << 20, VALUES_MAX = 64 };

struct bench_options {
    struct bench_settings settings;
    const struct bench_suite *suite;
    const char *camera;
    char list_options[512]; /* "key=value,key=value" */
    bool every_shading, every_lists;
    uint32_t way_counts[BENCH_WAY_COUNT];
    int ways[BENCH_WAY_COUNT][VALUES_MAX];
    uint32_t shading_count, lists_count, light_count, size_count, msaa_count;
    uint32_t shading[VALUES_MAX], lists[VALUES_MAX], lights[VALUES_MAX], sizes[VALUES_MAX][2], msaa[VALUES_MAX];
};

static const char *shading_name(int i) { return fnl_shading_name((fnl_shading)i); }
static const char *lists_name(int i) { return fnl_light_lists_name((fnl_light_lists)i); }

static const char *gbuffer_name(int i) { return bench_way_name(BENCH_WAY_GBUFFER, i); }
static const char *transparency_name(int i) { return bench_way_name(BENCH_WAY_TRANSPARENCY, i); }
static const char *decals_name(int i) { return bench_way_name(BENCH_WAY_DECALS, i); }
static const char *msaa_method_name(int i) { return bench_way_name(BENCH_WAY_MSAA_METHOD, i); }
static const char *visibility_sort_name(int i) { return bench_way_name(BENCH_WAY_VISIBILITY_SORT, i); }
static const char *barycentrics_name(int i) { return bench_way_name(BENCH_WAY_BARYCENTRICS, i); }
static const char *grid_name(int i) { return bench_way_name(BENCH_WAY_GRID, i); }
static const char *mobile_layout_name(int i) { return bench_way_name(BENCH_WAY_MOBILE_LAYOUT, i); }
static const char *mobile_lights_name(int i) { return bench_way_name(BENCH_WAY_MOBILE_LIGHTS, i); }
static const char *mobile_gamma_name(int i) { return bench_way_name(BENCH_WAY_MOBILE_GAMMA, i); }
static const char *dais_name(int i) { return bench_way_name(BENCH_WAY_DAIS, i); }
static const char *dais_multirate_name(int i) { return bench_way_name(BENCH_WAY_DAIS_MULTIRATE, i); }
static const char *culling_name(int i) { return bench_way_name(BENCH_WAY_CULL, i); }
static const char *geometry_name(int i) { return bench_way_name(BENCH_WAY_GEOMETRY, i); }
static const char *occlusion_name(int i) { return bench_way_name(BENCH_WAY_OCCLUSION, i); }
static const char *(*const way_names[BENCH_WAY_COUNT])(int) = {gbuffer_name,       transparency_name,    decals_name,
                                                               msaa_method_name,   visibility_sort_name, barycentrics_name,
                                                               grid_name,
                                                               mobile_layout_name, mobile_lights_name,   mobile_gamma_name,
                                                               dais_name,          dais_multirate_name,
                                                               culling_name,       geometry_name,        occlusion_name};

static void print_names(const char *(*name_of)(int)) {
    for (int i = 0; name_of(i); i++) printf(" %s", name_of(i));
    putchar('\n');
}

static void print_help(void) {
    puts("Usage: fanal bench SCENE... -o DIR [OPTIONS]\n"
         "       fanal bench --suite NAME [SCENE...] -o DIR [OPTIONS]\n"
         "\n"
         "Renders each SCENE (see 'fanal render --help') in every asked-for way, one frame of each in turn, compares all\n"
         "pictures with brute force, and writes DIR/results.csv, results.json and report.html, a page with plots that\n"
         "needs nothing else.\n"
         "\n"
         "What is compared (lists are separated by commas)\n"
         "  --shading KINDS|all        shading orders (all)\n"
         "  --lists KINDS|all          light lists; 'all' alone means every kind, 'brute' brute force alone (all)\n"
         "  --lights N,...             lights of the scene (as it is); a glTF scene gets N scattered ones more\n"
         "  --sizes WxH,...            pixels (1280x720)\n"
         "  --msaa N,...               samples per pixel: 1 2 4 8 (1)\n"
         "  --gbuffer KINDS|all        layouts of the G-buffer, of orders that have one (default)\n"
         "  --transparency KINDS|all   how blended surfaces are put together (sorted)\n"
         "  --decals WAYS|all          how decals get onto surfaces: lists, gbuffer, off (lists)\n"
         "  --mobile-layout, --mobile-lights, --mobile-gamma KINDS|all    of mobile (metallic-128; lists; srgb)\n"
         "  --msaa-method KINDS        of deferred with MSAA; 'all' is one of them (compact)\n"
         "  --visibility-sort KINDS|all    of visibility: off, class, material (off)\n"
         "  --visibility-barycentrics KINDS|all    of visibility with 1 sample: off, on (off)\n"
         "  --visibility-grid KINDS|all    of visibility with 1 sample: off, on (off)\n"
         "  --dais KINDS|all           of dais: where references to triangles stand: target, list (target)\n"
         "  --dais-multirate KINDS|all of dais: ambient light once for four pixels of a triangle: off, on (off)\n"
         "  --cull KINDS|all           what is left out before it is drawn: instances clusters triangles (instances)\n"
         "  --geometry KINDS|all       what draws the clusters that --cull leaves: vertex mesh (vertex)\n"
         "  --occlusion KINDS|all      and whether what others hide is: off, on (off)\n"
         "  --list-option KEY=VALUE    a setting of the lists, as for 'fanal render'; may be given several times\n"
         "  --suite NAME               instead of scenes: the experiments of a publication, with its ratios beside ours;\n"
         "                             geometry and visibility bring scenes and options, which may be replaced, and tables\n"
         "\n"
         "View\n"
         "  --camera NAME|INDEX        a camera of the scene (its first one, else one that frames the scene)\n"
         "  --camera-path FILE|orbit   frame i takes point i of a path; FILE has lines of\n"
         "                             'seconds eye.x eye.y eye.z target.x target.y target.z'\n"
         "\n"
         "Run\n"
         "  -o, --output DIR           where the results go; made if it is not there\n"
         "  --frames N                 timed frames of each (10)\n"
         "  --warm-up N                frames of each before them (2)\n"
         "  --checks N                 points of the path whose pictures are compared; 0: none (1, with a path 3)\n"
         "  --reference KIND           the lists that the others are compared with (all)\n"
         "  --resume                   goes on with DIR: measures only what it does not hold yet\n"
         "  --device INDEX|NAME        as 'fanal devices' lists them (the best)\n"
         "  --validate                 Vulkan validation (slow, times mean little); any message makes the command fail\n"
         "  -q, --quiet                prints nothing but errors\n"
         "  -h, --help                 prints this text\n");
    fputs("Shading orders:", stdout);
    print_names(shading_name);
    fputs("Lists:", stdout);
    print_names(lists_name);
    fputs("G-buffers:", stdout);
    print_names(gbuffer_name);
    fputs("Transparency:", stdout);
    print_names(transparency_name);
    fputs("MSAA methods:", stdout);
    print_names(msaa_method_name);
    fputs("Suites:", stdout);
    print_names(bench_suite_name);
    puts("\nCtrl-C ends the measuring; what was measured is kept and written.\n"
         "Exit status: 0 when everything was measured and written, 1 when a picture differs from the reference, 2 on an\n"
         "error, 130 after Ctrl-C.\n"
         "\n"
         "Examples:\n"
         "  fanal bench builtin:hall --lights 64,256,1024,4096 --shading deferred -o hall\n"
         "  fanal bench city.glb builtin:glass --lists brute,tiled,clustered --msaa 1,4 --frames 30 -o compare\n"
         "  fanal bench --suite thesis -o thesis\n"
         "  fanal bench --suite geometry -o geometry\n"
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
        o->shading[o->shading_count++] = (uint32_t)value;
    } else if (strcmp(option, "lists") == 0) {
        if (strcmp(text, "brute") == 0) text = fnl_light_lists_name(FNL_LISTS_ALL);
        if (!argument_name(option, text, lists_name, &value)) return false;
        o->lists[o->lists_count++] = (uint32_t)value;
    } else if (strcmp(option, "lights") == 0) {
        return parse_count(option, text, 0, LIGHTS_MAX, &o->lights[o->light_count++]);
    } else if (strcmp(option, "msaa") == 0) {
        uint32_t *samples = &o->msaa[o->msaa_count++];
        if (!parse_count(option, text, 1, 8, samples)) return false;
        if (*samples & (*samples - 1)) return argument_bad(option, text, "one of 1 2 4 8");
    } else if (strcmp(option, "sizes") != 0) {
        int way = 0;
        while (strcmp(option, bench_way_key((enum bench_way)way)) != 0) way++;
        return argument_name(option, text, way_names[way], &o->ways[way][o->way_counts[way]++]);
    } else {
        uint32_t *size = o->sizes[o->size_count++];
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
        if (*count == VALUES_MAX) return argument_bad(option, text, "a list of at most 64 values");
        if (!parse_value(o, option, part)) return false;
    }
    return true;
}

/* "all" means every value, unless it is the name of one. */
static bool parse_way(struct bench_options *o, enum bench_way way, const char *text) {
    uint32_t *count = &o->way_counts[way];
    bool every = strcmp(text, "all") == 0;
    for (int i = 0; bench_way_name(way, i) && every; i++) every = strcmp(bench_way_name(way, i), text) != 0;
    if (!every) return parse_values(o, bench_way_key(way), text, count);
    for (*count = 0; bench_way_name(way, (int)*count); ++*count) o->ways[way][*count] = (int)*count;
    return true;
}

static bool add_list_option(struct bench_options *o, const char *text) {
    fnl_list_options parsed = fnl_list_options_default();
    size_t length = strlen(o->list_options), left = sizeof o->list_options - length;
    if (!argument_list_options("list-option", text, &parsed)) return false;
    return snprintf(o->list_options + length, left, "%s%s", length ? "," : "", text) < (int)left ||
           argument_bad("list-option", text, "short enough");
}

enum {
    O_SHADING = 256,
    O_LISTS,
    O_LIGHTS,
    O_SIZES,
    O_MSAA,
    O_GBUFFER,
    O_TRANSPARENCY,
    O_DECALS,
    O_MSAA_METHOD,
    O_VISIBILITY_SORT,
    O_VISIBILITY_BARYCENTRICS,
    O_VISIBILITY_GRID,
    O_MOBILE_LAYOUT,
    O_MOBILE_LIGHTS,
    O_MOBILE_GAMMA,
    O_DAIS,
    O_DAIS_MULTIRATE,
    O_CULL,
    O_GEOMETRY,
    O_OCCLUSION,
    O_LIST_OPTION,
    O_SUITE,
    O_CAMERA,
    O_CAMERA_PATH,
    O_FRAMES,
    O_WARM_UP,
    O_CHECKS,
    O_REFERENCE,
    O_RESUME,
    O_DEVICE,
    O_VALIDATE
};

static const struct option long_options[] = {{"output", required_argument, NULL, 'o'},
                                             {"quiet", no_argument, NULL, 'q'},
                                             {"help", no_argument, NULL, 'h'},
                                             {"shading", required_argument, NULL, O_SHADING},
                                             {"lists", required_argument, NULL, O_LISTS},
                                             {"lights", required_argument, NULL, O_LIGHTS},
                                             {"sizes", required_argument, NULL, O_SIZES},
                                             {"msaa", required_argument, NULL, O_MSAA},
                                             {"gbuffer", required_argument, NULL, O_GBUFFER},
                                             {"transparency", required_argument, NULL, O_TRANSPARENCY},
                                             {"decals", required_argument, NULL, O_DECALS},
                                             {"msaa-method", required_argument, NULL, O_MSAA_METHOD},
                                             {"visibility-sort", required_argument, NULL, O_VISIBILITY_SORT},
                                             {"visibility-barycentrics", required_argument, NULL, O_VISIBILITY_BARYCENTRICS},
                                             {"visibility-grid", required_argument, NULL, O_VISIBILITY_GRID},
                                             {"mobile-layout", required_argument, NULL, O_MOBILE_LAYOUT},
                                             {"mobile-lights", required_argument, NULL, O_MOBILE_LIGHTS},
                                             {"mobile-gamma", required_argument, NULL, O_MOBILE_GAMMA},
                                             {"dais", required_argument, NULL, O_DAIS},
                                             {"dais-multirate", required_argument, NULL, O_DAIS_MULTIRATE},
                                             {"cull", required_argument, NULL, O_CULL},
                                             {"geometry", required_argument, NULL, O_GEOMETRY},
                                             {"occlusion", required_argument, NULL, O_OCCLUSION},
                                             {"list-option", required_argument, NULL, O_LIST_OPTION},
                                             {"suite", required_argument, NULL, O_SUITE},
                                             {"camera", required_argument, NULL, O_CAMERA},
                                             {"camera-path", required_argument, NULL, O_CAMERA_PATH},
                                             {"frames", required_argument, NULL, O_FRAMES},
                                             {"warm-up", required_argument, NULL, O_WARM_UP},
                                             {"checks", required_argument, NULL, O_CHECKS},
                                             {"reference", required_argument, NULL, O_REFERENCE},
                                             {"resume", no_argument, NULL, O_RESUME},
                                             {"device", required_argument, NULL, O_DEVICE},
                                             {"validate", no_argument, NULL, O_VALIDATE},
                                             {NULL, 0, NULL, 0}};

static bool parse_option(struct bench_options *o, int option, const char *value) {
    struct bench_settings *s = &o->settings;
    int index;
    switch (option) {
    case 'o':
        s->output = value;
        return *value || argument_bad("output", value, "a folder");
    case 'q':
        s->quiet = true;
        return true;
    case O_SHADING:
        o->every_shading = strcmp(value, "all") == 0;
        return o->every_shading || parse_values(o, "shading", value, &o->shading_count);
    case O_LISTS:
        o->every_lists = strcmp(value, "all") == 0;
        return o->every_lists || parse_values(o, "lists", value, &o->lists_count);
    case O_LIGHTS:
        return parse_values(o, "lights", value, &o->light_count);
    case O_SIZES:
        return parse_values(o, "sizes", value, &o->size_count);
    case O_MSAA:
        return parse_values(o, "msaa", value, &o->msaa_count);
    case O_GBUFFER:
        return parse_way(o, BENCH_WAY_GBUFFER, value);
    case O_TRANSPARENCY:
        return parse_way(o, BENCH_WAY_TRANSPARENCY, value);
    case O_DECALS:
        return parse_way(o, BENCH_WAY_DECALS, value);
    case O_MSAA_METHOD:
        return parse_way(o, BENCH_WAY_MSAA_METHOD, value);
    case O_VISIBILITY_SORT:
        return parse_way(o, BENCH_WAY_VISIBILITY_SORT, value);
    case O_VISIBILITY_BARYCENTRICS:
        return parse_way(o, BENCH_WAY_BARYCENTRICS, value);
    case O_VISIBILITY_GRID:
        return parse_way(o, BENCH_WAY_GRID, value);
    case O_MOBILE_LAYOUT:
        return parse_way(o, BENCH_WAY_MOBILE_LAYOUT, value);
    case O_MOBILE_LIGHTS:
        return parse_way(o, BENCH_WAY_MOBILE_LIGHTS, value);
    case O_MOBILE_GAMMA:
        return parse_way(o, BENCH_WAY_MOBILE_GAMMA, value);
    case O_DAIS:
        return parse_way(o, BENCH_WAY_DAIS, value);
    case O_DAIS_MULTIRATE:
        return parse_way(o, BENCH_WAY_DAIS_MULTIRATE, value);
    case O_CULL:
        return parse_way(o, BENCH_WAY_CULL, value);
    case O_GEOMETRY:
        return parse_way(o, BENCH_WAY_GEOMETRY, value);
    case O_OCCLUSION:
        return parse_way(o, BENCH_WAY_OCCLUSION, value);
    case O_LIST_OPTION:
        return add_list_option(o, value);
    case O_SUITE:
        o->suite = bench_suite_find(value);
        return o->suite || argument_name("suite", value, bench_suite_name, &index);
    case O_CAMERA:
        o->camera = value;
        return true;
    case O_CAMERA_PATH:
        s->camera_path = value;
        return true;
    case O_FRAMES:
        return parse_count("frames", value, 1, 100000, &s->frames);
    case O_WARM_UP:
        return parse_count("warm-up", value, 0, 100000, &s->warm_up);
    case O_CHECKS:
        return parse_count("checks", value, 0, 100000, &s->checks);
    case O_REFERENCE:
        if (!argument_name("reference", value, lists_name, &index)) return false;
        s->reference = (fnl_light_lists)index;
        return true;
    case O_RESUME:
        s->resume = true;
        return true;
    case O_DEVICE:
        s->device = value;
        return true;
    case O_VALIDATE:
        s->validate = true;
        return true;
    default:
        return false;
    }
}

/* ---- the plan ---- */

static bool same_case(const struct bench_case *a, const struct bench_case *b) {
    return strcmp(a->scene, b->scene) == 0 && a->lights == b->lights && a->width == b->width && a->height == b->height &&
           a->msaa == b->msaa;
}

struct bench_case *bench_plan_case(struct bench_plan *plan, const struct bench_case *wanted) {
    for (uint32_t i = 0; i < plan->case_count; i++)
        if (same_case(&plan->cases[i], wanted)) return &plan->cases[i];
    struct bench_case *bigger = realloc(plan->cases, (plan->case_count + 1) * sizeof *bigger);
    if (!bigger) return NULL;
    plan->cases = bigger;
    struct bench_case *added = &bigger[plan->case_count++];
    *added = *wanted;
    added->candidates = NULL;
    added->candidate_count = 0;
    return added;
}

static bool skip(struct bench_plan *plan, const struct bench_case *where, const struct bench_candidate *what,
                 const char *reason) {
    json_t *entry = bench_key(where, what);
    const json_t *other;
    size_t i;
    if (!entry) return false;
    json_object_set_new(entry, "reason", json_string(reason));
    json_array_foreach(plan->skipped, i, other) {
        if (!json_equal(entry, other)) continue;
        json_decref(entry);
        return true;
    }
    return json_array_append_new(plan->skipped, entry) == 0;
}

bool bench_plan_candidate(struct bench_plan *plan, struct bench_case *to, const struct bench_candidate *candidate) {
    for (uint32_t i = 0; i < to->candidate_count; i++) {
        const struct bench_candidate *other = &to->candidates[i];
        if (other->shading == candidate->shading && other->lists == candidate->lists &&
            strcmp(other->options, candidate->options) == 0)
            return true;
    }
    if (!fnl_lists_supported(candidate->shading, candidate->lists))
        return skip(plan, to, candidate, "these lists do not go with this shading order");
    if (to->msaa > 1 && !fnl_msaa_supported(candidate->shading))
        return skip(plan, to, candidate, "this shading order has no MSAA");
    if (strstr(candidate->options, "visibility-barycentrics=on") && strstr(candidate->options, "visibility-grid=on"))
        return skip(plan, to, candidate, "the grid stores no barycentrics");
    if (strstr(candidate->options, "geometry=mesh") && !strstr(candidate->options, "cull="))
        return skip(plan, to, candidate, "mesh shaders draw what culling by clusters or triangles leaves");
    struct bench_candidate *bigger = realloc(to->candidates, (to->candidate_count + 1) * sizeof *bigger);
    if (!bigger) return false;
    to->candidates = bigger;
    bigger[to->candidate_count] = *candidate;
    bigger[to->candidate_count].options = strdup(candidate->options);
    return bigger[to->candidate_count++].options != NULL;
}

/* Every combination of the ways that were asked for; those that an order does not heed add nothing. */
static bool plan_ways(const struct bench_options *o, struct bench_plan *plan, struct bench_case *to, fnl_shading shading,
                      fnl_light_lists lists) {
    uint32_t combinations = 1;
    for (int w = 0; w < BENCH_WAY_COUNT; w++) combinations *= o->way_counts[w] ? o->way_counts[w] : 1;
    for (uint32_t i = 0; i < combinations; i++) {
        struct bench_ways chosen = bench_ways_default();
        char options[sizeof o->list_options + 256];
        for (uint32_t w = 0, rest = i; w < BENCH_WAY_COUNT; w++) {
            if (!o->way_counts[w]) continue;
            int value = o->ways[w][rest % o->way_counts[w]];
            rest /= o->way_counts[w];
            if (bench_way_heeded((enum bench_way)w, value, shading, to->msaa)) chosen.values[w] = value;
        }
        bench_ways_print(&chosen, o->list_options, options, sizeof options);
        struct bench_candidate candidate = {shading, lists, options};
        if (!bench_plan_candidate(plan, to, &candidate)) return false;
    }
    return true;
}

static bool plan_case(const struct bench_options *o, struct bench_plan *plan, const struct bench_case *wanted) {
    struct bench_case *to = bench_plan_case(plan, wanted);
    for (uint32_t s = 0; to && s < o->shading_count; s++)
        for (uint32_t l = 0; l < o->lists_count; l++) {
            /* Its pictures and times are the same with all lists but for transparent surfaces. */
            if (o->every_lists && l > 0 &&
                (o->shading[s] == FNL_SHADING_DEFERRED_VOLUMES || o->shading[s] == FNL_SHADING_PRE_LIGHTING ||
                 o->shading[s] == FNL_SHADING_LIGHT_INDEXED || o->shading[s] == FNL_SHADING_ZIOMA))
                break;
            if (!plan_ways(o, plan, to, (fnl_shading)o->shading[s], (fnl_light_lists)o->lists[l])) return false;
        }
    return to != NULL;
}

/* All but the choosers, which are none of their own. */
static uint32_t every_name(const char *(*name_of)(int), uint32_t *out) {
    uint32_t count = 0;
    for (int i = 0; name_of(i) && count < VALUES_MAX; i++)
        if (strcmp(name_of(i), "auto") != 0) out[count++] = (uint32_t)i;
    return count;
}

static bool plan_matrix(struct bench_options *o, const char *const *scenes, int scene_count, struct bench_plan *plan) {
    o->every_shading |= o->shading_count == 0;
    o->every_lists |= o->lists_count == 0;
    if (o->every_shading) o->shading_count = every_name(shading_name, o->shading);
    if (o->every_lists) o->lists_count = every_name(lists_name, o->lists);
    if (o->size_count == 0) memcpy(o->sizes[o->size_count++], (uint32_t[2]){1280, 720}, sizeof o->sizes[0]);
    if (o->msaa_count == 0) o->msaa[o->msaa_count++] = 1;
    for (int scene = 0; scene < scene_count; scene++)
        for (uint32_t lights = 0; lights < o->light_count + !o->light_count; lights++)
            for (uint32_t size = 0; size < o->size_count; size++)
                for (uint32_t m = 0; m < o->msaa_count; m++) {
                    struct bench_case wanted = {.scene = scenes[scene],
                                                .camera = o->camera,
                                                .lights = o->light_count ? (int64_t)o->lights[lights] : -1,
                                                .width = o->sizes[size][0],
                                                .height = o->sizes[size][1],
                                                .msaa = o->msaa[m]};
                    if (!plan_case(o, plan, &wanted)) return false;
                }
    return true;
}

static void free_plan(struct bench_plan *plan) {
    for (uint32_t i = 0; i < plan->case_count; i++) {
        for (uint32_t c = 0; c < plan->cases[i].candidate_count; c++) free(plan->cases[i].candidates[c].options);
        free(plan->cases[i].candidates);
    }
    free(plan->cases);
    json_decref(plan->skipped);
}

/* ---- running ---- */

/* What only makes sense together. */
static bool check_options(const struct bench_options *o, int scene_count) {
    const char *problem = NULL;
    bool closed = o->suite && bench_suite_kind_of(o->suite) != BENCH_SUITE_MATRIX;
    if (closed && scene_count > 0) problem = "--suite brings its own scenes: give none";
    if (closed && (o->shading_count || o->lists_count || o->every_shading || o->every_lists || o->light_count ||
                     o->msaa_count || *o->list_options || o->camera || o->settings.camera_path))
        problem = "--suite chooses shading, lists, lights, samples, options and cameras itself";
    for (int w = 0; w < BENCH_WAY_COUNT && closed; w++)
        if (o->way_counts[w]) problem = "--suite chooses G-buffers, transparency, decals and MSAA methods itself";
    if (closed && o->size_count > 1) problem = "--suite takes one size";
    if (!o->suite && scene_count == 0) problem = "at least one scene or --suite is needed";
    if (!o->settings.output) problem = "a folder for the results is needed: give -o DIR";
    if (problem) fprintf(stderr, "fanal: error: %s; see 'fanal bench --help'\n", problem);
    return !problem;
}

/* A misspelt name must not cost the time of the measurements before it. */
static bool check_scenes(const char *const *scenes, int count) {
    for (int i = 0; i < count; i++) {
        fnl_scene *scene = NULL;
        fnl_host host = fnl_host_default();
        if (fnl_scene_load(&host, scenes[i], &scene) != FNL_OK) return false;
        fnl_scene_destroy(&scene);
    }
    return true;
}

static int run(struct bench_options *o, const struct bench_plan *plan, struct bench_data *data) {
    const struct bench_settings *s = &o->settings;
    uint32_t width = o->size_count ? o->sizes[0][0] : 0, height = o->size_count ? o->sizes[0][1] : 0;
    enum bench_end end = bench_measure(s, plan, data);
    if (end == BENCH_REFUSED) return 2;
    if (end == BENCH_DONE && o->suite && !bench_suite_measure(o->suite, s, width, height, data)) end = BENCH_FAILED;
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
    return bench_unequal_count(data) ? 1 : 0;
}

/* The status to end with, or -1 to go on. */
static int read_arguments(struct bench_options *o, int argc, char **argv) {
    optind = 0;
    for (int option; (option = getopt_long(argc, argv, "o:qh", long_options, NULL)) != -1;) {
        if (option == 'h') {
            print_help();
            return 0;
        }
        if (option == '?') {
            fputs("fanal: see 'fanal bench --help'\n", stderr);
            return 2;
        }
        if (!parse_option(o, option, optarg)) return 2;
    }
    return -1;
}

static struct bench_options default_options(void) {
    return (struct bench_options){.settings = {.frames = 10, .warm_up = 2, .checks = UINT32_MAX}};
}

/* The options of a suite first, then those of the command once more, which replace them. */
static int read_over_suite(struct bench_options *o, int argc, char **argv) {
    const struct bench_suite *suite = o->suite;
    const char *const *preset;
    *o = default_options();
    for (int i = 0; (preset = bench_suite_option(suite, i)) != NULL; i++) {
        const struct option *option = long_options;
        while (option->name && strcmp(option->name, preset[0]) != 0) option++;
        if (!option->name || !parse_option(o, option->val, preset[1])) return 2;
    }
    return read_arguments(o, argc, argv);
}

int command_bench(int argc, char **argv) {
    struct bench_options o = default_options();
    int early = read_arguments(&o, argc, argv);
    if (early < 0 && o.suite) early = read_over_suite(&o, argc, argv);
    if (early >= 0) return early;
    const char *const *scenes = (const char *const *)argv + optind;
    int scene_count = argc - optind;
    if (o.suite && scene_count == 0)
        for (scenes = bench_suite_scenes(o.suite); scenes[scene_count]; scene_count++) continue;
    if (o.settings.checks == UINT32_MAX) o.settings.checks = o.settings.camera_path ? 3 : 1;
    if (!check_options(&o, scene_count) || !check_scenes(scenes, scene_count) || !bench_prepare_folder(o.settings.output))
        return 2;

    struct bench_plan plan = {.skipped = json_array()};
    struct bench_data data = {NULL, NULL};
    bool matrix = !o.suite || bench_suite_kind_of(o.suite) == BENCH_SUITE_MATRIX;
    bool planned =
        matrix ? plan_matrix(&o, scenes, scene_count, &plan)
               : bench_suite_plan(o.suite, o.size_count ? o.sizes[0][0] : 0, o.size_count ? o.sizes[0][1] : 0, &plan);
    int status = 2;
    if (!planned)
        fputs("fanal: error: memory ran out\n", stderr);
    else if (!o.settings.resume || bench_load(o.settings.output, &data)) {
        if (!data.root) data.root = json_object();
        if (!data.pictures) data.pictures = json_object();
        status = run(&o, &plan, &data);
    }
    json_decref(data.root);
    json_decref(data.pictures);
    free_plan(&plan);
    return status;
}
