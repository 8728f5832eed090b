/* SPDX-License-Identifier: MIT */
/** Cameras on what the tests of culling scatter around the origin. */
#ifndef FNL_TESTS_VIEW_CASES_H
#define FNL_TESTS_VIEW_CASES_H

#include "fanal/renderer.h"

enum { VIEW_PLAIN, VIEW_SHIFTED, VIEW_ORTHOGRAPHIC, VIEW_INSIDE, VIEW_COUNT };

static inline void view_cases_look(fnl_frame *frame, uint32_t view) {
    frame->camera = fnl_camera_default();
    frame->camera.position = (fnl_vec3){1, 2, 11};
    frame->camera.target = (fnl_vec3){0, -0.5f, 0};
    if (view == VIEW_SHIFTED) {
        frame->camera.shift = (fnl_vec2){0.3f, -0.4f};
        frame->jitter = (fnl_vec2){0.31f, -0.22f};
    }
    if (view == VIEW_ORTHOGRAPHIC) {
        frame->camera.orthographic = true;
        frame->camera.vertical_extent = 8;
        frame->camera.near_distance = 6;
        frame->camera.far_distance = 30;
    }
    if (view == VIEW_INSIDE) {
        frame->camera.position = (fnl_vec3){0.5f, 0, 1};
        frame->camera.near_distance = 0.3f;
    }
}

#endif
