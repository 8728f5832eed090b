/* SPDX-License-Identifier: MIT */
/**
 * `fanal cave`: what it was asked for, and its parts. The three contexts of a CAVE (docs/cave.md): what belongs to the frame is struct cave_moment, of which
 * there is one for all walls; a display is a struct cave_wall; an eye is a struct cave_view.
 */
#ifndef FNL_CLI_CAVE_CAVE_H
#define FNL_CLI_CAVE_CAVE_H

#include "cave/displays.h"
#include "render.h"

#include <jansson.h>

enum { CAVE_VIEWS = 2 * CAVE_WALLS };

enum cave_fault_kind { CAVE_FAULT_NONE, CAVE_FAULT_LATE, CAVE_FAULT_LOST, CAVE_FAULT_POSE };
/** Something that goes wrong on purpose: a drill. */
struct cave_fault {
    enum cave_fault_kind kind;
    uint32_t rank;
    uint64_t frame;
    double seconds; /* late */
};

struct cave_options {
    struct render_options render; /* scene, frame, channels of .exr files; its outputs are patterns with %w, %e and %d */
    const char *displays;
    uint32_t width, height; /* instead of the walls' resolution; 0: that */
    double timeout;         /* seconds */
    bool gather, places_by_camera;
    struct cave_fault fault;
    uint64_t hash; /* of the options that change pictures */
};

/** What is the same on every wall at a moment; sent between ranks as it is. */
struct cave_moment {
    uint64_t frame;
    double display_time, animation_time; /* seconds */
    struct cave_pose head;               /* in the space of the CAVE */
    struct cave_vector eyes[CAVE_EYES];  /* in the space of the head, metres */
    double ev;                           /* of all pictures, where exposure is not auto by wall */
};

struct cave_moment cave_predict(const struct cave_options *options, const struct cave_displays *displays, uint64_t frame, double ev);
uint64_t cave_moment_hash(const struct cave_moment *moment);

/** One eye's picture of one wall. */
struct cave_view {
    uint32_t wall, rank, device, width, height;
    enum cave_eye eye;
};

/** All views, wall by wall, left before right; `rank_count` 0: there are no ranks, everything is rank 0's. Returns how many; 0 after a message. */
uint32_t cave_list_views(const struct cave_options *options, const struct cave_displays *displays, uint32_t rank_count, struct cave_view out[CAVE_VIEWS]);
/** The camera of a view. False after a message that names wall, eye and distance. */
bool cave_view_camera(const struct cave_displays *displays, const struct cave_place *place, const struct cave_moment *moment, const struct cave_view *view,
                      fnl_camera *out);
/** "front/left" or "front". */
void cave_view_name(const struct cave_displays *displays, const struct cave_view *view, char *out, size_t capacity);
/** Where the CAVE stands: by its file, or so that the head of `moment` is at the camera and looks its way, upright. */
struct cave_place cave_find_place(const struct cave_displays *displays, const struct cave_moment *moment, const fnl_camera *camera, bool by_camera);
/** The path of a view's picture: %w is the wall, %e the eye, %d the frame. */
void cave_path(const char *pattern, const struct cave_displays *displays, const struct cave_view *view, uint64_t frame, char *out, size_t capacity);
/** What is wrong with a pattern for these views and frames; NULL: nothing. */
const char *cave_pattern_problem(const char *pattern, const struct cave_displays *displays, uint64_t frames);

/* ---- rendering ---- */

/** The devices of this process, a renderer for each size of walls on each, and what they showed last. */
struct cave_stage;

/** `mine`: the views to render, of the list. */
bool cave_stage_create(const struct cave_options *options, const struct cave_displays *displays, const fnl_host *host, fnl_scene *scene,
                       const struct cave_view *views, uint32_t view_count, uint32_t rank, struct cave_stage **out);
void cave_stage_destroy(struct cave_stage **stage);
/** The EV100 that suits the place of the head, from all around. */
bool cave_stage_meter(struct cave_stage *stage, const struct cave_place *place, const struct cave_moment *moment, double *out_ev);
/** Poses the scene once, and renders all views at once, each device its own. */
bool cave_stage_render(struct cave_stage *stage, const struct cave_place *place, const struct cave_moment *moment);
/** The picture `output` (bit number of fnl_output) of view `view`, which the stage keeps; false: it does not render it. */
bool cave_stage_picture(const struct cave_stage *stage, uint32_t view, uint32_t output, fnl_image *out);
/** Numbers of the last frame: an array with an object for each renderer. */
json_t *cave_stage_report(const struct cave_stage *stage);
/** Messages of Vulkan validation so far. */
uint64_t cave_stage_messages(const struct cave_stage *stage);

/** Loads, renders, writes; returns the exit status. */
int cave_run(const struct cave_options *options, const struct cave_displays *displays);

#endif
