/* SPDX-License-Identifier: MIT */
/** Groups the views of a frame before anything is declared. See docs/techniques/views.md and stereo.md. */
#ifndef FNL_RENDER_VIEW_PLAN_H
#define FNL_RENDER_VIEW_PLAN_H

#include "base/base.h"
#include "base/maths.h"
#include "fanal/frame.h"

/** Views of a group at most: as many as every device with multiview draws at once. */
enum { GROUP_MOST = 6, GROUP_FAR = 1 }; /* and one behind them, of what is far away */

/** Plan input. */
struct view_plan_input {
    const fnl_frame *frame;        /* settled: only stereo.path and multiview may be `auto` */
    bool multiview, vertex_layers; /* of the device */
    bool has_decals;               /* of the scene; found in lists of one view */
    struct box bounds;
    uint32_t asked_together;       /* views drawn at once in a one-view frame declared only for its pipelines; 0: as planned */
};

struct view_group {
    uint32_t first, count; /* of the frame's views */
    uint32_t together;     /* views that drawing visits at once; 1: each by itself */
    fnl_stereo_path path;  /* how, if more than one */
    bool is_display;       /* eyes of one viewer: they cull together, and share lists, shadow pages and exposure */
    /*
     * The mono view holds what is far away. Eyes are drawn first and occlude the mono view; the mono view is shaded
     * first, and the eyes go over it. It has no exposure, history or outputs.
     */
    bool has_far;
    uint32_t far_index; /* of its camera and state, after those of all views */
    fnl_camera far_camera;
    uint32_t far_width, far_height;
};

struct view_plan {
    uint32_t group_count, camera_count;
    fnl_stereo_path path; /* of eyes: what was asked for, or the nearest that the device has */
    struct view_group groups[FNL_VIEWS_MAX];
};

/** Pure: the same input gives the same plan. */
void view_plan_make(const struct view_plan_input *input, struct view_plan *out);

/** Views of a frame: 1 where it has no array of them. */
static inline uint32_t frame_view_count(const fnl_frame *frame) { return MAX(frame->view_count, 1u); }
/** Mono views (fnl_stereo_options.mono_distance): one per display, after the views. Its slot stays empty if the eyes diverge too far. */
static inline uint32_t frame_far_count(const fnl_frame *frame) {
    return frame->stereo.eyes > 0 && frame->stereo.mono_distance > 0 ? frame->view_count / frame->stereo.eyes : 0;
}
/** Views plus mono views; each has a camera, counters and state. */
static inline uint32_t frame_camera_count(const fnl_frame *frame) { return frame_view_count(frame) + frame_far_count(frame); }

#endif
