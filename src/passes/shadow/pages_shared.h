/* SPDX-License-Identifier: MIT */
/** Choosing the pages of shadow maps: pages.h says how. */
#ifndef FNL_PASSES_SHADOW_PAGES_SHARED_H
#define FNL_PASSES_SHADOW_PAGES_SHARED_H

#include "shadows/maps_shared.h"
#include "lights/bounds_shared.h"

#define SHADOW_CLASSES 4u       /* sizes of pages: class c is SHADOW_PAGE >> c texels wide, and a cell of the atlas holds 4^c of it */
#define SHADOW_BIASES 8u        /* levels that pages may be coarser: 0 .. 7 */
#define SHADOW_MOST_OFFSET 8u
#define SHADOW_PRESSURES 28u    /* pressure 0: nothing is coarser than requested; the last: nothing has pages */
#define SHADOW_SPARE_PRESSURES 3u /* the first, which affect only SHADOW_SPARE rows; the last drops their pages */
#define SHADOW_SPARE 0u         /* importance of rows that other rows can replace; all others have at least 1 */
#define SHADOW_BLOCK 256u       /* pages that a work group takes */
#define SHADOW_NO_PLACE 0xffffffffu

/* Flags of an idle page hold its youth besides: one less than SHADOW_YOUTHS in the first frame that nobody looks it up, and then one less with each,
   down to 1, in the bits below those of the age. */
#define SHADOW_YOUTH_SHIFT 8u
#define SHADOW_YOUTHS 32u

/* What decides how much detail a light gets: pages by class at each bias, summed over the lights whose importance has the same exponent. */
#define SHADOW_IMPORTANCES 256u
#define SHADOW_TALLIES (SHADOW_IMPORTANCES * SHADOW_BIASES * SHADOW_CLASSES)

/* By row, while pages are chosen. */
#define SHADOW_ROW_IMPORTANCE 0xffu  /* the exponent, as a float has it */
#define SHADOW_ROW_CHANGED 0x100u    /* its pages of the last frame show something else */
#define SHADOW_ROW_COARSENED 0x200u
#define SHADOW_ROW_TRACED 0x400u
#define SHADOW_ROW_FACE 0x10000u      /* times 2^face: pixels look up pages of it */

struct gpu_shadow_choice {
    uint pressure; /* 0 .. SHADOW_PRESSURES - 1 */
    uint cut;      /* exponent of importance: from it on lights are under the pressure before; SHADOW_IMPORTANCES: none is */
    uint least;    /* exponent of the least importance of a light that has a page to be shown */
    uint last;     /* pages in the last frame */
    uint youth;    /* idle pages stay in cells of at least this youth; SHADOW_YOUTHS + 1: nowhere */
};

/* A cell of the atlas: what it holds of pages that were there before. */
struct gpu_shadow_cell {
    uint size;     /* class + 1; 0: nothing */
    uvec2 taken;   /* a bit for each place: of pages that are wanted; of all that stay, once it is known which do */
    uvec2 idle;    /* of pages that are not */
    uint youth;    /* the greatest of them. Where a cell has wanted pages, its youth counts as SHADOW_YOUTHS */
};

/* What room there is for new pages, for each youth of cells from 0 (free cells) to SHADOW_YOUTHS: by class the places that are free beside wanted and
   idle pages, then how many such cells there are. Behind all of them, by class, how many pages are new. */
#define SHADOW_ROOM_WORDS (SHADOW_CLASSES + 1u)
#define SHADOW_ROOMS ((SHADOW_YOUTHS + 1u) * SHADOW_ROOM_WORDS)

struct gpu_shadow_rows_push {
    ADDRESS(lighting_block) lighting;
    ADDRESS(const_shadow_sun_array) suns;
    ADDRESS(const_uint_array) keys;     /* as in struct gpu_shadow_maps; null: no oblong block has a row */
    ADDRESS(shadow_shape_array) shapes; /* those that the last frame's pages were drawn for; those of this frame come in their place */
    ADDRESS(uint_array) rows;
    ADDRESS(const_uint_array) updates;  /* by directional light, then by local light: 0, or its maps are drawn on request, of which this is the number. Null: 0 for all */
    uint row_count;
    uint sun_rows; /* how many of them, the first ones, are of directional lights */
};

struct gpu_shadow_count_push {
    ADDRESS(const_uint_array) wanted;
    ADDRESS(uint_array) rows;
    ADDRESS(uint_array) tallies;
    uint face_count;
};

struct gpu_shadow_pick_push {
    ADDRESS(const_uint_array) tallies;
    ADDRESS(shadow_choice_block) choice;
    ADDRESS(shadow_counts_block) counts;
    uint cell_count;
    uint fresh;    /* 1: there are no pages of a last frame */
};

struct gpu_shadow_hold_push {
    ADDRESS(const_uint_array) wanted;
    ADDRESS(shadow_choice_block) choice;
    ADDRESS(uint_array) rows;
    ADDRESS(uint_array) held;           /* 0 */
    ADDRESS(uint_array) biases;
    ADDRESS(uint_array) sums;           /* pages of each face */
    ADDRESS(uint_array) rooms;
    ADDRESS(const_uint_array) last_held;
    ADDRESS(shadow_counts_block) counts;
    ADDRESS(const_uint_array) traced;   /* 1 for rows whose shadows rays find; null: there are none */
    uint face_count;
    uint last_rows;
    uint sun_rows;
};

/* For each page of the last frame. */
struct gpu_shadow_stay_push {
    ADDRESS(shadow_page_array) last_pages; /* flags become those that the pages have if they stay */
    ADDRESS(shadow_choice_block) choice;
    ADDRESS(const_uint_array) rows;
    ADDRESS(uint_array) held;              /* gets the bits of the idle pages that stay */
    ADDRESS(uint_array) sums;
    ADDRESS(shadow_cell_array) cells;
    uint side;
    uint row_count;
    uint frames;                           /* from the last frame to this one: more than 1 where shadow_pages_again() kept them in between */
};

struct gpu_shadow_room_push {
    ADDRESS(shadow_cell_array) cells;
    ADDRESS(uint_array) rooms;
    ADDRESS(shadow_choice_block) choice;
    uint cell_count;
};

struct gpu_shadow_list_push {
    ADDRESS(const_uint_array) held;
    ADDRESS(const_uint_array) sums;     /* pages before each face */
    ADDRESS(uint_array) before;
    ADDRESS(shadow_page_array) pages;
    uint face_count;
};

/* In `sums`, parts one after the other: of each class the new pages in each block, of each class all pages in each block, of each class the
   free places in each cell that holds that class, the free cells; and one more. */
struct gpu_shadow_places {
    ADDRESS(shadow_page_array) pages;
    ADDRESS(const_uint_array) total;    /* how many pages there are */
    ADDRESS(shadow_cell_array) cells;
    ADDRESS(uint_array) sums;
    ADDRESS(shadow_counts_block) counts;
    ADDRESS(shadow_choice_block) choice;
    uint block_count;
    uint side;     /* cells */
};

struct gpu_shadow_find_push {
    STRUCT(gpu_shadow_places) places;
    ADDRESS(const_uint_array) held;     /* of the last frame, as the next two */
    ADDRESS(const_uint_array) before;
    ADDRESS(shadow_page_array) pages;
    uint row_count; /* of the last frame */
};

struct gpu_shadow_place_push {
    STRUCT(gpu_shadow_places) places;
};

#endif
