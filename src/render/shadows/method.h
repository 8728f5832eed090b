/* SPDX-License-Identifier: MIT */
/**
 * Each shadow method is a row at the end of the file that implements it, in this folder or another. Methods that share most of their code share a file.
 * SHADOW_METHODS lists the rows; shadows.c calls their hooks. Other files test traits, never a method itself.
 */
#ifndef FNL_RENDER_SHADOWS_METHOD_H
#define FNL_RENDER_SHADOWS_METHOD_H

#include "base/check.h"
#include "render/frame_state.h"
#include "render/traits.h"

struct shadow_method {
    uint32_t traits;         /* enum shadow_trait */
    fnl_shadows captured_as; /* what captures of reflection probes use in its place */
    /* All below is optional. As in struct frame_step, but `check` and `prepare` are for frames of this method alone. */
    void (*init)(fnl_renderer *r);
    fnl_result (*check)(const struct call *call, const fnl_renderer *r, const fnl_frame *frame);
    fnl_result (*prepare)(fnl_renderer *r, const fnl_frame *frame);
    void (*counted)(fnl_renderer *r, uint32_t slot);
    void (*submitted)(fnl_renderer *r, const fnl_frame *frame);
    void (*forget)(fnl_renderer *r);
    void (*grow)(fnl_renderer *r, const struct frame_counts *counts);
    void (*destroy)(fnl_renderer *r);
    /* Only for frames that use this method: prepares what outlives the frame, for one view. The eyes of a display share the first view's. */
    fnl_result (*prepare_view)(fnl_renderer *r, const fnl_frame *frame, struct renderer_view *view);
    /* Whether the times of the frame's passes are wanted. */
    bool (*timed)(const fnl_frame *frame);
    /* Adds what all views share to the frame and to its lighting. */
    void (*begin)(struct frame_state *shared);
    /* Before the lists of a view are made. */
    void (*begin_view)(struct frame_state *f);
    /* After what is drawn before lists: what `count` views share, so that lists made afterwards cast shadows. */
    void (*add)(struct frame_state *views, uint32_t count);
    const struct counter_table *counters;
};

/** All methods: FNL_SHADOWS_… and the row shadow_method_…. */
#define SHADOW_METHODS(ROW) ROW(OFF, off) ROW(RAYS, rays) ROW(MAPS, maps) ROW(SAMPLED, sampled) ROW(CUBEMAP, cubemap) ROW(HYBRID, hybrid)
#define DECLARE_SHADOW_METHOD(value, name) extern const struct shadow_method shadow_method_##name;
SHADOW_METHODS(DECLARE_SHADOW_METHOD)

/** The row of a method; not of auto. */
const struct shadow_method *shadow_method(fnl_shadows shadows);

#endif
