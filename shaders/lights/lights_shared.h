/* SPDX-License-Identifier: MIT */
/** Lights, and the lists that say which of them reach a pixel. */
#ifndef FNL_SHADERS_LIGHTS_SHARED_H
#define FNL_SHADERS_LIGHTS_SHARED_H

#include "shared.h"

#define GPU_LIGHT_DIRECTIONAL 0u /* the values of fnl_light_kind */
#define GPU_LIGHT_POINT 1u
#define GPU_LIGHT_SPOT 2u

/* Directional lights come first in the light array; all others follow and are what lists index. */
struct gpu_light {
    vec3 position;       /* world space */
    float range;         /* metres; exactly no light from here on */
    vec3 color;          /* colour times intensity: cd, or lux */
    uint kind;
    vec3 direction;      /* unit, where it shines to */
    float spot_scale;    /* angular ramp of KHR_lights_punctual: sat(cos * scale + offset)^2 */
    float spot_offset;
    vec3 bound_center;   /* world-space sphere that holds everything that is lit */
    float bound_radius;
};

/* How a pixel finds its lights; a specialisation constant of every shader that iterates. */
#define GPU_LIST_ALL 0u     /* every light, every pixel: the oracle */
#define GPU_LIST_TILES 1u   /* cells of the screen */
#define GPU_LIST_CLUSTERS 2u /* cells of the screen times slices of depth */

/* count of a cell whose list did not fit into the pool: all lights are used instead. */
#define GPU_CELL_ALL 0xffffffffu

struct gpu_cell {
    uint offset;         /* into ids */
    uint count;          /* or GPU_CELL_ALL */
};

struct gpu_light_list {
    uint directional_count;
    uint local_count;    /* lights that are not directional */
    uint tile_size;      /* pixels */
    uint tiles_x;
    uint tiles_y;
    uint slices;         /* 1 for tiles */
    float slice_scale;   /* slice = log2(view depth) * scale + bias, clamped */
    float slice_bias;
    ADDRESS(light_array) lights; /* directional ones first */
    ADDRESS(cell_array) cells;   /* x fastest, then y, then slice */
    ADDRESS(const_uint_array) ids; /* ascending in each cell; 0 is the first local light */
};

#endif
