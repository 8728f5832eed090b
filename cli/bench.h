/* SPDX-License-Identifier: MIT */
/** The parts of `fanal bench`: what to measure (bench.c, bench_suite.c), measuring (bench_run.c), and what comes of it. */
#ifndef FNL_CLI_BENCH_H
#define FNL_CLI_BENCH_H

#include "interrupt.h"

#include "fanal/fanal.h"

#include <jansson.h>

/** One way to render: what is compared. */
struct bench_candidate {
    fnl_shading shading;
    fnl_light_lists lists;
    char *options; /* "clusters.slices=64,gbuffer.layout=siege": those that are not the defaults, in the order of the library; "" for none */
};

/** One picture to render in several ways: what is kept equal while candidates are compared. */
struct bench_case {
    const char *scene, *camera; /* camera NULL: the scene's first, else one that frames the scene */
    int64_t lights;             /* -1: as the scene has them */
    uint32_t width, height, msaa, candidate_count;
    struct bench_candidate *candidates;
};

struct bench_plan {
    struct bench_case *cases;
    uint32_t case_count;
    bool likely;     /* orders or lists are only the likely ones */
    json_t *skipped; /* array of objects: pairs that cannot be measured, with the reason */
};

struct bench_settings {
    uint32_t frames, warm_up; /* timed frames; frames before them */
    bool more;                /* up to BENCH_FRAMES_FACTOR times as many frames where times are not to be trusted */
    uint32_t checks;          /* points of the camera's path that are compared with the reference; 0: none */
    fnl_light_lists reference;
    bool stereo;             /* two eyes in place of the camera */
    const char *hmd;         /* their headset; NULL: the camera's field of view */
    const char *camera_path; /* NULL: the camera stands still; "orbit", "turntable", each with ":N" or not; or a file */
    const char *device, *output, *variant, *environment; /* the last two: NULL where not given */
    char command[2048];                                  /* as it was typed, quoted for a shell */
    bool resume, overwrite, validate, no_cache, quiet;
    bool all; /* a suite measures what takes long as well */
    fnl_load_params loading;
};

/** What was measured: `root` is results.json; `pictures` maps keys to data URIs and is only in the page. */
struct bench_data {
    json_t *root, *pictures;
};

/** REFUSED: nothing was measured and nothing is to be written; FAILED: the device or memory gave up on the way. */
enum bench_end { BENCH_DONE, BENCH_INTERRUPTED, BENCH_FAILED, BENCH_REFUSED };

/* What a suite measures by itself, and what it makes of results. */
typedef bool bench_suite_measurer(const struct bench_settings *settings, uint32_t width, uint32_t height,
                                  struct bench_data *data);
typedef void bench_suite_tabulator(const struct bench_data *data, json_t *tables);

/* ---- plan (bench_plan.c) ---- */

/** The case for these values, added when it is not there yet; NULL when memory ran out. */
struct bench_case *bench_plan_case(struct bench_plan *plan, const struct bench_case *wanted);
/** Adds a candidate unless it is there already. A pair that does not fit goes to `skipped`. False when memory ran out. */
bool bench_plan_candidate(struct bench_plan *plan, struct bench_case *to, const struct bench_candidate *candidate);

void bench_plan_free(struct bench_plan *plan);

/* ---- the matrix of the command (bench_plan.c) ---- */

enum { BENCH_VALUES_MAX = 64, BENCH_VARY_MAX = 16 };

/** An option of the frame, and the values that it takes in turn. */
struct bench_vary {
    fnl_option option;
    uint32_t count;
    char values[BENCH_VALUES_MAX][32];
};

/** What the options name. Orders and lists that are not named and not every_…: the likely ones. */
struct bench_matrix {
    const char *camera;
    char set[512]; /* options of every candidate: "key=value,key=value" */
    bool every_shading, every_lists;
    bool ideal; /* each path is measured with perfect lists too */
    bool usual_shadows; /* each case is measured without shadows and, where there are lights, with maps, as `fanal render` draws it */
    uint32_t vary_count;
    struct bench_vary varied[BENCH_VARY_MAX];
    uint32_t shading_count, lists_count, light_count, size_count, msaa_count;
    uint32_t shading[BENCH_VALUES_MAX], lists[BENCH_VALUES_MAX], lights[BENCH_VALUES_MAX], sizes[BENCH_VALUES_MAX][2], msaa[BENCH_VALUES_MAX];
};

