/* SPDX-License-Identifier: MIT */
/** The G-buffer as shaders get it: bindless indices of sampled images. */
#ifndef FNL_GBUFFER_SHARED_H
#define FNL_GBUFFER_SHARED_H

#include "shared.h"

#define GBUFFER_TARGETS 5u /* at most, beside depth and the radiance target */

struct gpu_gbuffer {
    uint depth;
    uint targets[GBUFFER_TARGETS];
};

#endif
