/* SPDX-License-Identifier: MIT */
/**
 * Shadow maps in pages. Every local light that is a sphere, a cone, a wedge or a box has a row of SHADOW_FACES square faces: those of a cube along
 * the world's axes round its position; a box light uses the first face alone, seen along its direction. A face is a virtual map of SHADOW_LEVELS
 * levels: 1920, 960, 480, 240 and 120 texels wide in pages of 120, then 56, 24 and 8 wide as one small page each. Only pages that pixels ask for
 * are there: a bit for each, the sums of the bits before each word, and the pages in that order (so page number = sum + bits below). They lie in
 * one depth image, the atlas, with a border on each side that shows what lies beside them.
 *
 * A directional light, a sun, has rows like those of box lights, before those of the local lights. Across its direction lie square grids that
 * do not move, one for each width of texels that is a power of two metres. A block of a grid is as wide as a face, and has a row while it is one
 * of the SHADOW_SUN_SIDE squared round the viewer. Which row depends on where it is, so that it keeps the row, and its pages, while the viewer moves.
 *
 * Square texels are too long on surfaces that a sun grazes. Behind its square rows, a sun has SHADOW_SUN_OBLONGS rows
 * for oblong blocks, which may lie anywhere. Oblong texels are a power of two meters wide along `side` and another
 * along `up`. A block, named by a key, has a row in frames in which pixels need it.
 */
#ifndef FNL_SHADERS_SHADOW_MAPS_SHARED_H
#define FNL_SHADERS_SHADOW_MAPS_SHARED_H

#include "lights/bounds_shared.h"
#include "shared.h"

#define SHADOW_FACES 6u
#define SHADOW_LEVELS 8u
#define SHADOW_SQUARE_LEVELS 5u   /* of 16, 8, 4, 2, 1 pages on a side; the others are one page of half the size of the last */
#define SHADOW_PAGE 128u          /* texels of the side of a page of those, with borders; the atlas is cut into cells of this size */
#define SHADOW_BORDER 4u          /* texels on each side of a page of any size */
#define SHADOW_UNIT 16u           /* texels: side of the smallest page, and the unit of places */
#define SHADOW_FACE_WORDS 11u     /* words of 32 pages; 344 are used: 256 + 64 + 16 + 4 + 1, then 1 + 1 + 1 */
#define SHADOW_ROW_WORDS 66u
#define SHADOW_MOST_ROWS 65536u
#define SHADOW_BLOCK_TEXELS 1920  /* across a block of a sun: as across the finest level of a face */
#define SHADOW_SUN_LEVELS 12      /* grids of a sun that have rows */
#define SHADOW_SUN_SIDE 4         /* blocks on a side of each */
#define SHADOW_SUN_SQUARES 192u   /* rows of square blocks */
#define SHADOW_SUN_OBLONGS 256u   /* rows of oblong blocks: texels are not square */
#define SHADOW_OBLONG_WORDS 9u
#define SHADOW_SUN_ROWS 448u      /* all rows of a sun */
#define SHADOW_SUN_REACH 2880.0f  /* texels round the viewer that the blocks of a grid hold, at least */
#define SHADOW_NEAR 1e-4f         /* metres from the light along the axis of a face: what is nearer casts no shadow. Depth is this / that distance */

#define SHADOW_PAGE_DRAW 1u       /* the atlas does not hold what the page shows in this frame: it is to be drawn. Who draws it takes the flag off; till then it stays */
#define SHADOW_PAGE_IDLE 2u       /* nothing looks it up in this frame. It need not be drawn: with SHADOW_PAGE_DRAW it is gone in the next frame */
/* Above the flags: frames since the page was drawn, at most SHADOW_OLDEST. */
#define SHADOW_AGE_SHIFT 16u
#define SHADOW_OLDEST 0xffffu

struct gpu_shadow_page {
    uint row;   /* of the light: its index among the local lights */
    uint bit;   /* of the row, 0 .. SHADOW_ROW_WORDS * 32 - 1: which face, level and page; shadow_page_of() */
    uint place; /* least corner in the atlas, in units: x | y << 16 */
    uint flags; /* SHADOW_PAGE_…, and the age */
};

/* How the blocks of a directional light lie. Places are metres along three axes at right angles. */
struct gpu_shadow_sun {
    vec3 side;      /* unit, along the rows of pages */
    vec3 up;        /* unit, along their columns */
    vec3 direction; /* unit, in which light travels */
    vec2 eye;       /* the viewer, along side and up */
    float middle;   /* along the direction: whatever casts shadows is within `reach` of it */
    float reach;
    int coarsest;   /* of its grids: its texels are 2 to this power metres wide, and its blocks hold all that casts shadows */
};

/* By row: how many levels coarser than asked for its pages are. */
#define SHADOW_TRACED 0xffu       /* it has no pages: there was no room for even its coarsest */

/* What this frame did, as numbers. */
struct gpu_shadow_counts {
    uint wanted;    /* pages that pixels asked for, before any were made coarser */
    uint pages;     /* that there are, idle ones too */
    uint drawn;     /* of them, not there before or no longer true */
    uint evicted;   /* that were there before and are not any more */
    uint coarsened; /* lights whose pages are coarser than asked for */
    uint traced;    /* lights without pages */
    uint cells;     /* of the atlas that are in use */
    uint entries;   /* of light lists in which dark lights are looked for */
    uint dark;      /* of them, those that left */
    uint pairs;     /* of a page that is to be drawn and an item that it shows; there may have been no room for all: passes/shadow/fill.h */
    uint oblong;    /* of the wanted pages, oblong ones */
    uint cells_wanted; /* cells of the atlas that all wanted pages would take */
};

/* What shading reads. */
struct gpu_shadow_maps {
    ADDRESS(const_uint_array) held;   /* SHADOW_ROW_WORDS words for each row: a bit for each page that is there */
    ADDRESS(const_uint_array) before; /* for each of those words: pages before it */
    ADDRESS(shadow_page_array) pages;
    ADDRESS(const_uint_array) biases; /* by row: levels coarser, or SHADOW_TRACED */
    ADDRESS(const_shadow_shape_array) shapes; /* by row: struct gpu_shape, what its faces are those of */
    ADDRESS(const_shadow_sun_array) suns;
    /* SHADOW_OBLONG_WORDS for each oblong row of each sun: the key of its block (shadow_oblong_name() >> 8; 0: none),
       then a bit for each page in use. */
    ADDRESS(const_uint_array) keys;
    ADDRESS(const_uint_array) planes; /* by pixel: pack_normal() of the opaque surface; 0: no surface, or no normal */
    uint planes_across;               /* pixels per row of `planes`; 0: no planes and no keys */
    uint atlas;                       /* sampled index of the depth image */
    uint point;                       /* of a sampler that takes the nearest texel */
    float texel;                      /* 1 / texels across the atlas */
    float widest;                     /* texels across the finest level that local lights may have */
    uint first_row;                   /* a local light's row is this + its index among all lights, modulo 2^32 */
};

#endif
