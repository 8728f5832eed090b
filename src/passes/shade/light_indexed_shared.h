/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_LIGHT_INDEXED_SHARED_H
#define FNL_PASSES_LIGHT_INDEXED_SHARED_H

#include "passes/shade/volumes_shared.h"

/* How the lights of a pixel are written; the values of fnl_light_packing. Lights go by their rank among those drawn. */
#define INDEXED_IDS 0u   /* 16-bit ids, in the order in which they come */
#define INDEXED_SHIFT 1u /* four 8-bit ids in RGBA8, two bits of each in each channel: blending shifts the older ones down */
#define INDEXED_MAX 2u   /* four 8-bit ids in RGBA8: greatest and least by blending, then greatest and least of the others */

#define INDEXED_STENCIL 3u /* four 8-bit ids in RGBA8: four draws; in each, the stencil passes the next light */
#define INDEXED_SETS_PACKING 4u /* one RGBA8 channel per set of lights that do not overlap (light_sets.h) */

#define INDEXED_LAYERS 16u        /* at most */
#define INDEXED_BATCH 255u        /* lights that share an RGBA8 layer: 0 is none */
#define INDEXED_LAYER_LIGHTS 4u   /* that fit into a layer */
#define INDEXED_SETS (INDEXED_LAYERS * INDEXED_LAYER_LIGHTS)
#define INDEXED_LOST 0x10000u     /* added to a count: a light that has no id is here */

struct gpu_indexed_push {
    STRUCT(gpu_volume_head) head;
    ADDRESS(uint_array) counts; /* lights in each pixel and layer; of ids in each pixel */
    ADDRESS(uint_array) slots;  /* ids: of pixels, two to a word */
    uint depth;                 /* bindless; of several samples a pixel: their ranges (sample_bounds.h) */
    uint capacity;              /* ids of a pixel */
    uint batch;                 /* layer that is drawn */
    uint layers;
    uint first;                 /* bindless: what the first step of max has found */
    uint step;                  /* stencil: channel to write */
    ADDRESS(const_uint_array) sets; /* sets: set << 8 | place of each light, or 0 */
};

struct gpu_indexed_list_push {
    ADDRESS(view_block) view;
    ADDRESS(const_uint_array) ids; /* rank -> local light */
    ADDRESS(uint_array) counts;
    ADDRESS(uint_array) slots;     /* ids: of pixels; sets: set << 8 | place -> local light */
    ADDRESS(cell_array) cells;     /* out: one for each pixel */
    ADDRESS(uint_array) list;      /* out: four a layer for each pixel, ascending */
    ADDRESS(uint_array) totals;    /* struct light_totals: entries and overflow are added to */
    uint layers;
    uint images[INDEXED_LAYERS];   /* bindless: shift and max */
};

#endif
