/* SPDX-License-Identifier: MIT */
/** Which samples of a pixel show the same surface, as a word a pixel. */
#ifndef FNL_PASSES_SAMPLES_SHARED_H
#define FNL_PASSES_SAMPLES_SHARED_H

/* A pixel's word: four bits a sample, from the least up, with the number of its surface. Surfaces are numbered from 0 by their first
   sample. */
#define SURFACE_NONE 15u /* sky, what is lit forward (gpu_gbuffer.mask), or no such sample */
#define SURFACE_BITS 4u

/* Counts over the frame. */
#define EDGES_PIXELS 0u   /* pixels that show a surface */
#define EDGES_MIXED 1u    /* pixels whose samples show more than one thing, sky being one */
#define EDGES_SURFACES 2u /* surfaces of all pixels */
#define EDGES_SAMPLES 3u  /* samples that show a surface */
#define EDGES_SHADED 4u   /* surfaces or samples shaded, where lights are counted */
#define EDGES_COUNTS 5u

#endif
