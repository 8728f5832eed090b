/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_TRANSPARENCY_SHARED_H
#define FNL_PASSES_TRANSPARENCY_SHARED_H

#include "shared.h"

/* What a fragment is sorted by: the farthest first, at equal depth in the order of items and triangles. */
struct gpu_blend_key {
    float depth; /* reversed, at the middle of the pixel */
    uint item;
    uint corner; /* the vertex that stands for the triangle */
};

/* With MSAA: where in the pixel a fragment is, and how its depth changes. */
struct gpu_blend_extent {
    vec2 slope; /* of the reversed depth, per pixel to the right and down */
    uint mask;  /* samples that the triangle covers, whether or not they pass the depth test */
};

struct gpu_linked_totals_push {
    ADDRESS(const_uint_array) sums;
    ADDRESS(uint_array) totals; /* fragments, longest list, pixels without a list that need one */
    uint pixel_count;
    uint capacity;
};

struct gpu_linked_composite_push {
    ADDRESS(const_uint_array) sums;
    ADDRESS(const_uint_array) written;
    ADDRESS(blend_color_array) colors;
    ADDRESS(blend_key_array) keys;
    ADDRESS(blend_extent_array) extents;
    ADDRESS(uint_array) order; /* scratch: `samples` numbers for each fragment */
    uint width;
    uint height;
    uint capacity;
    uint samples;
    uint sample_index; /* the one that this draw writes */
    uint depth;        /* bindless, with MSAA: what is opaque */
};

struct gpu_weighted_composite_push {
    uint sum; /* bindless */
    uint density;
    uint samples;
    uint sample_index;
};

#endif
