/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_VOLUMES_SHARED_H
#define FNL_PASSES_VOLUMES_SHARED_H

#include "gbuffer_shared.h"

/* Vertices and indices of the two solids. A sphere is a square of cells folded into an octahedron and blown up: its vertices are the
   corners of the cells. A cone is a pyramid with its tip cut off: eight vertices near, eight far. */
#define VOLUME_SIDE 6u /* cells; even, so that folds lie on diagonals */
#define VOLUME_SPHERE_VERTICES ((VOLUME_SIDE + 1u) * (VOLUME_SIDE + 1u))
#define VOLUME_SPHERE_INDICES (VOLUME_SIDE * VOLUME_SIDE * 6u)
#define VOLUME_RING 8u
#define VOLUME_CONE_INDICES (VOLUME_RING * 6u + (VOLUME_RING - 2u) * 6u)
/* A rectangle on the screen instead, for any light: four vertices after those of the solids. */
#define VOLUME_QUAD_VERTEX (VOLUME_SPHERE_VERTICES + 2u * VOLUME_RING)
#define VOLUME_QUAD_INDICES 6u
/* Or an octagon round its ellipse, or the whole screen. */
#define VOLUME_OCTAGON_VERTEX (VOLUME_QUAD_VERTEX + 4u)
#define VOLUME_OCTAGON_INDICES 18u
#define VOLUME_SCREEN_VERTEX (VOLUME_OCTAGON_VERTEX + 8u)
#define VOLUME_SCREEN_INDICES 3u
/* What is drawn for a light; the values of fnl_volume_shape. */
#define VOLUME_SOLIDS 0u
#define VOLUME_QUADS 1u
#define VOLUME_SCREEN 2u
#define VOLUME_ELLIPSE 3u
#define VOLUME_DEPTH_BOUNDS 4u
#define VOLUME_STENCIL 5u
/* So many lights in view are drawn one by one, each behind its own stencil; those beyond as VOLUME_SOLIDS. */
#define VOLUME_STENCIL_LIGHTS 2048u
#define VOLUME_NONE 0xffffffffu
#define VOLUME_BATCH_MAX 64u /* maximum lights added per fullscreen draw; cannot exceed the group size of volumes_fill.comp */
/* The farthest face of the sphere's solid is this far from the middle when its vertices are at 1, and the cosine of pi / VOLUME_RING. */
#define VOLUME_SPHERE_INSIDE 0.92475f
#define VOLUME_CONE_INSIDE 0.92387f

/* Spheres are sorted before cones; each kind ascends by light. */
struct gpu_volumes_push {
    ADDRESS(view_block) view;
    ADDRESS(lighting_block) lighting;
    ADDRESS(uint_array) sums;   /* kind * light_count + light, and one more: 1 for the volumes drawn, then their prefix sum */
    ADDRESS(uint_array) ids;    /* instance -> local light; with a batch: the lights in view, `batch` per instance, then `batch` times VOLUME_NONE */
    ADDRESS(volume_draws) draws;
    uint light_count;           /* local lights */
    uint cull;                  /* 0: lights out of the view are drawn too */
    uint shape;                 /* VOLUME_…; flat ones are sorted as spheres are */
    uint alone;                 /* so many of the volumes have a draw each, after the two of the rest */
    uint by_light;              /* 1: those are the first lights, in view or not, and not the first volumes */
    uint batch;                 /* VOLUME_SCREEN: lights per instance; otherwise 1 */
};

/* What the vertex shader reads: push constants of all that draws volumes begin with it. */
struct gpu_volume_head {
    ADDRESS(view_block) view;
    ADDRESS(lighting_block) lighting;
    ADDRESS(const_uint_array) ids;
    ADDRESS(uint_array) counters;
};

/* The same, and more. */
struct gpu_volume_push {
    ADDRESS(view_block) view;
    ADDRESS(lighting_block) lighting;
    ADDRESS(const_uint_array) ids;
    ADDRESS(uint_array) counters;
    ADDRESS(uint_array) words;     /* with several samples a pixel, as the last: samples_shared.h */
    STRUCT(gpu_gbuffer) gbuffer;
    uint layer;                    /* which surface of each pixel is lit */
    uint mask; /* bindless: what is left of the light at each pixel, in red */
};

#endif
