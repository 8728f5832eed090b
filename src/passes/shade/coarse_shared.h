/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_COARSE_SHARED_H
#define FNL_PASSES_COARSE_SHARED_H

#include "gbuffer_shared.h"

/* Values of fnl_coarse_criterion and fnl_coarse_split. */
#define COARSE_CRITERION_Z 0u
#define COARSE_CRITERION_ID 1u
#define COARSE_CRITERION_MINMAX 2u
#define COARSE_SPLIT_NONE 0u
#define COARSE_SPLIT_ALBEDO 1u
#define COARSE_SPLIT_HIGHLIGHTS 2u
#define COARSE_SPLIT_SHARP 3u

/* Flags of the shaders. */
#define COARSE_COLOR 1u    /* blocks read a base colour of their own */
#define COARSE_GATHER 2u   /* what blocks share is kept until the other pixels are done, and written then */
#define COARSE_WORDS 4u    /* each pixel's kind goes to gpu_coarse_push.words */
#define COARSE_SAMPLERS 8u /* criterion minmax: ranges come from samplers */
#define COARSE_AO 16u      /* gpu_coarse_push.ao is read */
#define COARSE_MEAN 32u    /* blocks have the mean of their pixels' base colours */
#define COARSE_ALBEDO 64u  /* base colours are compared */
#define COARSE_FOVEA 128u  /* the angle from where the viewer looks decides, not what a block shows */

/* What a block is, or, as debug views show it, each of its pixels. */
#define COARSE_NOTHING 0u /* shows no surface */
#define COARSE_SHARED 1u  /* is shaded once */
#define COARSE_DEPTH 2u   /* shaded by pixels: depths, or triangles, are too different */
#define COARSE_NORMAL 3u
#define COARSE_OTHER 4u   /* roughness, metalness, occlusion, F0 or base colour are */
#define COARSE_EACH 5u    /* shaded by pixels: the viewer looks there */
#define COARSE_HALF 6u    /* of 4x4: quads of 2x2 are shaded once each */
#define COARSE_KINDS 7u

/* Counts of a frame: blocks of each kind that show a surface, then pixels that do, for how many pixels, quads and blocks work is done, and how often
   occlusion was found. */
#define COARSE_COUNT_PIXELS 7u
#define COARSE_COUNT_SHADED 8u
#define COARSE_COUNT_AO 9u
#define COARSE_COUNTS 10u

#define COARSE_GROUP 64u /* threads, each of one block */

/* gpu_coarse_push.blocks has a word for each block, 64 for each tile of 8 x 8: its kind, how many of its pixels, and of its quads of 2x2 less one,
   show a surface; in the n-th word of a tile the number, within the tile, of the n-th block whose pixels are lit each, or behind these, whose quads
   are; in the first word how many such blocks there are of both. */
#define COARSE_WORD_KIND 7u
#define COARSE_WORD_PIXELS_SHIFT 3u
#define COARSE_WORD_PIXELS 31u
#define COARSE_WORD_FINE_SHIFT 8u
#define COARSE_WORD_FINE 63u
#define COARSE_WORD_QUADS_SHIFT 14u
#define COARSE_WORD_QUADS 3u
#define COARSE_WORD_COUNT_SHIFT 16u
#define COARSE_WORD_HALVES_SHIFT 23u
#define COARSE_WORD_COUNT 127u

struct gpu_coarse_settings {
    float depth_bound;      /* of differences of the view depth: times the sum of the gradient's parts */
    float normal_chord;     /* greatest distance of two normals */
    float tolerance;        /* of roughness, metalness, occlusion, F90 and the root of F0 */
    float albedo_tolerance; /* of base colours */
    float ao_radius;        /* metres */
    uint least, greatest;   /* samplers: of a range */
    uint point;             /* sampler: of texels as they are */
    vec3 gaze;              /* where the viewer looks: unit vector in view space */
    float fovea, fovea_far; /* cosines of angles from there, within which each pixel, or quad, is shaded */
};

#ifdef GL_core_profile
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer coarse_settings_block { gpu_coarse_settings settings; };
#endif

struct gpu_coarse_push {
    ADDRESS(lighting_block) lighting;
    ADDRESS(uint_array) counters; /* of lights; of the pass for occlusion: COARSE_COUNTS */
    STRUCT(gpu_gbuffer) gbuffer;
    ADDRESS(coarse_settings_block) settings;
    ADDRESS(uint_array) blocks; /* COARSE_WORD_… */
    ADDRESS(uint_array) words;  /* a COARSE_… kind for each pixel */
    uint target;                /* storage: radiance, with emission in it and gradients in its alpha; or openness out */
    uint color;                 /* sampled: base colour of blocks */
    uint geometry;              /* sampled: ids, criterion id */
    uint azimuth, height;       /* sampled: criterion minmax */
    uint ao;                    /* sampled: openness */
};

struct gpu_coarse_tiles_push {
    ADDRESS(uint_array) blocks, counts; /* COARSE_WORD_…; COARSE_COUNTS */
    uint tile_count;
};

#endif
