/* SPDX-License-Identifier: MIT */
/** How a picture of the surroundings becomes light. Texels lie mip by mip, in each of them the faces +X -X +Y -Y +Z -Z in rows from the top left. */
#ifndef FNL_PASSES_ENVIRONMENT_MAPS_SHARED_H
#define FNL_PASSES_ENVIRONMENT_MAPS_SHARED_H

#include "shared.h"

#define ENVIRONMENT_TABLE_SIDE 64u    /* of the table of reflectance: its texels are at (n.v, roughness) = (x, y) / 63 */
#define ENVIRONMENT_TABLE_SAMPLES 512u
#define ENVIRONMENT_LIGHT_THREADS 64u
#define ENVIRONMENT_ROUGHNESS_POWER 1.5f /* mip m of the last is for roughness (m / last)^1.5 */

/* A mip of the cube map from the picture: each texel is the mean of taps x taps places. */
struct gpu_environment_faces_push {
    ADDRESS(texel_array) texels;
    uint picture;       /* sampled: longitude by latitude, +Y at the top; +X in the middle, +Z a quarter to the right */
    uint sampler_index; /* wraps around */
    uint side;
    uint taps;
};

/* What a camera has seen in the direction of a face. */
struct gpu_reflections_face_push {
    ADDRESS(radiance_array) radiances; /* of all faces */
    ADDRESS(uint_array) peak;          /* the bits of the largest component, of all faces */
    uint picture;                      /* sampled; side x side */
    uint sampler_index;
    uint side;
    uint face;
};

/* The first mip from what was seen, as fractions of a power of two that the largest of them fits: halves alone hold 1e-7 .. 65504 cd/m^2. */
struct gpu_reflections_pack_push {
    ADDRESS(radiance_array) radiances;
    ADDRESS(uint_array) peak;
    ADDRESS(texel_array) texels;
    uint count;
};

/* A mip from the one before. */
struct gpu_environment_level_push {
    ADDRESS(texel_array) texels;
    uint from, to; /* first texels */
    uint side;     /* of the smaller one */
};

/* A mip for one roughness. */
struct gpu_environment_filter_push {
    ADDRESS(texel_array) texels;
    uint first; /* texel */
    uint side;
    uint cube;  /* sampled, with mips */
    uint sampler_index;
    uint samples;
    uint cube_side;
    float alpha;
};

/* The irradiance of nine spherical harmonics, from one mip. */
struct gpu_environment_light_push {
    ADDRESS(texel_array) texels;
    ADDRESS(environment_block) light;
    ADDRESS(uint_array) peak; /* texels are fractions (gpu_reflections_pack_push); 0: they are cd/m^2 */
    uint first;               /* texel */
    uint side;
};

struct gpu_environment_table_push {
    ADDRESS(texel_array) texels; /* halves: what f0 and f90 are multiplied by; the mip of the cube; 0 */
    float last_mip;              /* for roughness 1 */
};

#endif
