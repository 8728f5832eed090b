/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_POST_SHARED_H
#define FNL_PASSES_POST_SHARED_H

#include "exposure_shared.h"
#include "shared.h"

struct gpu_meter_push {
    ADDRESS(uint_array) histogram; /* METER_BINS of surfaces, then as many of the background */
    uint radiance;                 /* bindless: sampled, SAMPLES a pixel */
    uint depth;                    /* the same; 0: background */
    uint width;
    uint height;
};

struct gpu_exposure_push {
    ADDRESS(uint_array) histogram;
    ADDRESS(float_array) exposure; /* [0]: factor, [1]: EV100 */
};

/* Values of fnl_tonemap. */
#define GPU_TONEMAP_NONE 0u
#define GPU_TONEMAP_KHRONOS_NEUTRAL 1u
#define GPU_TONEMAP_ACES 2u
#define GPU_TONEMAP_AGX 3u

struct gpu_tonemap_push {
    ADDRESS(float_array) exposure; /* [0]: factor, used where `metered` is 1 */
    float factor;
    uint metered;
    uint radiance;                 /* bindless: sampled, SAMPLES a pixel */
    uint target;                   /* bindless: storage */
    uint width;
    uint height;
    uint encode;                   /* 1: sRGB-encoded and clamped to 0..1; 0: linear, tone mapping off */
    uint swap;                     /* 1: red and blue change places */
    uint tonemap;
};

struct gpu_depth_picture_push {
    uint depth;   /* sampled, SAMPLES a pixel */
    uint forward; /* 1: 1 minus it */
};

struct gpu_resolve_push {
    uint radiance; /* sampled, SAMPLES a pixel */
    uint target;   /* storage */
    uint width;
    uint height;
};

#endif
