/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_OVERLAY_SHARED_H
#define FNL_PASSES_OVERLAY_SHARED_H

#include "shared.h"

/* fnl_overlay_vertex. */
struct gpu_overlay_vertex {
    vec2 position;
    vec2 texel;
    uint color;
};

struct gpu_overlay_push {
    ADDRESS(overlay_vertices) vertices; /* from the draw's first on */
    ADDRESS(const_uint_array) indices;
    vec2 corner;   /* the picture's, upper left */
    vec2 scale;    /* of pixels to -1 .. 1 */
    uint image;    /* bindless: sampled; ~0: white */
    uint sampler_index;
    uint linear;   /* 1: colours are decoded from sRGB */
    uint swap;     /* 1: red and blue change places */
};

#endif
