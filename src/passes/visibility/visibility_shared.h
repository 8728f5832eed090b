/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_VISIBILITY_SHARED_H
#define FNL_PASSES_VISIBILITY_SHARED_H

#include "shared.h"

struct gpu_visibility_push {
    ADDRESS(view_block) view;
    ADDRESS(scene_block) scene;
    ADDRESS(lighting_block) lighting;
    ADDRESS(uint_array) counters;
    ADDRESS(const_uint_array) indices; /* of the scene */
    ADDRESS(uint_array) entries;       /* with lists: what is shaded, see visible_shared.h */
    ADDRESS(uint_array) range;         /* with lists: first and end of the entries of this dispatch */
    ADDRESS(uint_array) words;         /* with several samples: samples_shared.h */
    ADDRESS(uint_array) sums;          /* with several samples: place of a pixel's first result */
    ADDRESS(uint_array) results;       /* with several samples */
    ADDRESS(uint_array) counts;        /* with several samples and counters: EDGES_… */
    uint ids;                          /* sampled: the lower 32 bits of what is seen, 0 for nothing */
    uint ids_high;                     /* sampled: the bits above, or GPU_TEXTURE_NONE */
    uint radiance;                     /* storage; with one sample */
    uint triangle_bits;                /* an id is (item + 1) << triangle_bits | triangle */
    vec3 background;
    uint weights;                      /* sampled, all three: with stored weights */
    uint gradients;
    uint depth;
};

#endif
