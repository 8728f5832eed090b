/* SPDX-License-Identifier: MIT */
/** The history of a view (temporal.h). */
#ifndef FNL_RENDER_TEMPORAL_STATE_H
#define FNL_RENDER_TEMPORAL_STATE_H

#include "fanal/frame.h"
#include "view_shared.h"

struct temporal_state {
    bool valid;                                     /* the last frame was rendered */
    struct gpu_view view;                           /* its view, without jitter */
    double origin[3];                               /* of the scene then */
    vec2 jitter;
    uint64_t uploads, light_version, decal_version, probe_version, image_arrivals; /* of the scene then */
    uint32_t shadow_requests;
    vec3 background;
    fnl_frame frame;
    uint32_t index; /* of its jitter */
    uint32_t sequence, still; /* of struct frame_temporal */
};

#endif