/** Adds the cases of the matrix, which names a size and samples; scene_lights as bench_scene_check gives them. False when memory ran out. */
bool bench_plan_matrix(const struct bench_matrix *matrix, const char *const *scenes, const uint32_t *scene_lights, int scene_count,
                       struct bench_plan *plan);

/* ---- ways (bench_ways.c): options besides shading and lists ---- */

/** What candidates begin with: fixed here, so that results stay comparable when the defaults of frames change. */
fnl_frame bench_frame(void);
/** Finds an option that candidates may set. False with a message that begins with --`option`. */
bool bench_ways_find(const char *option, const char *key, fnl_option *out);
/** Lets an option take values in turn: "a,b,c" or "all". False with a message. */
bool bench_vary_add(struct bench_matrix *matrix, const char *option, const char *key, const char *values);
/** Whether a value makes a difference with this path, these lists and samples; where it does not, the default stands for it. */
bool bench_way_heeded(const fnl_option *option, const char *value, fnl_shading shading, fnl_light_lists lists, uint32_t msaa);
/** Writes the options of a frame that are not the defaults; those that leave the picture as it is only with `exact`. */
void bench_ways_print(const fnl_frame *frame, bool exact, char *text, size_t capacity);
/** Sets "key=value,key=value" in a frame. False with a message. */
bool bench_ways_apply(const char *option, const char *text, fnl_frame *frame);
/** Of candidate options those that change the picture: what is equal here and in shading is compared with one reference picture. */
void bench_ways_of(const char *options, char *text, size_t capacity);
/** The options but for those that only change light lists. */
void bench_ways_without_lists(const char *options, char *text, size_t capacity);
/** Gives a frame the defaults of those. */
void bench_ways_reset_lists(fnl_frame *frame);
/** Adds "ways", as bench_ways_of gives them, and "settings", an object of all options that are not the defaults. */
void bench_ways_describe(const struct bench_candidate *candidate, json_t *result);

/* ---- cameras (bench_camera.c) ---- */

struct bench_point {
    double time; /* seconds; poses the scene's animation */
    double eye[3], target[3]; /* places (origin.h) */
    fnl_camera camera;        /* all except position and target */
};

/** Points of a path through a scene. */
struct bench_path {
    struct bench_point *points;
    uint32_t count;
};

/** Whether `source` is "orbit" or "turntable", alone or with ":N"; then `count` becomes N, or stays as it is. */
bool bench_path_is_circle(const char *source, uint32_t *count);
/** Loads a file of points, or makes a circle of `orbit_count` or N points; `base` gives what a point does not say. False with a message. */
bool bench_path_create(struct bench_path *path, const char *source, const fnl_scene *scene, const fnl_camera *base,
                       uint32_t orbit_count, float aspect);
/** Camera of a picture; `index` wraps around. The scene's origin moves with it (origin.h). False with a message. */
bool bench_path_camera(const struct bench_path *path, fnl_scene *scene, uint32_t index, fnl_camera *out);
void bench_path_destroy(struct bench_path *path);

/* ---- scenes (bench_scene.c) ---- */

/** The scene with the lights that a case asks for (-1: as it is). False with a message of the log. */
bool bench_scene_load(const fnl_host *host, const struct bench_settings *settings, const char *name, int64_t lights, fnl_scene **out);
/** The settings' path through it, or a camera that stands still; `camera` may be NULL. False with a message. */
bool bench_scene_path(const fnl_scene *scene, const struct bench_settings *settings, const char *camera, float aspect, struct bench_path *out);
/** Whether a scene, the camera and the path can be had at all, before anything is measured; its own lights, directional ones left out. */
bool bench_scene_check(const struct bench_settings *settings, const char *name, const char *camera, uint32_t *lights);
/** Lights of a scene that has `own` when a case asks for so many. */
uint32_t bench_scene_lights(const char *name, uint32_t own, int64_t asked);

