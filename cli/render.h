/* SPDX-License-Identifier: MIT */
/** What `fanal render` was asked for, and the parts that do it. */
#ifndef FNL_CLI_RENDER_H
#define FNL_CLI_RENDER_H

#include "headset_display.h"
#include "stereo.h"
#include "world.h"

enum { RENDER_MAX_OUTPUTS = 16, RENDER_MAX_GIVEN = 128 };
enum render_aov {
    RENDER_AOV_DEPTH,
    RENDER_AOV_NORMAL,
    RENDER_AOV_ALBEDO,
    RENDER_AOV_ROUGHNESS,
    RENDER_AOV_ID,
    RENDER_AOV_POSITION,
    RENDER_AOV_MOTION,
    RENDER_AOV_OBJECT,
    RENDER_AOV_COUNT
};

enum render_format { RENDER_PNG, RENDER_EXR, RENDER_RAW, RENDER_Y4M, RENDER_Y4M444 }; /* from RENDER_RAW on for stdout alone, and sequences */

struct render_options {
    struct world_options world;
    struct stereo_options stereo;
    struct display_options display;
    struct display *screen;    /* NULL, or while it runs with --hmd: its display */
    const struct stereo *eyes; /* NULL, or while it runs: those of --stereo */
    const char *outputs[RENDER_MAX_OUTPUTS], *views, *camera_path, *device, *stats, *trace_file, *save_scene;
    int output_count;
    const char *given[RENDER_MAX_GIVEN]; /* keys of the options of the frame that were set */
    int given_count;
    fnl_frame frame;
    bool validate, no_cache, quiet, verbose, traffic;
    enum render_plan { RENDER_NO_PLAN, RENDER_PLAN_TEXT, RENDER_PLAN_JSON } plan;
    double choose_seconds;      /* that auto may take before the frames */
    uint32_t frame_count;       /* timed ones; 0: the picture alone, as is usual */
    uint32_t aovs;              /* bits 1 << enum render_aov */
    bool has_frames, has_frame_time, has_format, has_size;
    bool has_exposure;         /* --exposure is given: auto then meters each picture of a sequence */
    bool lit_casts;            /* nobody said which shadows: maps, where the scene has lights */
    enum render_format format; /* of the output "-", which is stdout */
    uint32_t start_frame;      /* of a sequence: the first picture that is wanted */
    uint32_t supersample; /* frames whose mean is taken; 0 or 1: none */
    double frame_time;    /* seconds between the pictures of a sequence */
};

/** Whether a path ends in this extension (without dot), in any case. */
bool render_has_extension(const char *path, const char *extension);
/** "-". */
bool render_is_stdout(const char *path);
/** What an output is to hold. */
enum render_format render_format_of(const struct render_options *options, const char *path);
/** "png", "exr", "raw", "y4m", "y4m444"; NULL beyond. */
const char *render_format_name(int format);
/** By bit of render_options.aovs; NULL beyond. */
const char *render_aov_name(int aov);
/** Bits of render_options.aovs from "depth,normal"; false after a message. */
bool render_parse_aov(const char *text, uint32_t *aovs);
/** Whether a path stands for the pictures of a sequence, or of views: one %d, with or without a width, and no other %. */
bool render_is_sequence(const char *path);
/** The path of picture or view `index` of such a pattern. */
void render_number_path(const char *pattern, uint32_t index, char *out, size_t capacity);
/** Whether the run is one: by names of outputs, by a camera's path, or as only sequences go to stdout in this format. */
bool render_makes_sequence(const struct render_options *options);
/** Whether the user set an option of the frame. */
bool render_was_given(const struct render_options *options, const char *key);
/** Whether nothing is to be rendered. */
bool render_shows_nothing(const struct render_options *options);
/** Pictures of one view that were read back, by bit number of fnl_output. */
enum { RENDER_PICTURES = 7 };
struct render_pictures {
    fnl_image images[RENDER_PICTURES];
};
/** What has to be read back for these outputs and channels: bits of fnl_output. */
uint32_t render_wanted_outputs(const struct render_options *options);
/**
 * Those of them that need frames of their own, by a renderer of their own, because a picture and radiance are wanted together: linear frames have more
 * bits, which would show in the picture. The others are FNL_OUTPUT_COLOR then. 0: one frame gives all.
 */
