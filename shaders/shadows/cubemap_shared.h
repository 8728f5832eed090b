/* SPDX-License-Identifier: MIT */
/**
 * Local cubemap shadows: what light the walls of a room let in, as a cube map that was taken from one point of it (S. Bala and R. Lopez Mendez, "Efficient
 * Soft Shadows Based on Static Local Cubemap", *GPU Pro 7*, 2016). RGB is the colour of what comes through, A the part of it: 0 opaque, 1 open.
 */
#ifndef FNL_SHADERS_CUBEMAP_SHARED_H
#define FNL_SHADERS_CUBEMAP_SHARED_H

#include "shared.h"

#define PROBES_MOST 32u /* that shadows are found by */

/* gpu_probes.flags */
#define PROBES_PHYSICAL 1u /* lod by the size of the light; else by gpu_probe.softness */
#define PROBES_CORRECT 2u  /* the look-up is corrected for where the surface is in the box */
#define PROBES_TINT 4u
#define PROBES_INSIDE 8u   /* a ray finds what is in the room */
#define PROBES_MOVERS 16u  /* some item is in `moving`: a ray finds it */

/* In the space of the box: metres, the centre is the origin, the axes are those of its faces and of the cube map. */
struct gpu_probe {
    vec4 rows[3];   /* world to it */
    vec3 half_size;
    float wall;     /* metres from the faces, on either side, that belong to the wall */
    vec3 capture;   /* where the cube map was taken */
    float softness; /* levels a metre */
    uint image;     /* sampled index of the cube map */
    uint side;      /* texels of a face */
};

struct gpu_probes {
    ADDRESS(probe_array) probes;
    ADDRESS(const_uint_array) moving; /* a bit for each draw item that casts its shadow by rays */
    uint count;
    uint smooth_sampler;
    uint flags;
};

#endif