/* ---- measuring (bench_run.c) ---- */

/**
 * Measures what `data` does not hold yet. Saves data after each way that was compared and timed for the first time, and after each round of frames:
 * what ends it leaves all that was measured.
 */
enum bench_end bench_measure(const struct bench_settings *settings, const struct bench_plan *plan, struct bench_data *data);

/** The device that the settings name; `host` may be NULL. */
bool bench_create_device(const struct bench_settings *settings, const fnl_host *host, fnl_device **out);

/* ---- antialiasing (bench_aa.c) ---- */

/** Measures antialiasing into root.antialiasing; width 0: 640 x 360. False with a message. */
bool bench_aa_measure(const struct bench_settings *settings, uint32_t width, uint32_t height, struct bench_data *data);
void bench_aa_print(const struct bench_data *data);

/** For such comparisons: one exposure for all, metered by a frame; ways must not differ by what a meter makes of them. Clustered lists, deferred. */
bool bench_metered_frame(fnl_renderer *renderer, const fnl_scene *scene, uint32_t width, uint32_t height, fnl_frame *out);
/** Sorts them. */
double bench_median_of(double *values, uint32_t count);

/* ---- coarse shading (bench_coarse.c) ---- */

/** Measures it into root.coarse; width 0: 1920 x 1080. False with a message. */
bool bench_coarse_measure(const struct bench_settings *settings, uint32_t width, uint32_t height, struct bench_data *data);
void bench_coarse_print(const struct bench_data *data);

/* ---- tables of suites (bench_tables.c) ---- */

/**
 * root.tables is an array of {name, title, columns, rows, lines}: a column whose name begins with '<' holds text; a cell is text, a number or null;
 * lines are sentences.
 */
bench_suite_tabulator bench_table_geometry, bench_table_orders;
void bench_tables_print(const struct bench_data *data);

/* ---- stereo (bench_stereo.c) ---- */

/** Measures it into root.stereo; width 0: 1440 x 1600, on a CPU 320 x 180. False with a message, or when it was interrupted. */
bool bench_stereo_measure(const struct bench_settings *settings, uint32_t width, uint32_t height, struct bench_data *data);
bench_suite_tabulator bench_table_stereo;

/* ---- the four pipelines of a textbook (bench_rtr20.c) ---- */

#define BENCH_RTR20_FORWARD {FNL_SHADING_FORWARD, FNL_LISTS_MESH, ""}
#define BENCH_RTR20_VOLUMES {FNL_SHADING_DEFERRED_VOLUMES, FNL_LISTS_ALL, ""}
#define BENCH_RTR20_DEFERRED {FNL_SHADING_DEFERRED, FNL_LISTS_CLUSTERED, ""}
#define BENCH_RTR20_PREPASS {FNL_SHADING_FORWARD_PREPASS, FNL_LISTS_CLUSTERED, ""}
#define BENCH_RTR20_SMALL "builtin:city?triangles=3000000"
#define BENCH_RTR20_DECALS "builtin:city?decals=2000"
bench_suite_tabulator bench_table_rtr20;

/* ---- deferred attribute interpolation (bench_dais.c) ---- */

/** Measures it into root.dais; width 0: 3840 x 2160, on a CPU 640 x 360. False with a message, or when it was interrupted. */
bool bench_dais_measure(const struct bench_settings *settings, uint32_t width, uint32_t height, struct bench_data *data);
bench_suite_tabulator bench_table_dais;
/**
 * Samples to a triangle at which `ratio`, a key of rows, passes 1 for the last time as triangles get smaller, between two neighbours among
 * the rows of the series, size and sample count of `first`; NaN where it does not.
 */
double bench_dais_crossing(const json_t *rows, const json_t *first, const char *ratio);

/* ---- shadows (bench_shadows.c) ---- */

