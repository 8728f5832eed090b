/* SPDX-License-Identifier: MIT */
/** What the targets of the shading order texturing hold. All are of unsigned integers; those of one form follow one another in this order. */
#ifndef FNL_PASSES_TEXTURING_SHARED_H
#define FNL_PASSES_TEXTURING_SHARED_H

#include "passes/geometry/geometry_shared.h"
#include "passes/texturing/virtual_shared.h"
#include "shared.h"

#define TEXTURING_TARGETS 8u

/* Always: the tangent frame (64 bits, texturing.glsl), texture coordinates (2 or, with UV1, 4 floats), and the material's number, or with
   ITEMS the draw item's (16 bits where they hold all, else 32). Then, by these bits of the form: */
#define TEXTURING_UV1 1u       /* the second set of coordinates too */
#define TEXTURING_GRADIENTS 2u /* how coordinates change to the right and down: 4 or, with UV1, 8 halves */
#define TEXTURING_SLOPES 4u    /* how depth changes to the right and down, as parts of itself: 2 halves */
#define TEXTURING_COLORS 8u    /* the vertex colour: 4 x 16 bits */
#define TEXTURING_ITEMS 16u    /* the item, for decals, and where slopes are stored with it */
#define TEXTURING_BIND 32u     /* of decals of meshes: position before deforming (3 floats), its changes (6 halves); two targets */
/* Virtual texturing: the tangent frame has 32 bits, coordinates are a place in the atlas, 2 x 16 bits; no gradients; a number only with
   ITEMS. */
#define TEXTURING_VIRTUAL 64u
/* Several samples a pixel: the same bits, in targets of other formats (texturing.glsl); the number has 32 bits, and with SLOPES a second word for
   these; with UV1 gradients have two targets. */
#define TEXTURING_SAMPLES 128u

struct gpu_texturing_geometry_push {
    STRUCT(gpu_geometry_push) geometry;
    ADDRESS(virtual_block) pages; /* of virtual texturing */
};

struct gpu_texturing_push {
    ADDRESS(view_block) view;
    ADDRESS(scene_block) scene;
    ADDRESS(lighting_block) lighting;
    ADDRESS(uint_array) counters;
    ADDRESS(virtual_block) pages;    /* of virtual texturing */
    uint targets[TEXTURING_TARGETS]; /* sampled */
    uint depth;                      /* sampled */
    uint radiance;                   /* storage */
    vec3 background;
};

/* Tells the surfaces of a pixel's samples apart. */
struct gpu_texturing_surfaces_push {
    ADDRESS(view_block) view;
    ADDRESS(uint_array) words;  /* as visible_surfaces_begin has them */
    ADDRESS(uint_array) sums;
    ADDRESS(uint_array) counts;
    uint targets[TEXTURING_TARGETS]; /* sampled */
    uint target_count;
    uint depth; /* sampled */
};

/* Shades them. */
struct gpu_texturing_samples_push {
    ADDRESS(view_block) view;
    ADDRESS(scene_block) scene;
    ADDRESS(lighting_block) lighting;
    ADDRESS(uint_array) counters;
    ADDRESS(virtual_block) pages;
    ADDRESS(uint_array) words;
    ADDRESS(uint_array) sums;
    ADDRESS(uint_array) entries;
    ADDRESS(uint_array) results;
    ADDRESS(uint_array) counts;      /* with counters: EDGES_… */
    uint targets[TEXTURING_TARGETS]; /* sampled */
    uint depth;                      /* sampled */
};

#endif
