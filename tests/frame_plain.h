/* SPDX-License-Identifier: MIT */
/** What tests start from: frames and traced pictures with nothing that a scene does not have itself, one sample per pixel; scenes lit by lights. */
#ifndef FNL_TESTS_FRAME_PLAIN_H
#define FNL_TESTS_FRAME_PLAIN_H

#include "fanal/frame.h"
#include "fanal/trace.h"

#include <string.h>

static inline fnl_frame frame_plain(void) {
    fnl_frame frame = fnl_frame_default();
    frame.msaa = 1;
    frame.aa = FNL_ANTIALIASING_NONE;
    frame.shadows = FNL_SHADOWS_OFF;
    frame.shadow.filter = FNL_SHADOW_FILTER_HARD;
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

/** Loads a scene; a built-in one without its environment, whose maps take longer than a small picture. */
static inline fnl_result scene_load_plain(const fnl_host *host, const char *source, const fnl_load_params *params, fnl_scene **out) {
    const fnl_result result = fnl_scene_load(host, source, params, out);
    return result == FNL_OK && strncmp(source, "builtin:", 8) == 0 ? fnl_scene_set_environment(*out, NULL) : result;
}

#endif
