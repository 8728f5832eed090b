/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_MOTION_SHARED_H
#define FNL_PASSES_MOTION_SHARED_H

#include "passes/geometry/geometry_shared.h"
#include "shared.h"
#include "view_shared.h"

#define MOTION_SKY_DEPTH 1e30

struct gpu_motion {
    STRUCT(gpu_view) previous; /* without jitter */
    mat4 view_to_previous;     /* from this frame's view space to the last one's */
    vec2 jitter;
    uint has_previous;
    vec3 origin_moved; /* since the last frame, whose transforms are relative to the old origin */
};

struct gpu_motion_push {
    ADDRESS(view_block) view;
    ADDRESS(motion_block) motion;
    uint depth;   /* sampled */
    uint objects; /* sampled; with has_objects */
    uint target;  /* storage */
    uint has_objects;
};

/* Begins as gpu_geometry_push does. */
struct gpu_motion_objects_push {
    STRUCT(gpu_geometry_push) geometry;
    ADDRESS(motion_block) motion;
    ADDRESS(instance_array) instances; /* of the last frame */
    ADDRESS(position_array) positions; /* of vertices from first_deformed on, in the last frame */
    uint instance_count;               /* there are no others in it */
    uint first_deformed;
    uint deformed_count;
};

struct gpu_motion_view_push {
    uint motion; /* sampled */
    uint target; /* storage */
    uint width;
    uint height;
    uint swap; /* 1: red and blue change places */
};

#endif
