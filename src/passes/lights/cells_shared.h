/* SPDX-License-Identifier: MIT */
/** The steps that tiled and clustered lists share: lights in view, bounds of cells, count, fill. */
#ifndef FNL_PASSES_CELLS_SHARED_H
#define FNL_PASSES_CELLS_SHARED_H

#include "shared.h"
#include "lighting/lighting_shared.h"

/* Fewest lights that one thread looks at for one cell; whole words of 32. */
#define CELL_CHUNK 256u
#define CELL_MARKED_CHUNK 1024u /* … where marks leave few of them */

/*
 * Far from the world's origin the way to view space rounds: bounding radii grow by this part of the distances of light and viewer
 * from the origin (a few units in the last place of a float).
 */
#define BOUND_ROUNDING 5e-7

/* A light in view space, as the cell tests want it. */
struct gpu_bound {
    vec3 center;
    float radius;
};

/* What a sphere alone says too loosely, one for each gpu_bound: view space, widened so that rounding loses nothing. */
struct gpu_reach {
    vec3 apex;           /* of the cone that holds a spot or a wedge */
    float range;         /* metres from the apex; 0: no cone, only the sphere bounds the light */
    vec3 axis;           /* unit */
    float cosine;        /* of the half angle, 0 .. 1 */
    float sine;
    float slack;         /* metres */
    vec2 low;            /* rectangle on the screen round the sphere: x and y divided by view depth (orthographic: x and y) */
    vec2 high;
};

struct gpu_lights_push {
    ADDRESS(view_block) view;
    ADDRESS(light_list_block) list;
    ADDRESS(uint_array) sums;      /* one per local light and one more: 1 for those in view, then their prefix sum */
    ADDRESS(uint_array) ids;       /* local lights in view, ascending */
    ADDRESS(bound_array) bounds;   /* of the lights in ids */
    ADDRESS(reach_array) reaches;  /* of the same */
    uint light_count;              /* local lights */
    uint cull;                     /* 0: all count as in view that reach anything */
    uint kinds;                    /* bits 1 << GPU_ENTITY_…: the others are left out */
    uint reach;                    /* 1: reaches are asked for */
};

struct gpu_cells_push {
    ADDRESS(view_block) view;
    ADDRESS(light_list_block) list;
    ADDRESS(bounds_array) cells;   /* bounds */
    ADDRESS(const_uint_array) visible_sums; /* its element light_count is the number of lights in view */
    ADDRESS(const_uint_array) visible_ids;
    ADDRESS(bound_array) bounds;
    ADDRESS(reach_array) reaches;
    ADDRESS(uint_array) sums;      /* cell * chunk_count + chunk, and one more: counts, then their prefix sum */
    ADDRESS(uint_array) ids;       /* the pool; for the count, what it keeps (CELLS_KEPT) */
    ADDRESS(uint_array) extra;     /* what else the kind of list needs: see gpu_light_list */
    ADDRESS(uint_array) overflow;  /* [0]: number of cells that did not fit */
    ADDRESS(uint_array) marks;     /* a bit for each light in view, for each block of cells; or 0; for the fill, what the count kept */
    uint cell_count;
    uint chunk_size;               /* lights that one thread looks at */
    uint chunk_count;
    uint capacity;                 /* of the pool */
    uint depth;                    /* tiles: bindless index of the depth image, or GPU_NO_DEPTH */
    uint front;                    /* tiles: bindless index of the depth of the nearest blended surfaces, or GPU_NO_DEPTH */
    uint first_cell;               /* mark, count and fill: of this dispatch */
    uint first_chunk;
};

/*
 * A box of neighbouring cells of the grid: `side` by `side` tiles times CELLS_BLOCK_SLICES slices. Lights that do not touch it touch none of its
 * cells, by any of the tests.
 */
struct gpu_cell_block {
    STRUCT(gpu_cell_bounds) bounds; /* planes of the cells at its edges, boxes of all together */
    vec4 inner[4];               /* planes of the same sides of the cells at the opposite edges */
    uint all;                    /* 1: a cell has bounds that are not numbers; every light touches */
};
#define CELLS_BLOCK_SLICES 4u

struct gpu_spare_push {
    ADDRESS(view_block) view;
    ADDRESS(light_list_block) list;
    ADDRESS(const_uint_array) visible_sums; /* one per local light and one more */
    ADDRESS(bound_array) bounds;            /* of the lights in view */
    ADDRESS(const_uint_array) overflow;     /* [0]: number of cells that did not fit */
    ADDRESS(uint_array) spare;
    uint light_count;
    uint always;                            /* 1: the list is made whether cells overflow or not */
};

#define GPU_NO_DEPTH 0xffffffffu
/* Specialisation constants of mark, count and fill, beside the kind of list: flags; tiles along a block's side, 0: lights are not marked. */
#define CELLS_FLAGS_ID 1u
#define CELLS_BLOCK_ID 2u
#define CELLS_MIN_DEPTH 1u         /* flags: lights nearer than the nearest pixel of the tile are left out */
#define CELLS_MAX_DEPTH 2u         /* … and those beyond the farthest */
#define CELLS_CONES 4u             /* spots and wedges are tested as cones, once their sphere touches */
#define CELLS_PLANES 8u            /* spheres are tested against planes alone, not against the box */
#define CELLS_RECTANGLE 16u        /* … by their rectangle on the screen and their depth range */
#define CELLS_MASKS 32u            /* extra holds a mask of occupied depth cells for each cell; lights must touch one of them */
#define CELLS_RANGES 64u           /* extra gets a depth range for each entry */
#define CELLS_KEPT 128u            /* the count keeps which lights each cell takes, and the fill makes no tests */

#endif
