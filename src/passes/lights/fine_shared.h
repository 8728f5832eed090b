/* SPDX-License-Identifier: MIT */
/** The steps of the fine-pruned tiles. */
#ifndef FNL_PASSES_FINE_SHARED_H
#define FNL_PASSES_FINE_SHARED_H

#include "shared.h"
#include "lighting/lighting_shared.h"

/* What a light in view covers of the screen. Nothing when rect.x > rect.z. */
struct gpu_fine_box {
    vec4 rect;           /* left, top, right, bottom in pixels from the top left, within the screen */
    vec2 depth;          /* nearest and farthest view depth */
    uint kind;           /* GPU_ENTITY_… */
};

/* The volume of a light in view, as pixels are tested against it: world space. */
struct gpu_fine_volume {
    vec3 position;
    float range;
    vec3 direction;
    uint kind;           /* GPU_SHAPE_…, and the number of the hull's planes << 8 */
    float spot_scale;
    float spot_offset;
    uint shape;          /* where the shape is, or GPU_NO_SHAPE */
    float radius;        /* of the sphere round all of it */
    vec3 center;
};

/*
 * View depths of the surfaces of a tile, near > far: there are none. Those of the opaque ones of all tiles come first; then, where they
 * are told apart, those of the blended ones: from the nearest of them to what is opaque behind.
 */
struct gpu_fine_range {
    float near;
    float far;
    uint sky;            /* 1: some pixel shows the sky; blended surfaces before it may stand at any depth */
};

/*
 * What the count keeps of a tile for the fill, in words: the survivors, up to `found` of them (longer lists are found again) and no fewer than
 * FINE_FOUND; a word that says how many words of lights were tested, or 0 where these were too many to keep masks; for each of `kept` such words the
 * bits of the survivors, and a mask for each square of pixels.
 */
#define FINE_FOUND 128u
#define FINE_FOUND_WORDS(found, kept, squares) ((found) + 1u + (kept) * (1u + (squares)))
/* Positions are known to this part of their distance from the world's origin and from the eye. */
#define FINE_SLACK 1e-5

/* A byte of gpu_fine_push.lists for each list of the build. */
#define FINE_LISTS 4 /* no fewer than kinds and one of blended surfaces */
#define FINE_MIN_DEPTH 1u  /* lights before the nearest surface of the tile are left out */
#define FINE_MAX_DEPTH 2u  /* … and those beyond the farthest, where no sky is */
#define FINE_PIXELS 4u     /* … and those that hold no pixel's position */
#define FINE_BLENDED 8u    /* of blended surfaces: those of a pixel lie on a segment of its ray */
#define FINE_KIND_SHIFT 4u /* two bits: GPU_ENTITY_… of the list */

struct gpu_fine_push {
    ADDRESS(view_block) view;
    ADDRESS(light_list_block) list;         /* of the first list */
    ADDRESS(const_uint_array) visible_sums; /* its element local_count is the number of lights in view */
    ADDRESS(const_uint_array) visible_ids;
    ADDRESS(bound_array) bounds;            /* fine bounds: their spheres; count and fill: their volumes */
    ADDRESS(fine_box_array) boxes;
    ADDRESS(fine_range_array) ranges;       /* one per tile */
    ADDRESS(uint_array) marks;              /* a bit for each light in view, for each block of tiles, for each list */
    ADDRESS(uint_array) found;              /* FINE_FOUND_WORDS of each cell */
    ADDRESS(uint_array) sums;               /* one per cell and one more: counts, then their prefix sum */
    ADDRESS(uint_array) overflow;           /* [0]: number of cells that did not fit */
    ADDRESS(uint_array) ids;                /* the pool */
    ADDRESS(uint_array) extra;              /* masks, then positions: see gpu_light_list; of fine bounds, the volumes */
    uint depth;                             /* bindless index of the depth image */
    uint front;                             /* … of that of the nearest blended surfaces */
    uint capacity;                          /* of the pool */
    uint block;                             /* tiles along a block's side */
    uint lists;                             /* a byte each */
};

#endif
