/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_DEFERRED_MSAA_SHARED_H
#define FNL_PASSES_DEFERRED_MSAA_SHARED_H

#include "passes/shade/edges_shared.h"

/* Values of fnl_msaa_method. */
#define MSAA_ALL 0u
#define MSAA_TILES 1u
#define MSAA_STENCIL 2u
#define MSAA_COMPACT 3u
#define MSAA_COVERAGE 4u
#define MSAA_AGGREGATE 5u

/* Which part of a method a dispatch is. */
#define MSAA_STEP_FIRST 0u /* every pixel */
#define MSAA_STEP_REST 1u  /* what else edges need */

/*
 * Results are pixels times slots, slot by slot. By method: all, tiles and stencil have a slot for each sample, of which pixels that are no
 * edges fill the first; compact and aggregate have one for the first surface of each pixel and one for each entry behind them; coverage has
 * one for the surface with the most samples.
 */
struct gpu_deferred_msaa_push {
    ADDRESS(view_block) view;
    ADDRESS(lighting_block) lighting;
    ADDRESS(uint_array) counters;
    ADDRESS(uint_array) surfaces;  /* edges_shared.h */
    ADDRESS(uint_array) sums;
    ADDRESS(uint_array) entries;
    ADDRESS(uint_array) results;   /* two halves a word, two words a result; or three floats */
    ADDRESS(uint_array) counts;    /* EDGES_SHADED is counted up */
    STRUCT(gpu_gbuffer) gbuffer;
    uint radiance;                 /* sampled: the emission */
};

#endif
