/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_MOBILE_SHARED_H
#define FNL_PASSES_MOBILE_SHARED_H

#include "shared.h"

/* Values of fnl_mobile_layout. */
#define GPU_MOBILE_METALLIC_128 0
#define GPU_MOBILE_SPECULAR_160 1
#define GPU_MOBILE_METALLIC_256 2
#define GPU_MOBILE_SPECULAR_256 3

/* Values of fnl_mobile_gamma: how the 8-bit layouts keep colours. */
#define GPU_MOBILE_SRGB 0u  /* by the hardware */
#define GPU_MOBILE_SQRT 1u  /* exponent 2 */
#define GPU_MOBILE_POWER 2u /* exponent 2.2 */

#define MOBILE_MOST_TARGETS 8u

struct gpu_mobile_push {
    ADDRESS(view_block) view;
    ADDRESS(lighting_block) lighting;
    ADDRESS(uint_array) counters;
    uint images[MOBILE_MOST_TARGETS]; /* separate passes: the targets as sampled images */
    float factor;                     /* of radiance, for the picture */
    uint tonemap;                     /* GPU_TONEMAP_… */
    uint encode;                      /* 0: radiance; 1: a picture, tone-mapped and sRGB-encoded; 2: a linear one */
    uint swap;                        /* 1: red and blue change places */
};

#endif
