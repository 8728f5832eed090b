/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_LIGHT_PROXY_TEST_SHARED_H
#define FNL_PASSES_LIGHT_PROXY_TEST_SHARED_H

#include "shared.h"

struct gpu_light_answer {
    vec3 illuminance;
    vec3 to_light;
    uint reaches;
};

struct gpu_light_proxy_push {
    ADDRESS(light_list_block) list;
    ADDRESS(point_array) points;   /* points_each for each light */
    ADDRESS(answer_array) answers; /* as many */
    ADDRESS(point_array) corners;  /* eight for each light */
    uint light_count;
    uint points_each;
};

#endif
