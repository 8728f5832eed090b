/* SPDX-License-Identifier: MIT */
/** Colours of debug views, for the shaders and the legends: each is given to COLOR, as three numbers. */
#ifndef FNL_PASSES_DEBUG_COLORS_SHARED_H
#define FNL_PASSES_DEBUG_COLORS_SHARED_H

/* Viridis, evenly spaced, of 255: brighter is more, for all kinds of colour vision and in grey. S. van der Walt and N. Smith, matplotlib 1.5, 2015 (CC0). */
#define DEBUG_RAMP_STOPS 9
#define DEBUG_RAMP(COLOR)                                                                                                        \
    COLOR(68, 1, 84), COLOR(71, 45, 123), COLOR(59, 82, 139), COLOR(44, 114, 142), COLOR(33, 144, 140), COLOR(39, 173, 129),     \
        COLOR(93, 200, 99), COLOR(170, 220, 50), COLOR(253, 231, 37)
/* Counts of 1, 2, 4 … 256 stand at 1, 2, 3 … 9 of so many parts. */
#define DEBUG_COUNT_PARTS 9

#define DEBUG_EDGE_SKY(COLOR) COLOR(0.15, 0.35, 1.0)
#define DEBUG_EDGE_2(COLOR) COLOR(0.1, 0.8, 0.2)
#define DEBUG_EDGE_3(COLOR) COLOR(1.0, 0.8, 0.1)
#define DEBUG_EDGE_4(COLOR) COLOR(1.0, 0.1, 0.1)

#define DEBUG_METAL(COLOR) COLOR(0.1, 0.35, 0.95)
#define DEBUG_HALO_DARK(COLOR) COLOR(0.25, 0.0, 0.0)
#define DEBUG_HALO_BRIGHT(COLOR) COLOR(1.0, 0.15, 0.0)

#define DEBUG_COARSE_SHARED(COLOR) COLOR(0.1, 0.8, 0.2)
#define DEBUG_COARSE_DEPTH(COLOR) COLOR(1.0, 0.15, 0.1)
#define DEBUG_COARSE_NORMAL(COLOR) COLOR(0.2, 0.4, 1.0)
#define DEBUG_COARSE_OTHER(COLOR) COLOR(1.0, 0.8, 0.1)
#define DEBUG_COARSE_EACH(COLOR) COLOR(1.0, 0.1, 0.8)
#define DEBUG_COARSE_HALF(COLOR) COLOR(1.0, 0.5, 0.0)

#define DEBUG_DAIS_1(COLOR) COLOR(0.15, 0.15, 0.15)
#define DEBUG_DAIS_2(COLOR) COLOR(0.1, 0.7, 0.2)
#define DEBUG_DAIS_3(COLOR) COLOR(0.9, 0.8, 0.1)
#define DEBUG_DAIS_4(COLOR) COLOR(0.9, 0.15, 0.1)

#define DEBUG_SHADOW_RAYS(COLOR) COLOR(0.9, 0.1, 0.8)
#define DEBUG_TEXEL_QUARTER(COLOR) COLOR(0.1, 0.3, 0.9)
#define DEBUG_TEXEL_PIXEL(COLOR) COLOR(0.1, 0.75, 0.2)
#define DEBUG_TEXEL_WIDER(COLOR) COLOR(0.95, 0.85, 0.1)
#define DEBUG_TEXEL_8(COLOR) COLOR(0.95, 0.1, 0.05)
#define DEBUG_SHADOW_EXTRA(COLOR) COLOR(1.0, 0.1, 0.05)
#define DEBUG_SHADOW_MISSING(COLOR) COLOR(0.1, 0.35, 1.0)
#define DEBUG_CLASS_LEFT(COLOR) COLOR(0.1, 0.3, 0.9)
#define DEBUG_CLASS_DARK(COLOR) COLOR(1.0, 0.45, 0.05)
#define DEBUG_CLASS_SOME(COLOR) COLOR(0.4, 0.4, 0.4)
#define DEBUG_CLASS_ALL(COLOR) COLOR(1.0, 1.0, 1.0)

#endif
