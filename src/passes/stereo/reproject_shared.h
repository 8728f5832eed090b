/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_REPROJECT_SHARED_H
#define FNL_PASSES_REPROJECT_SHARED_H

#include "shared.h"

struct gpu_reproject_push {
    mat4 to_new;   /* from the space of the eye that the picture was rendered for to that of the eye now */
    vec4 rendered; /* left, right, down, up of the picture, tangents */
    uint picture;  /* sampled, linear light */
    uint depth;    /* view depth in metres, 0: nothing */
    uint sampler_index;
    uint pad;
    vec2 size;
};

#endif
