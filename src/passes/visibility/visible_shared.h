/* SPDX-License-Identifier: MIT */
/** What a visibility buffer shows, as a list. */
#ifndef FNL_PASSES_VISIBLE_SHARED_H
#define FNL_PASSES_VISIBLE_SHARED_H

#include "shared.h"

/*
 * An entry stands for a pixel, or for one triangle of its samples: pixel | surface << 28. Lists that are sorted have pairs of a key and
 * an entry; a key is the class of a material (GPU_CLASS_…), then as many bits of its number as are asked for. Pixels come in blocks of 8x8, row
 * by row, and in squares of four within a block.
 */
#define VISIBLE_SURFACE_SHIFT 28u
#define VISIBLE_PIXEL_MASK 0xfffffffu

/* How shading finds its pixels. */
#define VISIBLE_GRID 0u   /* a thread a pixel */
#define VISIBLE_LIST 1u   /* a thread an entry */
#define VISIBLE_SORTED 2u /* the same, of pairs */

struct gpu_visible_push {
    ADDRESS(view_block) view;
    ADDRESS(scene_block) scene;
    ADDRESS(uint_array) words;      /* with several samples: a word a pixel, row by row (samples_shared.h) */
    ADDRESS(uint_array) sums;       /* one per place of a pixel in its block, and one more: entries, then their prefix sums */
    ADDRESS(uint_array) entries;
    ADDRESS(uint_array) ranges;     /* first and end for each class */
    ADDRESS(uint_array) dispatches; /* three for each class: a thread for each entry, 64 to a group */
    ADDRESS(uint_array) counts;     /* with several samples: EDGES_… of samples_shared.h */
    ADDRESS(uint_array) results;    /* spreading: a radiance for each triangle of a pixel */
    uint ids;                       /* as in visibility_shared.h */
    uint ids_high;
    uint triangle_bits;
    uint material_bits;             /* of the keys */
    uint places;                    /* pixels in all blocks */
    uint radiance;                  /* storage; with one sample: gets the background where nothing is seen */
    vec3 background;
};

#endif