/**
 * Measures every kind of shadows with more and more lights into root.results and root.shadows; width 0: 1280 x 720, on a CPU 320 x 180. With
 * settings->all, 1024 and 4096 lights too. False with a message, or when it was interrupted.
 */
bool bench_shadows_measure(const struct bench_settings *settings, uint32_t width, uint32_t height, struct bench_data *data);
bench_suite_tabulator bench_table_shadows;

/* ---- how far times can be trusted (bench_trust.c) ---- */

enum { BENCH_FRAMES_FACTOR = 4 };

/**
 * Of samples: `low` to `high` is the interval in which the true median is with 95 % confidence, whatever their distribution. With fewer than six samples that
 * needs all of them and more: then it spans them all.
 */
struct bench_spread {
    double median, min, p5, p95, mad, low, high;
};
/** False when memory ran out or there are no samples. */
bool bench_spread_of(const double *times, uint32_t count, struct bench_spread *out);
/** Whether p95 is more than 1.5 times p5. */
bool bench_is_unsteady(const struct bench_spread *spread);
/** Whether other programs keep more than a tenth of the processors busy. */
bool bench_is_busy(double others, uint32_t processors);
/**
 * How many frames to time altogether: `asked`; on a busy machine, or where times are unsteady, as many more at a time until the median is known within
 * 3 % to either side, up to BENCH_FRAMES_FACTOR times as many.
 */
uint32_t bench_frames_wanted(const struct bench_spread *spread, uint32_t measured, uint32_t asked, bool busy);

/* ---- the machine (bench_machine.c) ---- */

/** {processor, cores, kernel, load_before}: the load average of the last minute, or null. */
json_t *bench_machine(void);
/** Seconds of processors: of all programs (NaN: not known), and of this one. */
struct bench_busy {
    double at, all, own;
};
struct bench_busy bench_busy_now(void);
/** How many processors other programs kept busy on average; 0 where it is not known. */
double bench_others(const struct bench_busy *from, const struct bench_busy *to);

/* ---- pictures (bench_picture.c) ---- */

/** A picture, made at most `width` pixels wide, as a data URI; NULL when it cannot be made. */
json_t *bench_picture_uri(const fnl_image *picture, uint32_t width);
/** How many pixels differ in any bit, and the greatest difference of a channel. */
void bench_picture_compare(const fnl_image *a, const fnl_image *b, uint64_t *differing, double *max);

/* ---- results (bench_write.c) ---- */

/** The result of a candidate in a case, or NULL. */
json_t *bench_find(const struct bench_data *data, const struct bench_case *where, const struct bench_candidate *what);
/** An object with the keys that say which case and candidate a result is of; `what` may be NULL. */
json_t *bench_key(const struct bench_case *where, const struct bench_candidate *what);
/** Are two results of one case, that is, comparable? */
bool bench_same_case(const json_t *a, const json_t *b);
/** "deferred with tiled lists (tiles.size=8)", "forward with brute force", of a result or a candidate. */
void bench_describe(const json_t *result, char *text, size_t capacity);
void bench_describe_candidate(const struct bench_candidate *candidate, char *text, size_t capacity);
/** "hall.glb with 1024 lights at 1280x720, MSAA 4", of one of the results. */
void bench_describe_case(const json_t *results, const json_t *result, char *text, size_t capacity);
/** What a scene is called: its file's name without folders, but for as many as tell it from scenes of other results with the same name. */
void bench_scene_name(const json_t *results, const char *scene, char *text, size_t capacity);
double bench_number(const json_t *object, const char *key, double otherwise);
/** The median of one of a result's times, such as "frame_ms"; NaN when there is none. */
double bench_median(const json_t *result, const char *key);

/** False with a message when the folder of the settings holds results that nobody said to replace or to go on with. */
bool bench_check_folder(const struct bench_settings *settings);
/** Checks that a folder can be written to, making it if it is not there (`*made`). False with a message. */
bool bench_prepare_folder(const char *folder, bool *made);
/**
 * Reads DIR/results.json, and the pictures out of DIR/report.html. A missing file leaves `data` empty; false with a message if it cannot be read or
 * is broken.
 */
