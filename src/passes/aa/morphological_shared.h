/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_MORPHOLOGICAL_SHARED_H
#define FNL_PASSES_MORPHOLOGICAL_SHARED_H

#include "shared.h"

/* Specialisation constant 0 of the edges' shader. */
#define GPU_EDGES_COLOR 0u
#define GPU_EDGES_LUMA 1u

#define MORPHOLOGICAL_THRESHOLD 0.1

/*
 * Bits of edges, 32 neighbouring pixels a word. "Top" is the edge to the pixel above, "left" to the one on the left. Four arrays one
 * after another: top by rows, left by columns, left by rows, top by columns; see morphological.glsl.
 */
struct gpu_morphological_push {
    ADDRESS(uint_array) edges;
    uint picture; /* sampled */
    uint target;  /* storage */
    uint width;
    uint height;
    uint linear; /* 1: values are linear and unbounded, 0: sRGB-encoded */
    uint swap;   /* 1: red and blue have changed places */
};

#endif
