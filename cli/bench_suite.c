/* SPDX-License-Identifier: MIT */
/* Experiments of the literature, rebuilt: ratios of two ways to render one scene, beside the ratios of the source. Times of another
 * machine mean nothing here, so every quantity is a ratio within one run. */
#include "bench.h"

#include "json_text.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct setup {
    fnl_shading shading;
    fnl_light_lists lists;
    const char *options;
};

/* ours = quantity(a) / quantity(b), and should be at most (or at least) `limit`. */
struct row {
    const char *quantity; /* NULL: both are measured for a table */
    const char *metric;   /* a time or a number of a result; "fill" or "shell": the list passes with this in their name;
                             "gpu_ms p95/median": how uneven frames are */
    const char *scene;
    int64_t lights_a, lights_b; /* -1: as the scene has them */
    struct setup a, b;
    bool at_least;
    double source, limit;
    uint32_t msaa_a, msaa_b; /* 0: 1 sample */
    const char *scene_b;     /* NULL: the same */
};

struct bench_suite {
    const char *name, *title;
    enum bench_suite_kind kind;
    uint32_t width, height; /* of ratios */
    const struct row *rows;
    uint32_t row_count;
    bench_suite_measurer *measure;
    bool takes_all; /* bench_settings.all */
    const char *camera_path; /* bench_settings.camera_path; NULL: the camera stands still */
    /* Of a matrix; both end with NULL. */
    const char *scenes[4], *options[8][2];
    bench_suite_tabulator *tabulate;
};

/* ---- Ishmukhametov: Efficient Tile-Based Deferred Shading Pipeline, DigiPen 2013: four walls ---- */

