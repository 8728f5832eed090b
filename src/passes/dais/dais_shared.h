/* SPDX-License-Identifier: MIT */
/** Deferred attribute interpolation: what C and GLSL share. */
#ifndef FNL_PASSES_DAIS_SHARED_H
#define FNL_PASSES_DAIS_SHARED_H

#include "passes/geometry/geometry_shared.h"
#include "shared.h"

/*
 * A reference stands for a stored triangle: the word of the pool where its record begins, plus one; 0 is nothing. DAIS_NO_ROOM: the pool
 * was full.
 */
#define DAIS_NO_ROOM 0x7fffffffu
/* In lists: a head (or a `next`) with this bit is a reference that covers the whole pixel; else it is a node's number, 0 the end. */
#define DAIS_FULL 0x80000000u
/* A head with all bits set: there was no room for one of the pixel's elements. */
#define DAIS_NO_LIST 0xffffffffu

/* Words of the counters. */
#define DAIS_WORDS 0u       /* of the pool that are taken */
#define DAIS_STORED 1u      /* records */
#define DAIS_FAILED 2u      /* records stored because a bucket stayed locked */
#define DAIS_OVERFLOW 3u    /* fragments for whose triangle or list element there was no room; if any, the frame is shaded forward */
#define DAIS_NODES 4u       /* list elements asked for */
#define DAIS_SAMPLES 5u     /* shading samples asked for */
#define DAIS_UNIQUE 6u      /* different triangles among the records; counted with light evaluations */
#define DAIS_SHADED 7u      /* triangle references shaded, each once a pixel; likewise */
#define DAIS_DISPATCH 8u    /* indirect dispatch over the records */
#define DAIS_SPAWNED 11u    /* indirect dispatch over the shading samples */
#define DAIS_COUNTS 16u

/* A record: item, triangle of the item, material, bits; then what the derivative pass finds of its attributes. */
#define DAIS_HEADER 4u
#define DAIS_UV0 1u
#define DAIS_UV1 2u
#define DAIS_TANGENT 4u
#define DAIS_COLOR 8u
#define DAIS_BIND 16u       /* position before the mesh deforms: for decals of its own */
#define DAIS_FRONT 32u
#define DAIS_MIRROR 64u
#define DAIS_REDUNDANT 128u /* stored because a bucket stayed locked */
#define DAIS_CORNERS 8u     /* shift */
#define DAIS_RECORD_MAX 61u /* words of the longest record */

#define DAIS_BUCKET 4u      /* words of a bucket: lock, newer reference, older reference, unused */
#define DAIS_ATTEMPTS 1024u /* to lock a bucket; then the triangle is stored once more */
#define DAIS_NODE 4u        /* words of a list element: next, reference, mask of samples, shading sample */

/* Values of the constant PROBE: what is written in place of radiance. */
#define DAIS_SHOW_RADIANCE 0u
#define DAIS_SHOW_POSITION 1u /* world space */
#define DAIS_SHOW_NORMAL 2u   /* interpolated */
#define DAIS_SHOW_UV 3u       /* the first set, and the level of a texture of 1024 texels a side */
#define DAIS_SHOW_DEPTH 4u    /* view depth from 1/w, from the depth buffer, and their relative difference */

/* Views for people; in the order of the last values of fnl_debug_view. */
#define DAIS_VIEW_ADDRESSES 0u /* a colour for each reference; white: no room */
#define DAIS_VIEW_TRIANGLES 1u /* how many different triangles a pixel shows: 1 grey, 2 green, 3 yellow, more red */
#define DAIS_VIEW_FAILURES 2u  /* red where a triangle was stored because its bucket stayed locked */

struct gpu_dais_visibility_push {
    STRUCT(gpu_geometry_push) geometry;
    ADDRESS(const_uint_array) indices; /* of the scene */
    ADDRESS(dais_words) pool;
    ADDRESS(dais_words) counts;
    ADDRESS(dais_words) cache;
    ADDRESS(dais_words) stored;        /* references in the order of their records' numbers */
    ADDRESS(dais_words) heads;         /* lists: a word a pixel, then, with shading samples, another one */
    ADDRESS(dais_words) nodes;
    ADDRESS(dais_words) samples;       /* shading samples: reference, pixel */
    uint bucket_mask;
    uint capacity;                     /* words of the pool */
    uint node_capacity;
    uint sample_capacity;
};

struct gpu_dais_derive_push {
    ADDRESS(view_block) view;
    ADDRESS(scene_block) scene;
    ADDRESS(const_uint_array) indices;
    ADDRESS(uint_array) pool;
    ADDRESS(uint_array) stored;
    ADDRESS(uint_array) counts;
    ADDRESS(uint_array) table;         /* of dais_unique: table_size words, a power of two */
    uint table_size;
    uint sample_capacity;
};

struct gpu_dais_shade_push {
    ADDRESS(view_block) view;
    ADDRESS(scene_block) scene;
    ADDRESS(lighting_block) lighting;
    ADDRESS(uint_array) counters;
    ADDRESS(uint_array) pool;
    ADDRESS(uint_array) heads;
    ADDRESS(uint_array) nodes;
    ADDRESS(uint_array) samples;
    ADDRESS(uint_array) results;       /* pixels times samples, slot by slot: two words of halves, or three floats */
    ADDRESS(uint_array) slots;         /* several samples: a word a pixel, which of its triangles each shows (samples_shared.h) */
    ADDRESS(uint_array) counts;
    uint references;                   /* sampled, without lists */
    uint shared_samples;               /* sampled, without lists: numbers of shading samples */
    uint target;                       /* storage: radiance with one sample, or the debug view */
    uint depth;                        /* sampled: for DAIS_SHOW_DEPTH */
    vec3 background;
    uint sample_capacity;              /* of the shading samples; views: 1 where the target wants blue first */
};

/* Makes the forward pass's draws empty where nothing overflowed: copies words, or puts 0 for each `place`-th of `stride`. */
struct gpu_dais_gate_push {
    ADDRESS(const_uint_array) counts;
    ADDRESS(const_uint_array) from;
    ADDRESS(uint_array) to;
    uint word_count;
    uint stride;
    uint place;
};

#endif
