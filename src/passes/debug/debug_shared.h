/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_DEBUG_SHARED_H
#define FNL_PASSES_DEBUG_SHARED_H

#include "shared.h"
#include "lighting/lighting_shared.h"

/* Values of fnl_debug_view. */
#define GPU_DEBUG_NONE 0u
#define GPU_DEBUG_ALBEDO 1u
#define GPU_DEBUG_NORMAL 2u
#define GPU_DEBUG_DEPTH 3u
#define GPU_DEBUG_ROUGHNESS 4u
#define GPU_DEBUG_LIGHT_COUNT 5u
#define GPU_DEBUG_CELLS 6u
#define GPU_DEBUG_OVERDRAW 7u
#define GPU_DEBUG_TILE_NORMALS 8u
#define GPU_DEBUG_BACKFACES 9u
#define GPU_DEBUG_OVERSHADING 10u
#define GPU_DEBUG_LAYERS 11u
#define GPU_DEBUG_DECALS 12u
#define GPU_DEBUG_EDGES 20u /* those between are views of the G-buffer (shade/gbuffer.h) */
#define GPU_DEBUG_HALOS 22u /* after that of motion, which aa/motion.c draws */
#define GPU_DEBUG_COARSE 23u
#define GPU_DEBUG_COARSE_REASON 24u
#define GPU_DEBUG_CLUSTERS 28u
#define GPU_DEBUG_TRIANGLES 43u
#define GPU_DEBUG_DEPTH_JUMPS 44u
#define GPU_JUMP_LEAST 1.5f   /* ratio of depths in a tile from which on it has a color */
#define GPU_JUMP_OCTAVES 6.0f /* the ramp ends at 2 to this power */

/* Overshading is counted in parts of an invocation: four spread over one to four pixels without a rest. */
#define GPU_OVERSHADING_UNIT 3u

struct gpu_debug_push {
    ADDRESS(view_block) view;
    ADDRESS(light_list_block) lights;
    ADDRESS(uint_array) counts;   /* of debug_counts */
    ADDRESS(cone_array) cones;    /* of backface lists */
    uint albedo;                  /* sampled: base colour, roughness */
    uint normal;                  /* sampled: normal, view depth */
    uint position;                /* sampled: world position, draw item + 1 */
    uint target;                  /* storage */
    uint swap;                    /* 1: red and blue change places */
    uint mode;
    uint count_stride;            /* 0: no counts */
    uint has_cones;
    uint metal;                   /* sampled: metalness, luminance of the diffuse colour */
};

#endif
