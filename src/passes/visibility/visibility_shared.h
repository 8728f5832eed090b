/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_VISIBILITY_SHARED_H
#define FNL_PASSES_VISIBILITY_SHARED_H

#include "shared.h"

struct gpu_visibility_push {
    ADDRESS(view_block) view;
    ADDRESS(scene_block) scene;
    ADDRESS(light_list_block) lights;
    ADDRESS(uint_array) counters;
    ADDRESS(const_uint_array) indices; /* of the scene */
    uint ids;                          /* sampled: the lower 32 bits of what is seen, 0 for nothing */
    uint ids_high;                     /* sampled: the bits above, or GPU_TEXTURE_NONE */
    uint radiance;                     /* storage */
    uint triangle_bits;                /* an id is (item + 1) << triangle_bits | triangle */
    vec3 background;
};

#endif
