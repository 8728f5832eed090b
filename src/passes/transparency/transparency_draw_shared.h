/* SPDX-License-Identifier: MIT */
/** Push constants of the passes that draw blended geometry. */
#ifndef FNL_PASSES_TRANSPARENCY_DRAW_SHARED_H
#define FNL_PASSES_TRANSPARENCY_DRAW_SHARED_H

#include "passes/geometry/geometry_shared.h"
#include "passes/transparency/transparency_shared.h"

/* Lists of fragments: those of pixel p are sums[p] .. sums[p] + written[p] - 1. */
struct gpu_linked_push {
    STRUCT(gpu_geometry_push) geometry;
    ADDRESS(const_uint_array)
    sums; /* pixels + 1: fragments counted in all pixels before; pixels that end beyond `capacity` have no list */
    ADDRESS(uint_array) written;       /* one per pixel */
    ADDRESS(blend_color_array) colors; /* vec4: radiance times coverage; coverage */
    ADDRESS(blend_key_array) keys;
    ADDRESS(blend_extent_array) extents; /* with MSAA */
    uint capacity;
    uint samples;
};

struct gpu_weighted_push {
    STRUCT(gpu_geometry_push) geometry;
    uint half_sums; /* 1: the targets hold 16-bit numbers */
};

#endif
