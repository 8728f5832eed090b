/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_SHADOW_CUBEMAP_TEST_SHARED_H
#define FNL_PASSES_SHADOW_CUBEMAP_TEST_SHARED_H

#include "shared.h"

struct gpu_cube_case {
    vec3 from;
    vec3 along;
    vec3 half_size;
};

/* What came out: box_exit(); and `along` by way of its face, scaled to a greatest component of 1. */
struct gpu_cube_answer {
    float distance;
    vec3 along;
};

struct gpu_cubes_push {
    ADDRESS(cube_cases) cases;
    ADDRESS(cube_answers) answers;
    uint count;
};

#endif
