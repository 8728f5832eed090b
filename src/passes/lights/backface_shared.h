/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_BACKFACE_SHARED_H
#define FNL_PASSES_BACKFACE_SHARED_H

#include "shared.h"
#include "gbuffer_shared.h"

/* Holds the normals of all surfaces in a tile. */
struct gpu_cone {
    vec3 axis;           /* world space, unit */
    float sine;          /* of the half angle; from 1 on nothing is dropped */
    uint dropped;        /* lights that touch the tile but lie behind all of its surfaces */
    uint keeps;          /* 1: they stay in its list, which is not worth the work */
};
#define BACKFACE_WIDE 2.0f

/* Picked tiles are dispatched as so many groups in a row. */
#define BACKFACE_ROW 16u
#define BACKFACE_ROWS 65535u

#define BACKFACE_AXIS_SAMPLES 0u /* values of backface_axis */
#define BACKFACE_AXIS_SUM 1u
#define BACKFACE_AXIS_PYRAMID 2u

struct gpu_backface {
    STRUCT(gpu_gbuffer) gbuffer;   /* its depth and normals */
    ADDRESS(cone_array) cones;
    ADDRESS(uint_array) picks;     /* a dispatch: row, rows, 1; then the number of picked tiles, and these */
    ADDRESS(axis_array) blocks;    /* sums of the normals of 4 x 4 pixels, for BACKFACE_AXIS_PYRAMID */
    ADDRESS(axis_array) axes;      /* sums of the normals of each tile, for BACKFACE_AXIS_PYRAMID */
    ADDRESS(uint_array) marks;     /* of each light in view: bit 0 behind a tile's surfaces, bit 1 not behind another's */
    ADDRESS(uint_array) tally;     /* [0]: lights behind the surfaces of every tile they touch */
    uint axis;                     /* BACKFACE_AXIS_… */
    uint least;                    /* tiles with fewer lights, or a third as many behind four of their pixels, keep their lights */
    uint every_tile;               /* 1: cones are found even so */
    uint marking;
};

#endif
