/* SPDX-License-Identifier: MIT */
/**
 * What the last frames did and when: kept to be looked at (fanal view), and written as a trace in Chrome's trace event format, which Perfetto
 * (ui.perfetto.dev) and chrome://tracing show. Nothing to do with `fanal trace`, which traces rays.
 *
 * The GPU has a clock of its own. Its passes stand where they can have begun at the earliest: when the frame began to be submitted.
 */
#ifndef FNL_CLI_TRACE_FILE_H
#define FNL_CLI_TRACE_FILE_H

#include "fanal/fanal.h"

enum { TRACE_FRAMES = 240, TRACE_SPANS = 1120, TRACE_NAMES = 1024 };

/** Within one of these no span overlaps another. */
enum trace_lane {
    TRACE_GRAPHICS, /**< passes of the graphics queue */
    TRACE_COMPUTE,  /**< of the compute queue */
    TRACE_LIBRARY,  /**< what the call that rendered the frame did: fnl_frame_stats.cpu_sections */
    TRACE_PROGRAM,  /**< what the program did: trace_mark */
    TRACE_LANE_COUNT
};

struct trace_span {
    double begin, milliseconds; /**< begin: since the frame began; passes: since the first of them did */
    uint16_t name;              /**< of trace_name */
    uint8_t lane;
    uint8_t role;               /**< fnl_pass_role; of passes */
};

struct trace_frame {
    uint64_t number;       /**< from 0 on */
    double begin, end;     /**< seconds of trace_now */
    double passes_begin;   /**< where the GPU's passes stand, milliseconds since the frame began */
    double gpu_milliseconds, cpu_milliseconds;
    uint64_t device_bytes, list_entries, evaluations;
    uint32_t lights_in_view;
    bool evaluations_counted;
    uint32_t span_count;
    struct trace_span spans[TRACE_SPANS]; /**< by lanes, in order */
};

/** All functions take NULL, for a history that nobody wants. */
struct trace_history;

/** NULL when memory ran out. It does not grow: names aside it takes TRACE_FRAMES frames, of which those in use cost memory. */
struct trace_history *trace_create(void);
void trace_destroy(struct trace_history **history);

double trace_now(void); /**< seconds */
/** What the program does from now on, until the next call; `name` NULL: nothing that is to be told. `name` must live until the frame ends. */
void trace_mark(struct trace_history *history, const char *name);
/** The frame is over, and was rendered by a call that began at `called`. `stats` NULL: it does not count, and what was marked is forgotten. */
void trace_end_frame(struct trace_history *history, const fnl_frame_stats *stats, double called);

/** Frames at hand. */
uint32_t trace_count(const struct trace_history *history);
/** The frame that is so old: 0 is the last one; NULL where there is none. */
const struct trace_frame *trace_find(const struct trace_history *history, uint32_t age);
const char *trace_name(const struct trace_history *history, uint32_t name);
/** Rises when names, and all frames with them, were forgotten because there were too many. */
uint32_t trace_generation(const struct trace_history *history);

/** Writes all frames at hand; false with a message. */
bool trace_save(const struct trace_history *history, const char *path);

#endif
