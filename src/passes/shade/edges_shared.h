/* SPDX-License-Identifier: MIT */
/** Which samples of a pixel show the same surface. */
#ifndef FNL_PASSES_EDGES_SHARED_H
#define FNL_PASSES_EDGES_SHARED_H

#include "gbuffer_shared.h"

/* A pixel's word: four bits a sample, from the least up, with the number of its surface. Surfaces are numbered from 0 by their first
   sample. */
#define SURFACE_NONE 15u /* sky, or no such sample */
#define SURFACE_BITS 4u

/* Counts over the frame. */
#define EDGES_PIXELS 0u   /* pixels that show a surface */
#define EDGES_MIXED 1u    /* pixels whose samples show more than one thing, sky being one */
#define EDGES_SURFACES 2u /* surfaces of all pixels */
#define EDGES_SAMPLES 3u  /* samples that show a surface */
#define EDGES_SHADED 4u   /* surfaces or samples shaded, where lights are counted */
#define EDGES_COUNTS 5u

struct gpu_edges_push {
    ADDRESS(view_block) view;
    ADDRESS(uint_array) surfaces;  /* a word a pixel */
    ADDRESS(uint_array) sums;      /* one per pixel and one more: surfaces beyond the first, then their prefix sums */
    ADDRESS(uint_array) entries;   /* pixel | surface << 28, pixel by pixel */
    ADDRESS(uint_array) dispatch;  /* three: a thread for each entry, 64 to a group */
    ADDRESS(uint_array) counts;    /* EDGES_… */
    STRUCT(gpu_gbuffer) gbuffer;
    uint radiance;                 /* sampled: the emission */
    float tolerance;               /* 0: stored bits are compared */
    uint limit;                    /* surfaces of a pixel at most; those that are more alike are merged */
    uint lists;                    /* 1: sums are wanted */
};

#endif
