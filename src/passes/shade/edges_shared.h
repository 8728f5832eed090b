/* SPDX-License-Identifier: MIT */
/** Telling apart what the samples of a G-buffer show. */
#ifndef FNL_PASSES_EDGES_SHARED_H
#define FNL_PASSES_EDGES_SHARED_H

#include "gbuffer_shared.h"
#include "passes/shade/samples_shared.h"

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
