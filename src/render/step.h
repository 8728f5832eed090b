/* SPDX-License-Identifier: MIT */
/**
 * The steps of a frame, as all sees them that loops over features: a row each, which ends the step's file. frame.c says what they declare, and in which
 * order; shading orders are rows of their own (orders/order.h) behind the step `shading`.
 */
#ifndef FNL_RENDER_STEP_H
#define FNL_RENDER_STEP_H

#include "base/check.h"
#include "fanal/renderer.h"
#include "render/counters.h"

/** Members that a step does not need are NULL. */
struct frame_step {
    const char *name;
    /** When a renderer is made: what is not zero of what the step keeps. */
    void (*init)(fnl_renderer *r);
    /** Fails, with a log line, where options do not go together or the device cannot do what they ask for. Nothing is prepared yet. */
    fnl_result (*check)(const struct call *call, fnl_renderer *r, const fnl_frame *frame);
    /** Outside of the frame, whose options are settled: what lasts longer than it. */
    fnl_result (*prepare)(fnl_renderer *r, const fnl_frame *frame);
    /** The frame is on its way to the device: what it made can be relied on from now on. */
    void (*submitted)(fnl_renderer *r, const fnl_frame *frame);
    /** A frame failed: nothing is known of what the device has of it. */
    void (*forget)(fnl_renderer *r);
    /** Pools, by what a view of an earlier frame counted. */
    void (*grow)(fnl_renderer *r, const struct frame_counts *counts);
    /** Before the renderer goes: frees what the step keeps. Nothing is in flight. */
    void (*finish)(fnl_renderer *r);
    const struct counter *counters;
    uint32_t counter_count;
};

/** In the order of a frame. */
#define FRAME_STEPS(ROW)                                                                                                                                        \
    ROW(reflections) ROW(probes) ROW(decals) ROW(temporal) ROW(lists) ROW(culling) ROW(stereo) ROW(mono) ROW(shadows) ROW(shading) ROW(debug_views) ROW(inspect) \
        ROW(overlay)
#define DECLARE_FRAME_STEP(name) extern const struct frame_step step_##name;
FRAME_STEPS(DECLARE_FRAME_STEP)
#define COUNT_FRAME_STEP(name) +1
enum { FRAME_STEP_COUNT = 0 FRAME_STEPS(COUNT_FRAME_STEP) };

/** The row at a place, in the order of a frame. */
const struct frame_step *frame_step_at(uint32_t index);

/* Each calls all rows: forwards what is begun, backwards what is ended. */

void steps_init(fnl_renderer *r);
fnl_result steps_check(const struct call *call, fnl_renderer *r, const fnl_frame *frame);
fnl_result steps_prepare(fnl_renderer *r, const fnl_frame *frame);
void steps_submitted(fnl_renderer *r, const fnl_frame *frame);
void steps_forget(fnl_renderer *r);
void steps_grow(fnl_renderer *r, const struct frame_counts *counts);
void steps_finish(fnl_renderer *r);

#endif