bool bench_load(const char *folder, struct bench_data *data);
/** Writes results.json, results.csv, and with `page` report.html; each is complete or not there. False with a message. */
bool bench_save(const char *folder, const struct bench_data *data, bool page);
/** Removes the page of results that are being replaced, whose pictures are not of the new ones. */
void bench_drop_page(const char *folder);
/** Writes `size` bytes as DIR/name under a temporary name, then renames it. */
bool bench_save_file(const char *folder, const char *name, const char *text, size_t size);
/** Pictures whose keys begin with what scenes are called on the page instead of their sources, or `back` to these. */
json_t *bench_pictures_renamed(const json_t *results, const json_t *pictures, bool back);
/** The page as text of *size bytes; free() it. NULL when memory ran out. */
char *bench_page_create(const struct bench_data *data, size_t *size);

/* ---- the ideal frame (bench_ideal.c) ---- */

/**
 * Gives each result `ideal_ms`, milliseconds: the least median that any result with the same frame, but maybe other lists, has without building its
 * lists; and `over_ideal`, the ratio of its own frame to that. Neither, unless one of those results has lists that name hardly a light too many.
 */
void bench_add_ideals(struct bench_data *data);
/** Whether two results differ in nothing but their lists. */
bool bench_same_frame(const json_t *a, const json_t *b);

/* ---- what follows from them (bench_conclude.c) ---- */

/** Replaces root.conclusions: for each case the fastest candidate and its lead; then pictures that differ. And root.warnings: why not to trust times. */
void bench_conclude(struct bench_data *data);
/** Whether one of two results is ahead: the intervals of their medians (bench_spread) do not overlap. */
bool bench_clear(const json_t *fast, const json_t *slow);
/** Prints tables of all results. */
void bench_print(const struct bench_data *data);
/** Number of results whose picture is not the reference's. */
uint32_t bench_unequal_count(const struct bench_data *data);
/** Number of candidates that failed while they were measured, for instance because memory ran out. */
uint32_t bench_failed_count(const struct bench_data *data);

/* ---- experiments of the literature (bench_suite.c) ---- */

struct bench_suite;
/** By name; NULL when there is none. bench_suite_name(0), (1) … until NULL gives the names. */
const struct bench_suite *bench_suite_find(const char *name);
const char *bench_suite_name(int index);
/** RATIOS: of two ways each, beside those of the source; OWN: measures by itself; MATRIX: options of the command that are given already, and tables. */
enum bench_suite_kind { BENCH_SUITE_RATIOS, BENCH_SUITE_OWN, BENCH_SUITE_MATRIX };
enum bench_suite_kind bench_suite_kind_of(const struct bench_suite *suite);
/** Whether --all means something to a suite that measures by itself. */
bool bench_suite_takes_all(const struct bench_suite *suite);
/** A suite of ratios: the camera's path; NULL: it stands still. */
const char *bench_suite_camera_path(const struct bench_suite *suite);
/** Of a matrix: its scenes, and its options by name and value, which others may replace; NULL beyond the last. */
const char *const *bench_suite_scenes(const struct bench_suite *suite);
const char *const *bench_suite_option(const struct bench_suite *suite, int index);
/** What a suite measures besides the plan; with a message when it fails. */
enum bench_end bench_suite_measure(const struct bench_suite *suite, const struct bench_settings *settings, uint32_t width,
                         uint32_t height, struct bench_data *data);
/** Adds the cases of a suite of ratios; width 0: the size of the source. False when memory ran out. */
bool bench_suite_plan(const struct bench_suite *suite, uint32_t width, uint32_t height, struct bench_plan *plan);
/**
 * "reached" or "missed" of a ratio that should be at most, or at least, `limit`; "undecided" where it is nearer to it than the spread: the sum of the
 * relative MADs of both its sides, times the ratio.
 */
const char *bench_verdict(double ours, double spread, double limit, bool at_least);
/** Sets root.suite to the ratios that were found, or root.tables. */
void bench_suite_conclude(const struct bench_suite *suite, uint32_t width, uint32_t height, struct bench_data *data);

#endif
