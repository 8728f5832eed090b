/* SPDX-License-Identifier: MIT */
/** What tests start from: frames and traced pictures with nothing that a scene does not have itself, one sample per pixel. */
#ifndef FNL_TESTS_FRAME_PLAIN_H
#define FNL_TESTS_FRAME_PLAIN_H

#include "fanal/frame.h"
#include "fanal/trace.h"

static inline fnl_frame frame_plain(void) {
    fnl_frame frame = fnl_frame_default();
    frame.msaa = 1;
    frame.aa = FNL_ANTIALIASING_NONE;
    frame.shadows = FNL_SHADOWS_OFF;
    frame.studio = false;
    frame.ground = FNL_GROUND_OFF;
    frame.background = FNL_BACKGROUND_SCENE;
    return frame;
}

static inline fnl_trace_params trace_plain(void) {
    fnl_trace_params params = fnl_trace_params_default();
    params.studio = false;
    params.ground = FNL_GROUND_OFF;
    params.background = FNL_BACKGROUND_SCENE;
    return params;
}

#endif
