/* SPDX-License-Identifier: MIT */
/**
 * The steps of a frame, one row each, at the end of the step's file. frame.c declares their work in order. Each
 * shading path has its own row (orders/order.h), called by the step `shading`.
 */
#ifndef FNL_RENDER_STEP_H
#define FNL_RENDER_STEP_H

#include "base/check.h"
#include "fanal/renderer.h"
#include "render/counters.h"

/** Members that a step does not need are NULL. */
struct frame_step {
    const char *name;
    /** At creation: sets state that does not start at zero. */
    void (*init)(fnl_renderer *r);
    /** Fails with a log line if options conflict or the device lacks a feature. Nothing is prepared yet. */
    fnl_result (*check)(const struct call *call, fnl_renderer *r, const fnl_frame *frame);
    /** Prepares what outlives the frame. The frame's options are settled. */
    fnl_result (*prepare)(fnl_renderer *r, const fnl_frame *frame);
    /** Inside a frame, after `grow`: what the last frame of a slot counted is known (fnl_renderer.counts). */
    void (*counted)(fnl_renderer *r, uint32_t slot);
    /** After submission: later frames may rely on what this frame made. */
    void (*submitted)(fnl_renderer *r, const fnl_frame *frame);
    /** After a failed frame: drops state the device may not have. */
    void (*forget)(fnl_renderer *r);
    /** Grows pools by the counts of an earlier view. */
    void (*grow)(fnl_renderer *r, const struct frame_counts *counts);
    /** Frees the step's state. Nothing is in flight. */
    void (*finish)(fnl_renderer *r);
    const struct counter *counters;
    uint32_t counter_count;
};

/** In the order of a frame. */
#define FRAME_STEPS(ROW)                                                                                                                                        \
    ROW(reflections) ROW(decals) ROW(temporal) ROW(lists) ROW(culling) ROW(stereo) ROW(mono) ROW(shadows) ROW(shading) ROW(debug_views) ROW(inspect) \
        ROW(overlay)
#define DECLARE_FRAME_STEP(name) extern const struct frame_step step_##name;
FRAME_STEPS(DECLARE_FRAME_STEP)
#define COUNT_FRAME_STEP(name) +1
enum { FRAME_STEP_COUNT = 0 FRAME_STEPS(COUNT_FRAME_STEP) };

/** The row at a place, in the order of a frame. */
const struct frame_step *frame_step_at(uint32_t index);

/* Each calls all rows in frame order; forget and finish in reverse. */

void steps_init(fnl_renderer *r);
fnl_result steps_check(const struct call *call, fnl_renderer *r, const fnl_frame *frame);
fnl_result steps_prepare(fnl_renderer *r, const fnl_frame *frame);
void steps_counted(fnl_renderer *r, uint32_t slot);
void steps_submitted(fnl_renderer *r, const fnl_frame *frame);
void steps_forget(fnl_renderer *r);
void steps_grow(fnl_renderer *r, const struct frame_counts *counts);
void steps_finish(fnl_renderer *r);

#endif
