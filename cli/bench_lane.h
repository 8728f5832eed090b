/* SPDX-License-Identifier: MIT */
/** A candidate while it is measured: its renderer, the times of its frames, its counts. */
#ifndef FNL_CLI_BENCH_LANE_H
#define FNL_CLI_BENCH_LANE_H

#include "bench.h"

/** What is timed in each frame, milliseconds. */
enum lane_metric {
    LANE_FRAME,    /* the longer of GPU and CPU: they work side by side, so this bounds the frame rate */
    LANE_GPU,      /* all passes but those that hand results to the CPU */
    LANE_CPU,      /* recording and submitting, lists that the CPU builds included */
    LANE_WALL,     /* from the call until the results are there */
    LANE_LISTS,    /* passes that build light lists */
    LANE_SHADING,  /* passes that shade */
    LANE_SHADOWS,  /* passes that make shadow maps, or what rays go through */
    LANE_GEOMETRY, /* culling, sorting, depth, G-buffer */
    LANE_REST,     /* exposure, tone mapping */
    LANE_WITHOUT_LISTS, /* all passes but those that build light lists and those that hand over results */
    LANE_METRIC_COUNT
};

struct lane_pass {
    char *name;
    fnl_pass_role role;
    double *times; /* of the frames of the lane; 0 where the pass did not run */
};

struct lane {
    const struct bench_candidate *candidate;
    fnl_renderer *renderer, *own; /* `own` is the lane's to destroy */
    fnl_frame frame;
    uint32_t capacity, measured; /* frames */
    double wall, *times[LANE_METRIC_COUNT];
    struct lane_pass *passes;
    uint32_t pass_count;
    /* From frames that count evaluations; sums over the points of the path that were looked at. */
    uint32_t counted, max_per_pixel;
    double evaluations, useful;
    uint64_t image_bytes_read, image_bytes_written; /* of the last timed frame */
    fnl_frame_stats stats;                          /* of the last counted frame, without passes and counters */
    json_t *counters;                               /* its numbers by their keys; NULL: none yet */
    /* The comparison with the reference. */
    uint32_t checked;
    uint64_t differing;
    double max_difference;
    char unchecked[256];               /* why it was not compared */
    bool failed, unsupported, visited; /* visited: compared at this point of the path */
    bool kept;                         /* an earlier run compared it: its counts and comparison stand */
    bool told;                         /* that it failed */
    char reason[512];
};

double lane_now(void); /* seconds */
bool lane_init(struct lane *lane, const struct bench_case *where, const struct bench_candidate *candidate, uint32_t frames);
void lane_finish(struct lane *lane);
/** Keeps a timed frame; false when memory ran out. */
bool lane_note_times(struct lane *lane, const fnl_frame_stats *stats);
void lane_note_counts(struct lane *lane, const fnl_frame_stats *stats);
/** Takes up what an earlier run timed, where `result` (or NULL) holds frames of it; its comparison stands if it was at `checks` points, or could not be. */
void lane_restore(struct lane *lane, const json_t *result, uint32_t checks);
/** Adds all numbers to `result`, which holds the key already; while frames are missing, what lane_restore takes. */
void lane_add_result(const struct lane *lane, json_t *result, const fnl_scene_info *scene, bool shared,
                     uint32_t wanted_frames);
/** The name of a picture in bench_data.pictures: "scene|lights|640x360|1|deferred|tiled||kind". */
void lane_picture_name(const json_t *key, const char *kind, char *text, size_t capacity);

#endif
