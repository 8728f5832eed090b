/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_WALK_TEST_SHARED_H
#define FNL_PASSES_WALK_TEST_SHARED_H

#include "shared.h"

struct gpu_walk_point {
    uvec2 pixel;
    float view_depth;
    vec3 position; /* world space */
    vec3 normal;
};

#define GPU_WALK_ROOM 1200u /* entries a point */

struct gpu_walk_push {
    ADDRESS(light_list_block) list;
    ADDRESS(walk_point_array) points;
    ADDRESS(uint_array) found; /* for each point their number, then GPU_WALK_ROOM lights */
    uint point_count;
};

#endif