/* clang-format off */
#define VOLUMES {FNL_SHADING_DEFERRED_VOLUMES, FNL_LISTS_ALL, ""}
#define TILED {FNL_SHADING_DEFERRED, FNL_LISTS_TILED, ""}
#define BACKFACE {FNL_SHADING_DEFERRED, FNL_LISTS_BACKFACE, ""}
#define WALL(test, quantity, a, b, at_least, source)                                                                         \
    {"test " #test ": " quantity, "gpu_ms", "builtin:wall?test=" #test, -1, -1, a, b, at_least, source, source, .msaa_a = 1}
#define WALLS(test, volumes_tiled, backface_tiled, volumes_backface)                                                         \
    WALL(test, "light volumes / tiled", VOLUMES, TILED, true, volumes_tiled),                                                \
    WALL(test, "tiled with back faces / tiled", BACKFACE, TILED, false, backface_tiled),                                     \
    WALL(test, "light volumes / tiled with back faces", VOLUMES, BACKFACE, true, volumes_backface)

static const struct row thesis_rows[] = {
    WALLS(1, 1.18, 1.053, 1.12),
    WALLS(2, 1.60, 0.853, 1.87),
    WALLS(3, 2.17, 0.667, 3.26),
    WALLS(4, 2.36, 0.603, 3.91),
};

/* ---- Ortegren, Persson: Clustered Shading: Assigning Lights Using Conservative Rasterization, GPU Pro 7 ---- */

/* Grids at 1536 x 768: clusters of 64 pixels make 24 x 12 tiles, of 32 pixels 48 x 24. */
#define GRID(size, slices, distribution)                                                                                     \
    {FNL_SHADING_DEFERRED, FNL_LISTS_RASTER, "clusters.size=" #size ",clusters.slices=" #slices ",clusters.distribution=" distribution}
#define RASTER(size, slices) GRID(size, slices, "exponential")
#define LINEAR(size, slices) GRID(size, slices, "linear")
#define NODES(size, slices, bits) GRID(size, slices, "exponential,raster.nodes=links" #bits)
#define HALL(quantity, metric, lights_a, lights_b, a, b, source, limit)                                                      \
    {quantity, metric, "builtin:hall", lights_a, lights_b, a, b, false, source, limit, .msaa_a = 1}
#define SLICES(tiles, size, slices, lights)                                                                                  \
    {tiles "x" #slices ": shading, linear / exponential, " #lights " lights", "shading_ms", "builtin:hall", lights, lights,  \
     LINEAR(size, slices), RASTER(size, slices), true, NAN, 0, .msaa_a = 1}
#define GRIDS(lights)                                                                                                        \
    SLICES("24x12", 64, 32, lights), SLICES("24x12", 64, 64, lights), SLICES("24x12", 64, 128, lights),                      \
    SLICES("48x24", 32, 32, lights), SLICES("48x24", 32, 64, lights), SLICES("48x24", 32, 128, lights)

static const struct row clustered_rows[] = {
    GRIDS(1024),
    GRIDS(2048),
    GRIDS(4096),
    HALL("assignment, 24x12x128 / tiled culling, 4096 lights", "lists_ms", 4096, 4096, RASTER(64, 128), TILED, 1.05, 1.05),
    HALL("lights per pixel, 24x12x128 / tiled, 4096 lights", "per_pixel", 4096, 4096, RASTER(64, 128), TILED, 1, 1),
    HALL("fill, 48x24x128 / 24x12x32, 4096 lights", "fill", 4096, 4096, RASTER(32, 128), RASTER(64, 32), 6.5, 6.5),
    HALL("shell, 48x24x32 / 24x12x32, 4096 lights", "shell", 4096, 4096, RASTER(32, 32), RASTER(64, 32), 1, 1.1),
    HALL("assignment, 24x12x128, 4096 / 2048 lights", "lists_ms", 4096, 2048, RASTER(64, 128), RASTER(64, 128), 2, 2),
    HALL("shading, 48x24x128 / 24x12x64, 4096 lights", "shading_ms", 4096, 4096, RASTER(32, 128), RASTER(64, 64), 0.717, 0.717),
    HALL("memory, 24x12x128 32-bit / 48x24x32 64-bit, 4096 lights", "list_used_bytes", 4096, 4096, NODES(64, 128, 32), NODES(32, 32, 64), 0.377, 0.377),
    HALL("memory, 48x24x128 / 24x12x64, 4096 lights", "list_used_bytes", 4096, 4096, RASTER(32, 128), RASTER(64, 64), 6.6, 6.6),
    HALL("shading, 24x12x128 / 48x24x32, 4096 lights", "shading_ms", 4096, 4096, RASTER(64, 128), RASTER(32, 32), 1, 1),
};

/* ---- Mikkelsen: Fine Pruned Tiled Light Lists, GPU Pro 7 ---- */

/* Coarse: the box of a light on the screen and in depth against that of a tile, by the same passes. */
#define COARSE {FNL_SHADING_DEFERRED, FNL_LISTS_FINE, "fine.pruning=off"}
#define FINE {FNL_SHADING_DEFERRED, FNL_LISTS_FINE, ""}
/* Without masks of pixels, as the source builds its lists. */
#define PRUNED {FNL_SHADING_DEFERRED, FNL_LISTS_FINE, "fine.masks=0"}
#define INTERIOR(quantity, metric, lights, a, b, at_least, source)                                                           \
    {quantity ", " #lights " lights", metric, "builtin:interior?overlap=3", lights, lights, a, b, at_least, source, source, .msaa_a = 1}
#define INTERIORS(lights)                                                                                                    \
    INTERIOR("deferred lighting, coarse / fine", "shading_ms", lights, COARSE, FINE, true, 3.86),                            \
    INTERIOR("lists and lighting, coarse / fine", "lists_ms+shading_ms", lights, COARSE, FINE, true, 1.64),                  \
    INTERIOR("list build, fine / coarse", "lists_ms", lights, PRUNED, COARSE, false, 3.4),                                    \
    INTERIOR("lights per pixel, coarse / fine", "per_pixel", lights, COARSE, FINE, true, NAN)

static const struct row fine_rows[] = {INTERIORS(40), INTERIORS(80), INTERIORS(120)};

/* ---- Akenine-Moeller et al.: Real-Time Rendering, 4th edition, chapter 20: nine rankings, and table 20.1 ---- */

#define CITY "builtin:city"
#define FORWARD(options) {FNL_SHADING_FORWARD, FNL_LISTS_CLUSTERED, options}
#define PREPASS BENCH_RTR20_PREPASS
#define DEFERRED(lists) {FNL_SHADING_DEFERRED, FNL_LISTS_##lists, ""}
#define VISIBILITY {FNL_SHADING_VISIBILITY, FNL_LISTS_CLUSTERED, ""}
#define TEXTURING(options) {FNL_SHADING_TEXTURING, FNL_LISTS_CLUSTERED, options}
/* The source says which one wins, not by how much. */
#define RANK(quantity, lights, samples, a, b, at_least)                                                                      \
    {quantity, "gpu_ms", CITY, lights, lights, a, b, at_least, 1, 1, .msaa_a = samples, .msaa_b = samples}
/* One pipeline of the table, with and without what a row of it is about. */
#define PIPELINE(setup)                                                                                                      \
    {NULL, NULL, CITY, 256, 256, setup, setup, .msaa_b = 4},                                                                 \
    {NULL, NULL, CITY, 256, 256, setup, setup, .scene_b = BENCH_RTR20_SMALL},                                                \
    {NULL, NULL, CITY, 256, 256, setup, setup, .scene_b = BENCH_RTR20_DECALS}

static const struct row rtr20_rows[] = {
    RANK("1: clustered forward / clustered deferred, 1 sample, 1024 lights", 1024, 1, PREPASS, DEFERRED(CLUSTERED), true),
    RANK("1: clustered forward / clustered deferred, 4 samples, 1024 lights", 1024, 4, PREPASS, DEFERRED(CLUSTERED), false),
    RANK("2: tiled / half-Z, deferred, 1024 lights", 1024, 1, DEFERRED(TILED), DEFERRED(HALFZ), true),
    RANK("2: half-Z / tiled, deferred, 128 lights", 128, 1, DEFERRED(HALFZ), DEFERRED(TILED), true),
    RANK("3: half-Z / 2.5D, deferred, 4096 lights", 4096, 1, DEFERRED(HALFZ), DEFERRED(25D), true),
    RANK("4: forward front to back / with a separate prepass, 1024 lights", 1024, 1, FORWARD("front-to-back=on"), PREPASS, true),
    RANK("5: clustered forward without prepass / deferred texturing, 1024 lights", 1024, 1, FORWARD(""), TEXTURING(""), true),
    RANK("5: clustered forward with prepass / deferred texturing, 1024 lights", 1024, 1, PREPASS, TEXTURING(""), true),
    RANK("6: deferred / visibility buffer, 1 sample, 256 lights", 256, 1, DEFERRED(CLUSTERED), VISIBILITY, true),
    RANK("6: deferred / visibility buffer, 4 samples, 256 lights", 256, 4, DEFERRED(CLUSTERED), VISIBILITY, true),
    RANK("7: clustered forward / deferred+, 1024 lights", 1024, 1, PREPASS, TEXTURING("occlusion=on"), true),
    {"8: unevenness along an orbit, tiled / clustered, deferred, 1024 lights", "gpu_ms p95/median", CITY, 1024, 1024, DEFERRED(TILED), DEFERRED(CLUSTERED), true, 1, 1, .msaa_a = 1},
    PIPELINE(BENCH_RTR20_FORWARD),
    PIPELINE(BENCH_RTR20_VOLUMES),
    PIPELINE(BENCH_RTR20_DEFERRED),
    PIPELINE(BENCH_RTR20_PREPASS),
};
/* clang-format on */

static const struct bench_suite suites[] = {
    {.name = "thesis",
     .title = "Ishmukhametov 2013: light volumes, tiles, and tiles that drop lights behind their surfaces",
     .width = 1280,
     .height = 720,
     .rows = thesis_rows,
     .row_count = sizeof thesis_rows / sizeof *thesis_rows},
    {.name = "clustered",
     .title = "Ortegren and Persson 2016: clusters by conservative rasterisation",
     .width = 1536,
     .height = 768,
     .rows = clustered_rows,
     .row_count = sizeof clustered_rows / sizeof *clustered_rows},
    {.name = "aa",
     .title = "antialiasing against 64 samples a pixel",
     .kind = BENCH_SUITE_OWN,
     .measure = bench_aa_measure},
    {.name = "coarse",
     .title = "Sathe and Janczak 2016: deferred coarse pixel shading",
     .kind = BENCH_SUITE_OWN,
     .measure = bench_coarse_measure},
    {.name = "fine-pruned",
     .title = "Mikkelsen 2016: fine pruned tiles",
     .width = 1920,
     .height = 1080,
     .rows = fine_rows,
     .row_count = sizeof fine_rows / sizeof *fine_rows},
    {.name = "rtr20",
     .title = "Akenine-Moeller et al. 2018, chapter 20: rankings and table 20.1",
     .width = 1280,
     .height = 720,
     .rows = rtr20_rows,
     .row_count = sizeof rtr20_rows / sizeof *rtr20_rows,
     .camera_path = "orbit",
     .tabulate = bench_table_rtr20},
    {.name = "stereo",
     .title = "two eyes: what they cost over one, and what mono in the distance saves",
     .kind = BENCH_SUITE_OWN,
     .measure = bench_stereo_measure,
     .tabulate = bench_table_stereo},
    {.name = "dais",
     .title = "Schied and Dachsbacher 2016: deferred attribute interpolation",
     .kind = BENCH_SUITE_OWN,
     .measure = bench_dais_measure,
     .tabulate = bench_table_dais},
    {.name = "shadows",
     .title = "shadow maps and rays, as lights become more",
     .kind = BENCH_SUITE_OWN,
     .measure = bench_shadows_measure,
     .takes_all = true,
     .tabulate = bench_table_shadows},
    {.name = "geometry",
     .title = "what is left out before it is drawn, as the scene grows",
     .kind = BENCH_SUITE_MATRIX,
     .scenes = {"builtin:city", "builtin:city?triangles=10000000", "builtin:city?triangles=100000000"},
     .options = {{"shading", "visibility"}, {"lists", "clustered"}, {"lights", "16"}, {"shadows", "off"}, {"cull", "all"}, {"occlusion", "all"}},
     .tabulate = bench_table_geometry},
    {.name = "visibility",
     .title = "Engel 2016, Pettineo 2016: ids of triangles and deferred texturing against forward and deferred shading",
     .kind = BENCH_SUITE_MATRIX,
     .scenes = {"builtin:hall", "builtin:hall?overdraw=1"},
     .options = {{"shading", "forward,forward-prepass,deferred,visibility,texturing"},
                 {"lists", "clustered"},
                 {"shadows", "off"},
                 {"sizes", "1280x720,1920x1080,2560x1440,3840x2160"},
                 {"msaa", "1,4"}},
     .tabulate = bench_table_orders},
};
enum { SUITE_COUNT = sizeof suites / sizeof *suites };

const char *bench_suite_name(int index) { return index >= 0 && index < SUITE_COUNT ? suites[index].name : NULL; }

const struct bench_suite *bench_suite_find(const char *name) {
    for (int i = 0; i < SUITE_COUNT; i++)
        if (strcmp(suites[i].name, name) == 0) return &suites[i];
    return NULL;
}

enum bench_suite_kind bench_suite_kind_of(const struct bench_suite *suite) { return suite->kind; }
bool bench_suite_takes_all(const struct bench_suite *suite) { return suite->takes_all; }
const char *bench_suite_camera_path(const struct bench_suite *suite) { return suite->camera_path; }
const char *const *bench_suite_scenes(const struct bench_suite *suite) { return suite->scenes; }
const char *const *bench_suite_option(const struct bench_suite *suite, int index) {
    return suite->options[index][0] ? suite->options[index] : NULL;
}

enum bench_end bench_suite_measure(const struct bench_suite *suite, const struct bench_settings *settings, uint32_t width,
                                   uint32_t height, struct bench_data *data) {
    bool good = !suite->measure || suite->measure(settings, width, height, data);
    return interrupt_seen() ? BENCH_INTERRUPTED : good ? BENCH_DONE : BENCH_FAILED;
}

/* ---- plan ---- */

/* Of the second setup with `b`. */
static struct bench_case case_of(const struct bench_suite *suite, const struct row *row, bool b, uint32_t width, uint32_t height) {
    const uint32_t msaa = b ? row->msaa_b : row->msaa_a;
    return (struct bench_case){.scene = b && row->scene_b ? row->scene_b : row->scene,
                               .lights = b ? row->lights_b : row->lights_a,
                               .width = width ? width : suite->width,
                               .height = height ? height : suite->height,
                               .msaa = msaa ? msaa : 1};
}

/* At another size than the source's clusters shrink along, so that their grid stays; within what the lists take. */
static struct bench_candidate candidate_of(const struct bench_suite *suite, const struct setup *setup, uint32_t width,
                                           char options[128]) {
    unsigned size;
    int used = 0;
    snprintf(options, 128, "%s", setup->options);
    if (width && sscanf(setup->options, "clusters.size=%u%n", &size, &used) == 1) {
        unsigned scaled = (unsigned)((uint64_t)size * width / suite->width);
        scaled = scaled < 8 ? 8 : scaled > 256 ? 256 : scaled;
        snprintf(options, 128, "clusters.size=%u%s", scaled, setup->options + used);
    }
    return (struct bench_candidate){setup->shading, setup->lists, options};
}

bool bench_suite_plan(const struct bench_suite *suite, uint32_t width, uint32_t height, struct bench_plan *plan) {
    for (uint32_t i = 0; i < suite->row_count; i++) {
        const struct row *row = &suite->rows[i];
        const struct setup *setups[2] = {&row->a, &row->b};
        for (int side = 0; side < 2; side++) {
            struct bench_case wanted = case_of(suite, row, side, width, height);
            struct bench_case *to = bench_plan_case(plan, &wanted);
            char options[128];
            struct bench_candidate candidate = candidate_of(suite, setups[side], width, options);
            if (!to || !bench_plan_candidate(plan, to, &candidate)) return false;
        }
    }
    return true;
}

/* ---- what came of it ---- */

/* A number, and by how much it may be off: times by their MAD, counts by nothing. */
struct quantity {
    double value, spread;
};

static struct quantity time_of(const json_t *times) {
    return (struct quantity){bench_number(times, "median", NAN), bench_number(times, "mad", 0)};
}

static struct quantity passes_named(const json_t *result, const char *word) {
    const json_t *pass;
    size_t i;
    struct quantity sum = {0, 0};
    bool any = false;
    json_array_foreach(json_object_get(result, "passes"), i, pass) {
        const char *name = json_string_value(json_object_get(pass, "name"));
        const char *role = json_string_value(json_object_get(pass, "role"));
        if (!name || !role || strcmp(role, "lists") != 0 || !strstr(name, word)) continue;
        struct quantity one = time_of(pass);
        sum.value += one.value;
        sum.spread += one.spread;
        any = true;
    }
    return any ? sum : (struct quantity){NAN, 0};
}

static struct quantity quantity_of(const json_t *result, const char *metric) {
    if (strcmp(metric, "fill") == 0 || strcmp(metric, "shell") == 0) return passes_named(result, metric);
    if (strcmp(metric, "gpu_ms p95/median") == 0) {
        const json_t *times = json_object_get(result, "gpu_ms");
        const double median = bench_number(times, "median", NAN);
        return (struct quantity){bench_number(times, "p95", NAN) / median, bench_number(times, "mad", 0) / median};
    }
    if (strcmp(metric, "lists_ms+shading_ms") == 0) {
        struct quantity lists = time_of(json_object_get(result, "lists_ms")), shading = time_of(json_object_get(result, "shading_ms"));
        return (struct quantity){lists.value + shading.value, lists.spread + shading.spread};
    }
    if (json_is_object(json_object_get(result, metric))) return time_of(json_object_get(result, metric));
    return (struct quantity){bench_number(result, metric, NAN), 0};
}

const char *bench_verdict(double ours, double spread, double limit, bool at_least) {
    if (fabs(ours - limit) < spread) return "undecided";
    return (at_least ? ours >= limit : ours <= limit) ? "reached" : "missed";
}

static json_t *conclude_row(const struct bench_suite *suite, const struct row *row, uint32_t width, uint32_t height,
                            const struct bench_data *data) {
    struct bench_case at = case_of(suite, row, false, width, height), bt = case_of(suite, row, true, width, height);
    char a_options[128], b_options[128];
    struct bench_candidate ac = candidate_of(suite, &row->a, width, a_options),
                           bc = candidate_of(suite, &row->b, width, b_options);
    const json_t *a = bench_find(data, &at, &ac), *b = bench_find(data, &bt, &bc);
    struct quantity over = quantity_of(a, row->metric), under = quantity_of(b, row->metric);
    double ours = a && b ? over.value / under.value : NAN,
           spread = ours * (over.spread / fmax(over.value, 1e-12) + under.spread / fmax(under.value, 1e-12));
    bool known = isfinite(ours),
         wrong = json_is_false(json_object_get(a, "equal")) || json_is_false(json_object_get(b, "equal"));
    const char *verdict = !known               ? "not measured"
                          : wrong              ? "wrong picture"
                          : isnan(row->source) ? "no number in the source"
                                               : bench_verdict(ours, spread, row->limit, row->at_least);
    json_t *json = json_pack("{s:s,s:s,s:s,s:s}", "quantity", row->quantity, "scene", row->scene, "comparison",
                             row->at_least ? ">=" : "<=", "verdict", verdict);
    json_object_set_new(json, "source", isnan(row->source) ? json_null() : json_real(row->source));
    json_object_set_new(json, "limit", isnan(row->source) ? json_null() : json_real(row->limit));
    json_object_set_new(json, "ours", known ? json_real(ours) : json_null());
    json_object_set_new(json, "spread", known ? json_real(spread) : json_null());
    return json;
}

/* "7 of 9 ratios reached, 1 missed, 1 undecided: within the spread." Ratios without a number in the source are not among them. */
static json_t *headline(const json_t *rows) {
    static const struct {
        const char *verdict, *text;
    } others[] = {{"missed", "missed"},
                  {"undecided", "undecided: within the spread"},
                  {"wrong picture", "of wrong pictures"},
                  {"not measured", "not measured"}};
    enum { OTHERS = sizeof others / sizeof *others };
    uint32_t total = 0, reached = 0, counts[OTHERS] = {0};
    const json_t *row;
    size_t i;
    json_array_foreach(rows, i, row) {
        const char *verdict = json_string_value(json_object_get(row, "verdict"));
        if (json_is_null(json_object_get(row, "source"))) continue;
        total++;
        reached += strcmp(verdict, "reached") == 0;
        for (int k = 0; k < OTHERS; k++) counts[k] += strcmp(verdict, others[k].verdict) == 0;
    }
    char text[256];
    size_t used = (size_t)snprintf(text, sizeof text, "%u of %u ratio%s reached", reached, total, total == 1 ? "" : "s");
    for (int k = 0; k < OTHERS; k++)
        if (counts[k]) used += (size_t)snprintf(text + used, sizeof text - used, ", %u %s", counts[k], others[k].text);
    snprintf(text + used, sizeof text - used, ".");
    return json_text(text);
}

void bench_suite_conclude(const struct bench_suite *suite, uint32_t width, uint32_t height, struct bench_data *data) {
    if (suite->tabulate) {
        json_t *tables = json_array();
        suite->tabulate(data, tables);
        json_object_set_new(data->root, "tables", tables);
    }
    if (suite->row_count == 0) return;
    json_t *rows = json_array();
    for (uint32_t i = 0; i < suite->row_count; i++)
        if (suite->rows[i].quantity) json_array_append_new(rows, conclude_row(suite, &suite->rows[i], width, height, data));
    json_t *suite_json = json_pack("{s:s,s:s,s:o,s:o}", "name", suite->name, "title", suite->title, "headline", headline(rows), "rows", rows);
    const char *type = json_string_value(json_object_get(json_object_get(data->root, "device"), "type"));
    if (type && strcmp(type, fnl_value_name(FNL_ENUM_DEVICE_TYPE, FNL_DEVICE_CPU)) == 0)
        json_object_set_new(suite_json, "warning",
                            json_string("This device is a CPU. The source measured a GPU, where memory and parallel work cost otherwise: "
                                        "a ratio that is missed or reached here may not be so there."));
    json_object_set_new(data->root, "suite", suite_json);
}
