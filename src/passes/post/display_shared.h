/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_DISPLAY_SHARED_H
#define FNL_PASSES_DISPLAY_SHARED_H

#include "shared.h"

/* cd/m^2 of a picture's white on a screen of high dynamic range (ITU-R BT.2408), and of the brightest pixel. */
#define HDR_WHITE 203.0f
#define HDR_PEAK 1000.0f

#define GPU_DISPLAY_LINEAR 0u /* stays in linear light, 1 is white */
#define GPU_DISPLAY_ABGR10 1u /* HDR10 in 32 bits: alpha, blue, green, red from the top */
#define GPU_DISPLAY_ARGB10 2u

struct gpu_display_push {
    uint picture; /* sampled */
    uint target;  /* storage; of the packed formats its bytes are the channels of RGBA8 */
    uint width;
    uint height;
    uint decode; /* 1: the picture is encoded as sRGB */
    uint format; /* GPU_DISPLAY_ */
};

#endif
