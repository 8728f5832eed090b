/* SPDX-License-Identifier: MIT */
/**
 * fanal view: two methods of one scene at once. A is what the window shows anyway (view.frame, view.renderer), B has options and a renderer of its own.
 */
#ifndef FNL_CLI_VIEW_COMPARE_H
#define FNL_CLI_VIEW_COMPARE_H

#include "fanal/fanal.h"

#include <stdio.h>

struct view;
struct view_event;
struct fnl_vulkan_target;

enum view_compare_mode {
    VIEW_COMPARE_OFF,
    VIEW_COMPARE_SPLIT,      /* left of the slider A's picture, right of it B's */
    VIEW_COMPARE_SIDE,       /* each in a half of its own */
    VIEW_COMPARE_DIFFERENCE, /* how far they are apart, at rest; while something moves as split */
    VIEW_COMPARE_COUNT
};

enum { VIEW_TIMES = 64 };
struct view_compare {
    enum view_compare_mode mode;
    bool begun;            /* B has been something else than a copy of A to come */
    bool edits_b;          /* the panel of options shows B's */
    bool own_shadows;      /* as view.own_shadows */
    fnl_frame frame, good; /* as view.frame and view.good */
    fnl_renderer *renderer;
    double milliseconds; /* of B's passes */
    struct view_times {
        float last[VIEW_TIMES]; /* milliseconds of frames with the same options and size */
        uint32_t count;         /* of all so far */
    } times[2];
    fnl_frame timed[2]; /* these */
    float slider;        /* where B begins, 0 .. 1 of the width */
    bool drags;
    /* The difference. */
    float gain;     /* 0: the greatest is white */
    float shown_gain;
    bool is_shown;  /* in place of the pictures */
    uint64_t version;
    fnl_image pictures[2], shown;
    fnl_image_difference numbers;
    fnl_scene *no_scene; /* behind the picture of the difference */
    fnl_renderer *no_renderer;
};

const char *view_compare_name(enum view_compare_mode mode);
/** False with a message: no mode is called so. */
bool view_compare_set_mode(struct view *view, const char *name);
void view_compare_begin(struct view *view, enum view_compare_mode mode);
/** Begins with B as A but for `changes`, KEY=VALUE[,...]; false with a message. NULL: without B. */
bool view_compare_start(struct view *view, const char *changes);
/** An option of B; false with a message. */
bool view_compare_set_b(struct view *view, const char *text);
void view_compare_copy(struct view *view); /* B becomes as A */
void view_compare_expose(struct view *view); /* A's exposure has changed: B gets it too */
void view_compare_swap(struct view *view);
/** Before the scene goes. */
void view_compare_leave(struct view *view);

/** The options that differ, as "lists=tiled shading=forward", of A or of B; cut where it does not fit. */
void view_compare_method(const struct view *view, bool of_b, char *text, size_t capacity);
/** The options that the panel edits. */
fnl_frame *view_edited(struct view *view);

/** Before the panels of a frame: finds the difference, where that is to be shown. */
void view_compare_update(struct view *view);
/** Over the picture and behind the panels. */
void view_compare_back(struct view *view);
/** The controls, in a menu (panel_compare.c), and those that choose between A and B, above the options too. */
void view_panel_compare(struct view *view);
void view_compare_choose(struct view *view);
/** Draws A as `frame` says and B likewise; `target` NULL: only into their own pictures. */
fnl_result view_compare_draw(struct view *view, const fnl_frame *frame, const struct fnl_vulkan_target *target);
/** What the window shows, for `frame` with its overlay; free it. */
fnl_result view_compare_read(struct view *view, const fnl_frame *frame, fnl_image *out);
/** The width of the picture that the window shows at column *x, which becomes that picture's own. */
uint32_t view_compare_place(const struct view *view, uint32_t *x);
/** The camera of the picture that shows A or B there. */
fnl_camera view_compare_camera(const struct view *view, bool of_b);
void view_compare_note(struct view *view); /* after a frame */

/** Whether the press belongs to the slider. */
bool view_compare_press(struct view *view, const struct view_event *event);
void view_compare_move(struct view *view);

void view_compare_report(const struct view *view, FILE *file);

#endif
