/* SPDX-License-Identifier: MIT */
/**
 * The steps of a frame, one row each, at the end of the step's file. A frame calls each hook of all rows, in their order,
 * before it calls the next hook. Each shading path has its own row (orders/order.h), called by the step `shading`, and each
 * shadow method (shadows/method.h), called by the step `shadows`.
 */
#ifndef FNL_RENDER_STEP_H
#define FNL_RENDER_STEP_H

#include "base/check.h"
#include "fanal/renderer.h"
#include "render/counters.h"

struct frame_state;

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
    /*
     * Hooks that declare the work of a frame, in this order. They change nothing that the renderer keeps, so a frame can be declared only for its pipelines:
     * what later frames need goes into `f->made`, and `submitted` takes it over. A view of what is far away (frame_state.group.eyes) begins and is lit like any
     * other view. It has no exposure and is not finished, because its eyes show it.
     */
    /** Once, before any view: what all views share. `shared` is what each of them starts from. */
    fnl_result (*begin_frame)(struct frame_state *shared);
    /** Each view, before anything is drawn for it. Its camera is known; hooks may add to `f->view`. */
    fnl_result (*begin_view)(struct frame_state *f);
    /** Between drawing and lighting: what `count` views share. The views are the eyes of a display and the view of what is far away, or one view. */
    void (*begin_light)(struct frame_state *views, uint32_t count);
    /** Each view: fills f->radiance, or reads what is drawn. */
    void (*light_view)(struct frame_state *f);
    /** After lighting: what `count` views share. */
    void (*end_light)(struct frame_state *views, uint32_t count);
    /** Each view: from radiance to pictures and numbers. */
    void (*finish_view)(struct frame_state *f);
    /** After submission: takes over what this frame made of each view (fnl_renderer.last), so that later frames may rely on it. */
    void (*submitted)(fnl_renderer *r, const fnl_frame *frame);
    /** After a failed frame: drops state the device may not have. */
    void (*forget)(fnl_renderer *r);
    /** Grows pools by the counts of an earlier view. */
    void (*grow)(fnl_renderer *r, const struct frame_counts *counts);
    /** Frees the step's state. Nothing is in flight. */
    void (*destroy)(fnl_renderer *r);
    const struct counter_table *counters;
};

/** In the order of a frame. */
#define FRAME_STEPS(ROW)                                                                                                                                        \
    ROW(decals) ROW(reflections) ROW(lists) ROW(culling) ROW(stereo) ROW(mono) ROW(shadows) ROW(shading) ROW(surfaces) ROW(exposure) ROW(temporal) \
    ROW(debug_views) ROW(overlay) ROW(picture) ROW(inspect) ROW(outputs)
#define DECLARE_FRAME_STEP(name) extern const struct frame_step step_##name;
FRAME_STEPS(DECLARE_FRAME_STEP)
#define COUNT_FRAME_STEP(name) +1
enum { FRAME_STEP_COUNT = 0 FRAME_STEPS(COUNT_FRAME_STEP) };

/** The row at a place, in the order of a frame. */
const struct frame_step *frame_step_at(uint32_t index);

/* Each calls all rows in frame order; forget and destroy in reverse. */

void steps_init(fnl_renderer *r);
fnl_result steps_check(const struct call *call, fnl_renderer *r, const fnl_frame *frame);
fnl_result steps_prepare(fnl_renderer *r, const fnl_frame *frame);
void steps_counted(fnl_renderer *r, uint32_t slot);
fnl_result steps_begin_frame(struct frame_state *shared);
fnl_result steps_begin_view(struct frame_state *f);
void steps_begin_light(struct frame_state *views, uint32_t count);
void steps_light_view(struct frame_state *f);
void steps_end_light(struct frame_state *views, uint32_t count);
void steps_finish_view(struct frame_state *f);
void steps_submitted(fnl_renderer *r, const fnl_frame *frame);
void steps_forget(fnl_renderer *r);
void steps_grow(fnl_renderer *r, const struct frame_counts *counts);
void steps_destroy(fnl_renderer *r);

#endif