uint32_t render_linear_outputs(const struct render_options *options);
/** A .png, or an .exr with its channels, of options.frame's size. */
bool render_save_picture(const struct render_options *options, const fnl_host *host, const char *path, const struct render_pictures *pictures);
/** Loads, renders, writes; returns the exit status. */
int render_run(const struct render_options *options);

/** "text", "json"; NULL beyond, and for no plan. */
const char *render_plan_name(int plan);

/** What took time in each frame: passes, or what the CPU did. */
struct report_series {
    uint32_t count;
    struct report_row {
        const char *name;
        fnl_queue queue; /* passes, as the next */
        fnl_pass_role role;
    } *rows;
    double *times, *begins; /* count * frame_count, milliseconds: those of one name in a row */
};

/** Times and counts over the frames of a run, or of one picture of a sequence. */
struct render_report {
    const struct render_options *options;
    fnl_device_info device;
    fnl_scene_info scene;
    fnl_frame frame;
    double time;           /* of the animation, seconds */
    uint32_t picture;      /* of a sequence; UINT32_MAX: none */
    uint32_t picture_count; /* that were written of a sequence */
    bool interrupted;       /* the sequence, before its end */
    fnl_frame_stats stats; /* of the last, counted frame; its passes are not used */
    const fnl_scene *shown;
    fnl_pixel_info pixel;          /* that was asked for, if one was */
    fnl_pixel_light pixel_lights[FNL_PIXEL_LIGHTS];
    uint32_t frame_count;
    struct report_series passes, sections;
    double *cpu_times, *gpu_times; /* frame_count */
};

struct report_summary {
    double median, low, p95;
};
struct report_summary report_summarise(const double *times, uint32_t count);

/** Keeps the times of frame `index` of report.frame_count, from 0 on; false when memory ran out. */
bool report_note(struct render_report *report, uint32_t index, const fnl_frame_stats *stats);
/** Frees the times. */
void report_finish(struct render_report *report);
void report_print(const struct render_report *report);
/** A line instead, where nothing but the picture was asked for, and what the colors of a debug view mean; `seconds` is what the command took. */
void report_print_picture(const struct render_report *report, double seconds);
/** A line about the `count` pictures of a sequence. */
void report_print_sequence(const struct render_report *report, uint32_t count, double seconds);
/** The numbers as JSON, by docs/stats.schema.json, on a line of its own or indented; NULL when memory ran out. To be freed. */
char *report_text(const struct render_report *report, bool line);

/* ---- parts of a run ---- */

struct supersample;
struct trace_history;
/**
 * Renders again until all pools (counters of kind FNL_COUNTER_OVERFLOW) hold what the frame needs: they learn by a frame how large they have
 * to be. What is saved is exact if memory lasts.
 */
bool render_settle_pools(fnl_renderer *renderer, const fnl_frame *frame, fnl_frame_stats *stats);
/** Of the last frame, what is not the picture from `linear`, if not NULL; `view_count` 0: it has one view, or two that are joined, and the paths of outputs are no patterns for the numbers of views. */
bool render_save_outputs(const struct render_options *options, const fnl_host *host, fnl_renderer *renderer, fnl_renderer *linear,
                         const struct supersample *mean, uint32_t view_count);
/** Says what was written: each output, whose pattern stands for the numbers `first` to `end` - 1 (end 0: it is none), and the other files. */
void render_print_wrote(const struct render_options *options, uint32_t first, uint32_t end);
bool render_sequence(const struct render_options *options, const fnl_host *host, fnl_scene *scene, fnl_renderer *renderer, fnl_renderer *linear,
                     const fnl_frame *frame, struct render_report *report, struct trace_history *trace);

#endif
